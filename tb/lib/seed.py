"""The seed of whatever a run draws: that of the environment's SEED; without it the same in every run."""

import os

__all__ = ["IS_DRAWN", "SEED"]

IS_DRAWN = "SEED" in os.environ
SEED = int(os.environ.get("SEED", "1"))

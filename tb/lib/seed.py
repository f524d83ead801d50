"""What a run draws: by the environment's SEED, without it the same in every run; of campaigns as much as in one night,
or in NIGHTS of them.
"""

import os

__all__ = ["IS_DRAWN", "NIGHTS", "SEED"]

IS_DRAWN = "SEED" in os.environ
SEED = int(os.environ.get("SEED", "1"))
NIGHTS = int(os.environ.get("NIGHTS", "1"))

"""What the smallest engine and its clusters are made of."""

from functools import cache

from golden.engine.config import PRESETS
from hw.cluster import Cluster
from hw.engine import Engine
from hw.lib.black_box import BlackBox
from tb.docs.structure import Structure, structures

__all__ = ["tiny_structures"]


@cache
def tiny_structures() -> dict[type, Structure]:
    """Of all components of preset ``tiny``, by class."""
    config = PRESETS["tiny"]
    return structures([lambda: Engine(config=config, black_boxes=True), lambda: Cluster(config=config)],
                      stands_for={BlackBox: Cluster})

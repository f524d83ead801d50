"""Rays of a shell for cell traversal, and the cells that golden meets with them."""

from types import SimpleNamespace

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import NEVER, POSITION_FRACTION, Traversal
from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.stimulus.ctu.cell_traversal import BLOCK
from tb.lib.vectors import Vectors

__all__ = ["ONE", "RAYS", "long_rays", "rays"]

RAYS = 120
# A cell, in units of a position.
ONE = 1 << POSITION_FRACTION


def rays(config: Config, given: dict) -> Vectors:
    """Rays of one shell, and in ``about`` the cells that golden meets with them, and how many items each ray has."""
    items = [{"tag": number, "direction": direction, "begin": int(given["begin"]),
              "length": int(given["end"] - given["begin"])}
             for number, direction in enumerate(given["direction"].tolist())]
    traversal = Traversal(given["place"], given["direction"], begin=int(given["begin"]), end=int(given["end"]),
                          shape=given["shape"])
    steps = np.zeros(len(items), dtype=int)
    while len(traversal.ray):
        steps[traversal.ray] += 1
        traversal.advance()
    return Vectors(
        inputs={"i": items}, expected={"o": [None] * int(np.maximum(steps, 1).sum())},
        ports={"origin": given["place"].tolist(), "shape": given["shape"].tolist()}, about=SimpleNamespace(
            cells=[[cell for cell in row if cell >= 0] for row in BLOCK.expect(given, config)["cells"].tolist()],
            items=np.maximum(steps, 1).tolist()))


def long_rays(config: Config, *, side: int = 18, along: float = 0) -> Vectors:
    """From the middle of a grid to its border; components are up to 2^``along`` times smaller than others."""
    random = np.random.default_rng(5)
    direction = random.normal(size=(RAYS, 3)) * 2.0 ** -random.uniform(0, along, (RAYS, 3))
    direction = np.rint(direction / np.linalg.norm(direction, axis=1)[:, None] * (1 << FRACTION)).astype(np.int64)
    return rays(config, {"place": (side // 2 - np.arange(3)) * ONE + 1234, "shape": side - np.arange(3),
                         "begin": np.array(0), "end": np.array(NEVER), "direction": direction})

"""Illuminance and radiosity of patches, as a table."""

import csv
from pathlib import Path

import numpy as np

from golden.base.output import whole_file
from golden.light.indirect import IndirectLight
from golden.light.photometry.quantities import lux
from golden.scene.scene import Scene

__all__ = ["patch_rows", "write_table"]

_COLUMNS = ("patch", "side", "name", "area", "x", "y", "z", "illuminance", "radiosity")


def patch_rows(scene: Scene, indirect: IndirectLight, efficacy: float) -> list[tuple]:
    """The table: a head, then a row for the front of each patch, and one for the back of each two-sided patch.

    ``name`` is that of the material, (x, y, z) the patch's centre. ``illuminance`` in lux and ``radiosity`` (luminous
    exitance: what the side emits and reflects) in lm/m2 are means over its elements, weighted by area.

    Parameters
    ----------
    scene, indirect
        The patches, and the light of their elements.
    efficacy
        Luminous efficacy, lm/W.
    """
    elements = indirect.elements
    side = 2 * elements.patch + ~elements.front
    area = np.bincount(side, elements.area, 2 * len(scene))
    values = [np.bincount(side, elements.area * lux(light, efficacy), len(area)) / np.where(area > 0, area, 1)
              for light in (indirect.received, indirect.radiosity)]
    rows = []
    for number in np.flatnonzero(area > 0).tolist():
        patch, is_back = divmod(number, 2)
        rows.append((patch, "back" if is_back else "front", scene.materials[scene.material[patch]].name,
                     float(scene.areas[patch]), *scene.centres[patch].tolist(),
                     *(float(value[number]) for value in values)))
    return [_COLUMNS, *rows]


def write_table(path: Path, rows: list[tuple]) -> None:
    """Write rows, the first of them names, as a .csv."""
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)

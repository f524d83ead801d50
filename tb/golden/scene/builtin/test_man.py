"""The figure hangs together."""

import numpy as np

from golden.scene.builtin.man import GROUND, man
from tb.golden.scene.builtin.solids import components


def test_parts_of_the_figure_reach_into_each_other():
    """Each wooden part's box meets another's, from the soles on the stage to head and hands."""
    scene = man()
    wooden = np.isin(scene.material, [scene.materials.index(material) for material in scene.materials
                                      if material.name in ("beech", "joint")])
    figure = wooden & (scene.vertices[:, :, 0].max(axis=1) < 0.75)
    parts = components(scene.vertices[figure])
    boxes = np.array([(part.min(axis=(0, 1)), part.max(axis=(0, 1))) for part in parts])
    meets = ((boxes[:, None, 0] <= boxes[None, :, 1]) & (boxes[:, None, 1] >= boxes[None, :, 0])).all(axis=-1)
    reached = np.eye(len(parts), dtype=bool)[0]
    for _ in parts:
        reached = meets[reached].any(axis=0)
    assert reached.all()
    assert len(parts) == 3 + 14 + 8 + 2 + 2 + 20
    assert 0 < boxes[:, 0, 2].min() - GROUND < 0.01
    assert 1.7 < boxes[:, 1, 2].max() - GROUND < 2.1

import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from golden.cast.shared_caster import shared_caster
from golden.scene.scene import Scene
from tb.golden.light.cube import cube

ARRAYS = ("vertices", "material", "surface", "smooth", "two_sided", "is_triangle", "centres", "area_vectors", "areas",
          "normals", "is_curved", "bounds")


@pytest.mark.parametrize("made", [lambda scene: scene, lambda scene: replace(scene, name="other"),
                                  lambda scene: scene.with_parts(np.arange(3)),
                                  lambda scene: pickle.loads(pickle.dumps(scene))],
                         ids=["made", "replaced", "parts", "sent"])
def test_nobody_edits_a_scene(made):
    """Grid, bounds and areas are those of the patches: an edit in place would give pictures of nothing."""
    scene = made(cube(1))
    for name in ARRAYS:
        with pytest.raises(ValueError, match="read-only"):
            getattr(scene, name)[...] = 0


def test_the_arrays_of_which_a_scene_is_made_stay_their_owner_s():
    given = {name: getattr(cube(1), name).copy() for name in ("vertices", "material", "surface", "smooth", "two_sided")}
    scene = Scene(name="given", materials=cube(1).materials, **given)
    before = {name: value.copy() for name, value in given.items()}
    for name, value in given.items():
        value[...] += 1000 if value.dtype != bool else True
        np.testing.assert_array_equal(getattr(scene, name), before[name])


def test_what_follows_from_a_scene_is_not_sent_with_it():
    scene = cube(1)
    plain = pickle.dumps(scene)
    assert scene.areas.sum() > 0
    shared_caster(scene, "grid")
    assert pickle.dumps(scene) == plain
    assert vars(pickle.loads(plain)).keys() == {one.name for one in fields(Scene)}

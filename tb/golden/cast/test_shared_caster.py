import gc
import weakref

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast import shared_caster as module
from golden.cast.default_camera import default_camera
from golden.cast.methods import RAY_METHODS, ray_caster
from golden.cast.shared_caster import SHARED, default_method, shared_caster
from golden.engine.cast.methods import FRUSTUM_METHODS, frustum_caster
from tb.golden.light.cube import cube


@pytest.mark.parametrize("method", SHARED)
def test_a_scene_has_one_caster_whoever_casts_and_by_how_many_threads(monkeypatch, method):
    made = []
    make = SHARED[method]
    monkeypatch.setitem(SHARED, method, lambda *given, **more: made.append(make(*given, **more)) or made[-1])
    scenes = cube(2), cube(1)
    for scene in scenes * 2:
        assert scene.camera is None
        default_camera(scene)
        casters = [ray_caster(scene, method, jobs=1), frustum_caster(scene, method, jobs=3),
                   shared_caster(scene, method)]
        assert [caster.jobs for caster in casters[:2]] == [1, 3]
        assert len({id(caster.oracle) for caster in casters}) == 1
    assert len(made) == len(scenes)


@pytest.mark.parametrize("method", SHARED)
def test_a_caster_lives_no_longer_than_its_scene(method):
    scene = cube(1)
    caster, scene_ = weakref.ref(shared_caster(scene, method)), weakref.ref(scene)
    del scene
    gc.collect()
    assert (caster(), scene_()) == (None, None)


@pytest.mark.parametrize("method", FRUSTUM_METHODS)
def test_threads_are_a_number_for_every_method(method):
    """Whether it has threads or not."""
    for jobs in (0, -1, 257, True, 2.0, "2"):
        for caster in (frustum_caster, *([ray_caster] if method in RAY_METHODS else [])):
            with pytest.raises(InputError, match="Jobs must be 1 to 256, not"):
                caster(cube(1), method, jobs=jobs)


def test_numpy_s_numbers_are_numbers():
    assert shared_caster(cube(1), "grid", np.int64(2)).jobs == 2


def test_grid_casts_where_embree_is_missing(monkeypatch):
    for there, method in ((True, "embree"), (False, "grid")):
        monkeypatch.setattr(module, "has_embree", lambda there=there: there)
        assert default_method() == method

"""`--memory` bounds the rays that are cast at once."""

import gc
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from golden.light.in_flight import PRIMARY_BYTES, SHADOW_BYTES, InFlight
from golden.light.pixels import Pixels
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin import builtin_scene

SIDE = 256


@pytest.mark.parametrize(("memory", "threads"), [(64, 1), (640, 5)])
def test_half_of_the_memory_is_for_rays_with_successors_and_half_for_others(memory, threads):
    made = InFlight.of(memory, shares=False, threads=threads)
    half = memory * 2**19 / threads
    for count, bytes_of in ((made.primary, PRIMARY_BYTES), (made.generation, PRIMARY_BYTES),
                            (made.shadow, SHADOW_BYTES), (made.gather, SHADOW_BYTES)):
        assert half - bytes_of < count * bytes_of <= half
    assert made == InFlight.of(memory, shares=True, threads=threads)


@pytest.fixture
def peak(monkeypatch):
    """Bytes that casting the pixels of a picture has taken at a time."""
    found, cast = [], Pixels.cast

    def traced(*given):
        gc.collect()
        tracemalloc.start()
        try:
            return cast(*given)
        finally:
            found.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()

    monkeypatch.setattr(Pixels, "cast", traced)
    return lambda: found.pop()


@pytest.mark.parametrize("name", ["balls", "cornell"])
def test_a_picture_keeps_its_bound_and_is_the_same(peak, name):
    """Of mirrors and glass, with four times the rays that may be in flight; and of light that is gathered."""
    scene = builtin_scene(name)
    settings = RenderSettings(width=SIDE, height=SIDE, light_samples=16, samples=1, rays=(16, 8), elements=50, jobs=1,
                              method="grid")
    free = render(scene, camera=scene.camera, settings=settings)
    taken = peak()
    bound = render(scene, camera=scene.camera, settings=replace(settings, memory=64))
    assert taken > 64 * 2**20 >= peak() > 32 * 2**20
    np.testing.assert_allclose(bound.image, free.image, rtol=1e-12)
    assert bound.stats["rays"] == free.stats["rays"]


@pytest.mark.parametrize("memory", [63, 2**20 + 1, True, 64.5])
def test_memory_is_a_whole_number_of_megabytes(memory):
    with pytest.raises(ValueError, match="Memory must be"):
        RenderSettings(memory=memory)

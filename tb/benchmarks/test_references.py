"""Rendered pictures against the stored ones of a path tracer, and how they are compared."""

import numpy as np
import pytest

from benchmarks.references import BLOCK, HEIGHT, NOISE, SCENES, THROWN, WIDTH, Reference, compare, rendered
from golden.render.two_pass import RenderSettings, render

QUICK = ("terrace, clear sky and sun",)


def flat(*, thrown=0.0):
    blocks = HEIGHT // BLOCK, WIDTH // BLOCK
    shares = np.zeros(blocks)
    shares[0, 0] = thrown
    return Reference(image=np.ones((HEIGHT, WIDTH, 3)), noise=np.zeros(blocks), thrown=shares, samples=1)


def test_blocks_and_means_are_differences_relative_to_the_reference():
    image = np.ones((HEIGHT, WIDTH, 3))
    image[:BLOCK, :BLOCK, 1] = 0.5
    found = compare(image, flat())
    assert found.worst == pytest.approx(-0.5)
    assert found.mean == pytest.approx([0, -0.5 * BLOCK**2 / (HEIGHT * WIDTH), 0])
    assert found.masked == 0


def test_a_block_lit_through_bodies_of_glass_does_not_count():
    image = np.ones((HEIGHT, WIDTH, 3))
    image[:BLOCK, :BLOCK] = 0.5
    found = compare(image, flat(thrown=1.1 * THROWN))
    assert found.worst == 0
    assert not found.mean.any()
    assert found.masked == pytest.approx(BLOCK**2 / (HEIGHT * WIDTH))
    assert compare(image, flat(thrown=0.9 * THROWN)).masked == 0


@pytest.mark.parametrize("name", SCENES)
def test_the_references_are_stored_with_little_noise(name):
    """A quarter of what a block may differ by."""
    reference = Reference.stored(name)
    assert reference.image.shape == (HEIGHT, WIDTH, 3)
    assert reference.noise[reference.thrown <= THROWN].max() <= NOISE
    assert reference.thrown.any() == bool(SCENES[name].balls)


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@pytest.mark.parametrize("name", SCENES)
def test_pictures_are_those_of_the_path_tracer(name):
    found = compare(rendered(name), Reference.stored(name))
    assert np.abs(found.mean).max() < 0.01, found
    assert abs(found.worst) < 0.04, found


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@pytest.mark.parametrize("name", [pytest.param(name, marks=[] if name in QUICK else pytest.mark.nightly)
                                  for name in SCENES])
def test_pictures_have_the_same_bytes_for_any_number_of_threads(name):
    """With panes, mirrors, glass, skies, the sun, textures and luminaires."""
    scene = SCENES[name].make()
    one, two, three = (render(scene, camera=scene.camera, settings=RenderSettings(
        width=24, height=16, samples=1, light_samples=2, depth=3, rays=(16, 8), max_edge=1.0, jobs=jobs)).image
        for jobs in (1, 2, 3))
    assert one.any()
    assert one.tobytes() == two.tobytes() == three.tobytes()

"""The rendered Cornell box against a path-traced one (tb/golden/light/reference/path_trace.py)."""

from pathlib import Path

import numpy as np
import pytest

from golden.cast.naive import Naive
from golden.cast.screen import Screen
from golden.light.image import write_exr
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin import builtin_scene

SIZE, BLOCK = 128, 8


def rendered(**elements):
    """Ours and the reference."""
    scene = builtin_scene("cornell")
    settings = RenderSettings(width=SIZE, height=SIZE, samples=16, **elements)
    with np.load(Path(__file__).parent / "reference" / "cornell.npz") as stored:
        return render(scene, camera=scene.camera, settings=settings).image, stored["image"].astype(np.float64)


@pytest.fixture(scope="module")
def images():
    return rendered()


@pytest.fixture(scope="module")
def lamp():
    """Pixels in which the lamp is seen. It is up to a thousand times as bright as what surrounds it, so how much of it
    16 samples catch at its border is noise beside which nothing else shows.
    """
    scene = builtin_scene("cornell")
    screen = Screen(camera=scene.camera, width=SIZE, height=SIZE)
    across, down = (grid.ravel() for grid in np.meshgrid(*[np.linspace(-0.5, 0.5, 5)] * 2))
    upper = SIZE * SIZE // 4
    pixels, offsets = np.repeat(np.arange(upper), 25), np.tile(np.stack([across, down], axis=1), (upper, 1))
    patch = Naive(scene).nearest(screen.rays(pixels, offsets)).patch
    shines = (patch >= 0) & scene.channels("emission").any(axis=1)[patch]
    seen = np.zeros((SIZE, SIZE), dtype=bool)
    seen.flat[pixels[shines]] = True
    assert 30 < seen.sum() < 200
    return seen


def sums(image, lamp):
    """Sums over the blocks, without the pixels of the lamp: 16 x 16 x 3."""
    dark = np.where(lamp[..., None], 0, image)
    return dark.reshape(SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, 3).sum(axis=(1, 3))


def assert_small(error, limit, images, tmp_path):
    if np.abs(error).max() > limit:
        for name, image in zip(("ours", "reference", "difference"), (*images, images[0] - images[1]), strict=True):
            write_exr(tmp_path / f"{name}.exr", image, white=1.0)
        pytest.fail(f"{np.abs(error).max():.4f} is above {limit}; pictures in {tmp_path}")


def test_the_mean_of_each_channel_is_that_of_the_reference(tmp_path):
    """Larger elements than by default change it by 0.1 %. The border of the lamp alone gives a noise of 0.3 %."""
    images = rendered(max_edge=40.0)
    ours, reference = (image.mean(axis=(0, 1)) for image in images)
    assert_small(ours / reference - 1, 0.01, images, tmp_path)


@pytest.mark.nightly
def test_blocks_of_the_picture_are_those_of_the_reference(images, lamp, tmp_path):
    """The noise of a block is 0.4 %, 3 % at most in a shadow's border. What goes beyond it comes from the elements: the
    light close to the feet of the blocks, in their shadow, is interpolated, 6 % off in the worst block.
    """
    ours, reference = (sums(image, lamp) for image in images)
    error = np.abs(ours / reference - 1)
    assert_small(error, 0.1, images, tmp_path)
    assert_small(np.quantile(error, 0.98, axis=(0, 1)), 0.04, images, tmp_path)
    assert_small(np.quantile(error, 0.95, axis=(0, 1)), 0.02, images, tmp_path)
    assert_small(np.median(error, axis=(0, 1)), 0.005, images, tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize("axis", [0, 1], ids=["columns", "rows"])
def test_no_error_runs_along_rows_or_columns(images, lamp, axis, tmp_path):
    """Measured: 0.8 % at most."""
    ours, reference = (sums(image, lamp).sum(axis=axis) for image in images)
    assert_small(ours / reference - 1, 0.015, images, tmp_path)


@pytest.mark.nightly
def test_the_lamp_is_as_bright_as_in_the_reference(images, lamp, tmp_path):
    """Some 90 pixels, of which the border is sampled."""
    ours, reference = (image[lamp].sum(axis=0) for image in images)
    assert_small(ours / reference - 1, 0.03, images, tmp_path)

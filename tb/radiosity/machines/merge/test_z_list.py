"""The volume renderer equals rays that march through all cells, and has the same bytes for all splits and nodes."""

from functools import cache

import numpy as np
import pytest

from radiosity.machines.merge.screen_split import SPLITTERS, split_screen
from radiosity.machines.merge.work_weights import TRIANGLES_ALONE, WorkWeights
from radiosity.machines.merge.z_list import composed, render_regions, transferred
from tb.radiosity.machines.merge.marched import marched, small_volume

pytestmark = pytest.mark.usefixtures("interpreted")

SIZE = 32


@cache
def render(seed, splitter="hs", nodes=1, weights=TRIANGLES_ALONE):
    _, screen = small_volume(seed)
    return render_regions(screen, split_screen(splitter, screen.boxes, weights, nodes=nodes, width=SIZE, height=SIZE))


@cache
def whole(nodes):
    """The picture of one node, for tests with so many: a night's kernels are compiled, and their last bits differ."""
    return render.__wrapped__(1)


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.nightly) for seed in range(2, 6))])
def test_pictures_equal_marched_rays(seed):
    expected = marched(*small_volume(seed))
    found = render(seed).picture
    assert (expected[..., 3] > 0).mean() > 0.1
    assert np.abs(found - expected).max() <= 1e-9


@pytest.mark.parametrize("splitter", SPLITTERS)
@pytest.mark.parametrize("nodes", [8, *(pytest.param(nodes, marks=pytest.mark.nightly) for nodes in (2, 32))])
def test_pictures_have_the_same_bytes_for_all_splits_and_nodes(splitter, nodes):
    one, found = whole(nodes), render(1, splitter, nodes, WorkWeights())
    assert found.picture.tobytes() == one.picture.tobytes()
    assert found.pixels.sum() == one.pixels[0]


def test_spans_are_cut_at_the_borders_of_regions_and_not_by_bands():
    one = render(1).spans[0]
    assert render(1, "hs", 8).spans.sum() == one
    assert render(1, "rrs", 8).spans.sum() > one


def test_pixels_are_the_centres_in_each_face():
    """Counted for each face by itself."""
    _, screen = small_volume(4)
    y, x = np.divmod(np.arange(SIZE * SIZE), SIZE)
    inside = 0
    for a, b, c in screen.points[screen.faces][:, :, :2]:
        sides = [(q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) for p, q in ((a, b), (b, c), (c, a))]
        inside += (np.sign(sides) == np.sign(sides[0])).all(axis=0).sum()
    assert render(4).pixels.sum() == inside


def test_lists_that_stay_sorted_take_no_steps():
    found = render(1)
    assert 0 < found.steps[0] < found.pixels[0] ** 2
    assert render(1, "rrs", 8).steps.sum() > 0.5 * found.steps[0]


def test_samples_from_front_to_back_are_those_from_back_to_front():
    values = np.random.default_rng(0).random(20)
    ahead, behind = np.zeros(4), np.zeros(4)
    for value in values:
        composed(ahead, value)
    for value in values[::-1]:
        *colour, opacity = transferred(value)
        behind[:3] = behind[:3] * (1 - opacity) + np.array(colour) * opacity
        behind[3] = behind[3] * (1 - opacity) + opacity
    assert ahead == pytest.approx(behind)
    swapped = np.zeros(4)
    for value in values[::-1]:
        composed(swapped, value)
    assert not np.allclose(swapped[:3], ahead[:3])

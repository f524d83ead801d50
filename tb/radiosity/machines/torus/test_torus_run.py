"""The picture does not depend on the machine, and equals a recursive ray tracer's."""

from itertools import pairwise

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.torus import torus_state as ts
from radiosity.machines.torus.columns import Count, Tally
from radiosity.machines.torus.node_boxes import node_boxes
from radiosity.machines.torus.torus_run import TorusSetup, spiral_order
from radiosity.machines.torus.torus_turns import SCALE
from tb.radiosity.machines.torus.torus_cases import SIZE, drawn_scene, run_small
from tb.radiosity.machines.torus.whitted import picture

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize("glass", [0.0, 0.3])
@pytest.mark.parametrize("has_shadows", [True, False])
def test_sums_of_returned_colours_are_those_of_recursion(glass, has_shadows):
    run = run_small(glass=glass, has_shadows=has_shadows)
    expected = picture(drawn_scene(1, glass=glass), SIZE, has_shadows=has_shadows)
    # Each returned value is rounded by half a unit at most; a pixel has some dozen.
    assert np.abs(run.sums / SCALE - expected).max() < 40 / SCALE
    assert run.sums.any()


@pytest.mark.parametrize("changes", [
    {"nodes": 4, "growth": 0.0}, {"nodes": 25, "growth": 0.24, "growth_by": "volume"}, {"nodes": 9, "growth": 1.0},
    {"nodes": 9, "delay": 3000}, {"nodes": 9, "delay": 200_000, "seed": 1},
    {"subdivisions": 17, "storage": "array"}, {"subdivisions": 17, "storage": "hash", "entries": 64},
    {"nodes": 9, "is_stealing": False}, {"nodes": 9, "buffer": 340}], ids=str)
def test_the_picture_equals_the_one_node_picture(changes):
    run = run_small(**changes)
    assert run.sums.tobytes() == run_small(nodes=1, subdivisions=1, growth=0.0).sums.tobytes()
    assert run.state.counts[Count.LIVE] == 0


@pytest.mark.parametrize("seed", [2])
def test_drawn_scenes_have_the_picture_of_one_node_too(seed):
    one, many = (run_small(seed, glass=0.2, nodes=nodes, growth=0.3) for nodes in (1, 16))
    assert one.sums.tobytes() == many.sums.tobytes()
    assert one.rays == many.rays


@pytest.mark.parametrize("deepest", [0, 1])
def test_no_ray_is_deeper_than_the_largest_level_and_cut_rays_return_their_colour(deepest):
    run = run_small(deepest=deepest, log=10_000)
    assert run.log[run.log[:, 5] == 0, 4].max() == min(deepest, run.log[run.log[:, 5] == 0, 4].max())
    assert np.abs(run.sums / SCALE - picture(drawn_scene(1), SIZE, deepest=deepest)).max() < 40 / SCALE


def test_rays_of_small_contributions_are_not_made():
    rays = [run_small(least=least).rays for least in (0.0, 0.01, 0.3)]
    assert rays[0] > rays[1] > rays[2]
    assert np.abs(run_small(least=0.3).sums / SCALE - picture(drawn_scene(1), SIZE, least=0.3)).max() < 40 / SCALE


@pytest.mark.parametrize(("nodes", "size"), [(1, (5, 7)), (4, (5, 7)), (9, SIZE), (16, (10, 9))])
def test_each_pixel_has_one_primary_ray_and_nodes_differ_by_a_row_and_a_column_at_most(nodes, size):
    boxes = node_boxes(drawn_scene(1), side=round(nodes ** 0.5), size=size)
    order, starts = spiral_order(boxes, size)
    assert sorted(order) == list(range(size[0] * size[1]))
    for edges in (boxes.rows, boxes.columns):
        assert np.ptp(np.diff(edges)) <= 1
    for node in range(nodes):
        row, column = divmod(node, boxes.side)
        pixels = order[starts[node]:starts[node + 1]]
        assert set(pixels // size[1]) == set(range(boxes.rows[row], boxes.rows[row + 1]))
        assert set(pixels % size[1]) == set(range(boxes.columns[column], boxes.columns[column + 1]))


def test_pixels_spiral_from_the_middle_outwards():
    boxes = node_boxes(drawn_scene(1), side=1, size=(7, 7))
    order, _ = spiral_order(boxes, (7, 7))
    rings = np.maximum(abs(order // 7 - 3), abs(order % 7 - 3))
    assert order[0] == 24
    assert (np.diff(rings) >= 0).all()
    steps = np.maximum(abs(np.diff(order // 7)), abs(np.diff(order % 7)))
    assert (steps[np.diff(rings) == 0] == 1).all()


@pytest.mark.parametrize(("nodes", "growth"), [(1, 0.0), (4, 0.02), (9, 0.0), (9, 1.0)])
def test_primaries_begin_in_the_box_of_the_node_that_has_their_pixel(nodes, growth):
    run = run_small(nodes=nodes, growth=growth, is_stealing=False, log=100_000)
    first = {}
    for _, _, node, pixel, level, is_shadow in run.log.tolist():
        if level == 0 and not is_shadow:
            first.setdefault(pixel, node)
    order, starts = spiral_order(run.boxes, SIZE)
    owner = {pixel: node for node in range(nodes) for pixel in order[starts[node]:starts[node + 1]].tolist()}
    assert first == owner
    # They enter at the front of the box, between the rays through the corners of the node's pixels.
    for pixel, node in owner.items():
        row, column = divmod(pixel, SIZE[1])
        at = ((2 * column + 1) / SIZE[1] - 1) * SIZE[1] / SIZE[0], (2 * row + 1) / SIZE[0] - 1
        point = np.array(at) * 0.35 * run.boxes.front
        assert (run.boxes.inner[node, 0, :2] <= point).all()
        assert (point <= run.boxes.inner[node, 1, :2]).all()


def test_nodes_work_off_arrivals_first():
    """Rays that were begun are finished before a primary ray is made, so few are held."""
    run = run_small(nodes=1, log=100_000)
    pending = set()
    for _, _, _, pixel, level, is_shadow in run.log.tolist():
        if level == 0 and not is_shadow:
            assert pixel not in pending
            pending.add(pixel)
            last = pixel
        assert pixel == last
    assert run.state.tallies[:, Tally.MOST_HELD].max() <= 2 * 8 + 2


def test_shadow_rays_are_traced_first():
    """They spawn nothing; behind each hit its shadow rays follow at once."""
    log = run_small(nodes=1, log=100_000).log
    for before, after in pairwise(log):
        # A shadow ray's level is one above its parent's: none is left when a ray of another hit begins.
        if after[5]:
            assert before[5] or before[4] == after[4] - 1


def test_idle_nodes_are_given_rows_and_each_pixel_is_traced_once():
    runs = [run_small(3, nodes=4, growth=0.6, size=(24, 24), is_stealing=steals, log=100_000)
            for steals in (True, False)]
    assert runs[0].state.tallies[:, Tally.GIVEN].sum() > 0
    assert runs[1].state.tallies[:, Tally.GIVEN].sum() == 0
    for run in runs:
        assert run.state.tallies[:, Tally.PRIMARIES].sum() == 24 * 24
        assert run.state.is_started.all()
    assert runs[0].sums.tobytes() == runs[1].sums.tobytes()
    assert runs[0].state.tallies[:, Tally.PRIMARIES].max() > 24 * 24 / 4


def test_given_primaries_begin_in_the_box_of_their_new_node():
    run = run_small(3, nodes=4, growth=0.6, size=(24, 24), log=100_000)
    seen = set()
    for _, _, node, pixel, level, is_shadow in run.log.tolist():
        if level or is_shadow or pixel in seen:
            continue
        seen.add(pixel)
        row, column = divmod(pixel, 24)
        point = np.array([(2 * column + 1) / 24 - 1, (2 * row + 1) / 24 - 1]) * 0.35 * run.boxes.front
        assert (run.boxes.grown[node, 0, :2] <= point).all()
        assert (point <= run.boxes.grown[node, 1, :2]).all()


def test_packets_have_up_to_21_values_and_black_is_not_sent():
    run = run_small(nodes=9)
    tallies = run.state.tallies
    values, packets = tallies[:, Tally.VALUES], tallies[:, Tally.PACKETS]
    # Full packets while tracing, and one with the rest.
    assert (packets == -(-values // 21)).all()
    # Fewer values than rays: black ones and those that carry their colour on.
    assert values.sum() < run.rays
    assert (run.state.packets[:9, ts.VALUES_OF_PACKET, 0] == 0).all()


def test_overlaps_reduce_hand_overs_and_cost_memory():
    runs = [run_small(nodes=4, growth=growth, size=(24, 24), is_stealing=False) for growth in (0.02, 0.24, 1.0)]
    passed = [int(run.state.tallies[:, Tally.PASSED].sum()) for run in runs]
    assert passed[0] > passed[1] > passed[2] > 0
    held = [int(run.grids.held.sum()) for run in runs]
    assert held[0] <= held[1] <= held[2]


def test_objects_go_right_along_the_lowest_row_and_up_from_there_as_far_as_boxes_have_them():
    run = run_small(nodes=9, growth=0.3)
    grown, bounds = run.boxes.grown.reshape(3, 3, 2, 3), run.scene.bounds
    taken = run.state.tallies[:, Tally.DOWNLOADED].reshape(3, 3)
    for column in range(3):
        reaches = bounds[:, 1, 0] >= grown[0, column, 0, 0] if column else np.ones(len(bounds), dtype=bool)
        for row in range(3):
            if row:
                reaches = reaches & (bounds[:, 0, 0] <= grown[0, column, 1, 0])
                reaches = reaches & (bounds[:, 1, 1] >= grown[row, column, 0, 1])
            assert taken[row, column] == reaches.sum()
    assert (taken.reshape(-1) >= run.grids.held).all()


@pytest.mark.parametrize(("changes", "message"), [
    ({"nodes": 1025}, "Nodes must be 1 to 1024, not 1025"),
    ({"entries": 48}, "Entries must be a power of two, not 48"),
    ({"least": 1.0}, "Least must be at least 0 and below 1, not 1.0"),
    ({"storage": "tree"}, "Storage must be one of array, hash, not 'tree'"),
    ({"growth_by": "area"}, "Growth-by must be one of axis, volume, not 'area'"),
    ({"size": (0, 4)}, "Rows must be 1 to 16384, not 0")])
def test_wrong_setups_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        TorusSetup(**changes)

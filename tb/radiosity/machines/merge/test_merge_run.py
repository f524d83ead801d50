"""The picture has the bytes of a plain z-buffer under all schemes, divisions and numbers of nodes."""

from itertools import cycle, product

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.merge.exchange_steps import SCHEMES
from radiosity.machines.merge.line_shares import DIVISIONS
from radiosity.machines.merge.merge_run import MergeScheme, simulate_merge
from radiosity.machines.merge.merge_work import MergeWork
from radiosity.machines.merge.span_lists import span_lists
from radiosity.machines.merge.winning_pixels import pixels_of_spans
from tb.radiosity.machines.merge.drawn import drawn_triangles, plain_picture

pytestmark = pytest.mark.usefixtures("interpreted")

WIDTH, HEIGHT = 48, 40


@pytest.fixture(scope="module")
def drawn():
    return drawn_triangles(7, 400, width=WIDTH, height=HEIGHT, size=5.0)


@pytest.fixture(scope="module")
def plain(drawn):
    """The picture without nodes, and where it is active."""
    return plain_picture(span_lists(drawn[0], drawn[1] % 1, WIDTH, HEIGHT), WIDTH, HEIGHT)


def run(drawn, nodes=8, **scheme):
    return simulate_merge(*drawn, MergeScheme(**scheme), nodes=nodes, width=WIDTH, height=HEIGHT)


@pytest.mark.parametrize(("name", "division", "nodes", "is_full"),
                         [*(pytest.param(name, division, nodes, False,
                                         marks=[] if is_drawn else pytest.mark.nightly)
                            for (name, division, nodes), is_drawn in zip(
                                product(SCHEMES, DIVISIONS, (2, 32)), cycle((True, False, False, True)), strict=False)),
                          *product(SCHEMES, ("equal",), (8,), (True,))])
def test_pictures_are_a_plain_z_buffer_s(drawn, plain, name, division, nodes, is_full):
    expected, is_active = plain
    found = run(drawn, nodes, name=name, division=division, is_full=is_full)
    assert np.array_equal(found.picture, expected)
    assert found.active == is_active.sum()


def test_triangles_are_dealt_in_turn(drawn):
    found = run(drawn, nodes=32)
    assert found.triangles.tolist() == [13] * 16 + [12] * 16
    spans = span_lists(drawn[0], drawn[1] % 32, WIDTH, HEIGHT)
    assert found.generated[5] == (spans.right - spans.left + 1)[spans.node == 5].sum()


def test_words_are_those_of_the_pixels_that_are_sent(drawn):
    """Three words of a pixel, two of a cell; from each to all, no pixel is sent twice."""
    direct = run(drawn, name="aapc", division="equal")
    owners = np.arange(0, HEIGHT + 1, 5)
    pixels = pixels_of_spans(span_lists(drawn[0], drawn[1] % 8, WIDTH, HEIGHT), 8, WIDTH)
    node = np.repeat(np.arange(8), np.diff(pixels.start))
    away = np.searchsorted(owners, pixels.location // WIDTH, side="right") - 1 != node
    assert direct.report()["traffic"]["words"] == 3 * away.sum()
    assert direct.held.sum() == len(node)
    full = [run(drawn, name=name, division="equal", is_full=True).report()["traffic"] for name in SCHEMES]
    assert {one["words"] for one in full} == {2 * 7 * WIDTH * HEIGHT}
    assert {one["concurrent_words"] for one in full} == {2 * 7 * WIDTH * HEIGHT // 8}


def test_volumes_are_in_the_source_s_order():
    """Ring, mesh, pairs, each to all: figures 4.1 and 4.4; and pixels below cells."""
    covers = drawn_triangles(2, 300, width=WIDTH, height=HEIGHT, size=8.0)
    concurrent = [run(covers, nodes=16, name=name, division="packed").concurrent_words for name in SCHEMES]
    assert concurrent == sorted(concurrent, reverse=True)
    assert len(set(concurrent)) == 4


def test_a_full_exchange_takes_equation_4_15_and_a_constant_for_each_cell(drawn):
    timing, work = NodeTiming(), MergeWork()
    phases = run(drawn, nodes=8, name="pair", division="equal", is_full=True).phases
    cells = WIDTH * HEIGHT * 7 / 8
    expected = 3 * timing.setup + cells * (2 * timing.word + work.cell)
    # Nodes begin with their own pixels drawn, the slowest at the end of the phase before.
    assert phases["merge"] == pytest.approx(expected / 1e9, rel=0.01)


def test_packing_is_balanced_best(drawn):
    imbalance = {division: run(drawn, name="aapc", division=division).report()["imbalance"] for division in DIVISIONS}
    assert imbalance["packed"] < imbalance["recursive"] < imbalance["equal"]


def test_one_node_is_alone(drawn):
    found = run(drawn, nodes=1)
    assert found.time == found.alone
    assert found.sent.sum() == 0
    assert found.report()["efficiency"] == 1


def test_pixels_are_watched_from_the_first_step_to_the_last(drawn):
    seen = []
    simulate_merge(*drawn, MergeScheme(name="pair"), nodes=8, width=WIDTH, height=HEIGHT,
                   watch=lambda pixels, lines: seen.append((len(pixels.location), lines)))
    found = run(drawn, nodes=8, name="pair")
    assert [count for count, _ in seen][::3] == [found.held.sum(), found.active]
    assert len(seen) == 4


@pytest.mark.parametrize("keywords", [{"name": "tree"}, {"division": "thirds"}])
def test_wrong_machines_are_refused(drawn, keywords):
    with pytest.raises(InputError, match=r"(Scheme|Division) must be one of"):
        run(drawn, **keywords)

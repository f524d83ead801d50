"""Spans of work, in whatever order they end."""

import re
import time
from functools import partial
from pathlib import Path
from threading import Barrier, Lock

import pytest

from golden.base.source_digest import PACKAGES
from golden.base.spread import in_threads, in_turn, spans
from golden.engine.cast.methods import frustum_caster
from golden.light import form_factors
from golden.light.factors.blocks import BlockStore
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.npz_file import write_npz
from golden.light.factors.rows import FactorRows
from golden.light.in_flight import InFlight
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin import builtin_scene
from tb.golden.hostile_spread import HOSTILE, HostileSpread

PARTS = spans(23, 5)
ROOT = Path(__file__).parents[3]


def test_spans_cover_all_numbers_once():
    assert PARTS == [(0, 5), (5, 10), (10, 15), (15, 20), (20, 23)]
    assert spans(0, 5) == []


@pytest.mark.parametrize("spread", [in_turn, in_threads(1), in_threads(3)])
def test_each_span_comes_with_its_result(spread):
    assert dict(spread(range, PARTS)) == {part: range(*part) for part in PARTS}


def test_one_thread_computes_a_span_when_it_is_requested():
    begun = []
    results = in_threads(1)(lambda *part: begun.append(part), PARTS)
    next(results)
    assert begun == PARTS[:1]


def test_an_error_in_a_thread_ends_the_work():
    begun = []

    def work(first, last):
        begun.append(first)
        if not first:
            raise KeyboardInterrupt
        time.sleep(0.001)

    with pytest.raises(KeyboardInterrupt):
        list(in_threads(2)(work, spans(10000, 1)))
    assert len(begun) < 10000


@pytest.mark.parametrize(("jobs", "parts", "most"), [(4, 9, 4), (4, 2, 4), (3, 2, 2), (1, 5, 1), (4, 1, 4)])
def test_work_in_spans_whose_work_is_in_spans_has_no_more_threads(jobs, parts, most):
    """So many at once as the outermost work was given, or as share out evenly."""
    lock, running, greatest = Lock(), [0], [0]

    def inner(first, last):
        with lock:
            running[0] += 1
            greatest[0] = max(greatest[0], running[0])
        time.sleep(0.01)
        with lock:
            running[0] -= 1
        return first

    def outer(first, last):
        return sorted(result for _, result in in_threads(jobs)(inner, spans(4, 1)))

    assert dict(in_threads(jobs)(outer, spans(parts, 1))) == {part: [0, 1, 2, 3] for part in spans(parts, 1)}
    assert greatest[0] <= most
    # What threads of a spread may use is no limit of the next one.
    together = Barrier(3)
    assert sorted(place for _, place in in_threads(3)(lambda *_: together.wait(60), spans(3, 1))) == [0, 1, 2]


def test_all_threads_that_compute_are_made_in_one_place():
    sources = [path for package in (*PACKAGES, "benchmarks") for path in (ROOT / package).rglob("*.py")]
    assert [path.name for path in sources if re.search("ThreadPool|Thread[(].*jobs", path.read_text())] == ["spread.py"]


@pytest.fixture(params=HOSTILE, ids=lambda seed: repr(HostileSpread(seed)))
def hostile(request):
    """Ends spans in another order, and has done so when the test ends."""
    made = HostileSpread(request.param)
    yield made
    assert made.turned


@pytest.mark.parametrize("rows", [partial(FactorRows, error=0.1, sky_patches="tregenza", block_rows=5),
                                  partial(HemisphereRows, rays=(8, 4), block_rows=7)], ids=["rays", "hemispheres"])
def test_blocks_of_view_factors_have_their_rows_in_whatever_order_they_end(rows, hostile, tmp_path):
    scene = builtin_scene("furnace:2")
    rows, content = rows(scene, frustum_caster(scene, "naive")), []
    for name, spread in (("in turn", in_turn), ("hostile", hostile)):
        store = BlockStore(tmp_path / name, {}, resume=False)
        write_npz(compute_view_factors(rows, store=store, spread=spread), tmp_path / "F.npz")
        content.append((tmp_path / "F.npz").read_bytes())
    assert content[0] == content[1]


def test_a_picture_has_its_bytes_and_counts_in_whatever_order_spans_end(monkeypatch):
    """Hemispheres of elements, and pixels."""
    hostile = HostileSpread(1)
    monkeypatch.setattr(InFlight, "of", lambda *_, **__: InFlight(primary=20))
    monkeypatch.setattr(form_factors, "_BLOCK", 1 << 10)
    scene = builtin_scene("cornell")
    settings = RenderSettings(width=8, height=6, samples=4, light_samples=1, rays=(16, 4), max_edge=300, jobs=1)
    whole, parts = (render(scene, camera=scene.camera, settings=settings, workers=workers)
                    for workers in (None, hostile))
    assert hostile.turned > 1
    for name in ("image", "tests", "steps"):
        assert getattr(parts, name).tobytes() == getattr(whole, name).tobytes()
    for stats in (whole.stats, parts.stats):
        del stats["seconds"]
    assert parts.stats == whole.stats

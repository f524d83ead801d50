"""Expected results as text: those of `run_job`, with a line for each number that is compared."""

import numpy as np

from golden.engine.cast.shelling import Shelling
from golden.engine.jobs.expected_results import expected_results
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.whole_job import whole_job
from tb.golden.engine.jobs.jobs import CONFIG, requests

ROOMY = CONFIG.replace({"icu.rays": 1024})


def test_every_hit_and_every_sum_has_its_line():
    request = requests()[0]
    lines = [line.split() for line in expected_results(whole_job([request], CONFIG))]
    assert {(line[0], len(line)) for line in lines} == {("hit", 8), ("sum", 4)}
    shelling = Shelling.of_cells(request.geometry, request.table, ROOMY)
    for number, record in enumerate(request.records):
        found = np.array([line[2:] for line in lines if line[:2] == ["hit", str(number)]], dtype=np.int64)
        hits = shelling.cast(record)[0]
        assert np.array_equal(found[:, 0] + record.columns * found[:, 1], np.arange(len(record)))
        assert np.array_equal(found[:, 2:], np.stack([hits.patch, hits.inverse, hits.u, hits.v], axis=1))
        sums = np.zeros(len(request.geometry), dtype=np.int64)
        met = np.flatnonzero(hits.patch >= 0)
        np.add.at(sums, hits.patch[met], request.weights[met // record.columns])
        assert [tuple(map(int, line[2:])) for line in lines if line[:2] == ["sum", str(number)]] == [
            (patch, sums[patch]) for patch in np.flatnonzero(sums)]


def test_patches_alone_have_no_other_numbers():
    request = requests()[2]
    lines = [line.split() for line in expected_results(whole_job([request], CONFIG))]
    assert request.hit_format == HitFormat.IDS
    assert len(lines) == 30 * 19
    assert {(line[0], len(line)) for line in lines} == {("hit", 5)}


def test_sums_alone_have_no_hits():
    request = requests()[1]
    assert {line.partition(" ")[0] for line in expected_results(whole_job([request], CONFIG))} == {"sum"}

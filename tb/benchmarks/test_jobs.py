"""The counts of whole jobs, from completion records."""

import json
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import jobs
from benchmarks.jobs import SceneRuns, rows_of, write_roofline
from golden.engine.config import PRESETS
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.run_job import run_job
from radiosity.cli.main import main as radiosity
from radiosity.flow.simulator.job_result import frustum_results
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.machines.engine.job_runs import JobRun, JobSpec, check_results, prepare_job
from tb.radiosity.charts import rectangles

# Begin of the job, near the wrap of the engine's cycle counter.
BEGIN = (1 << 32) - 500
SPEC = JobSpec(scene="cornell", rays=(16, 4), frusta=6, cell=0.5)


def run_of(spec=SPEC, *, clusters=1, length=1000):
    """A job whose casts take ``length`` cycles each, begin 50 cycles after one another, and whose load takes 300."""
    config = simulation_config(PRESETS["tiny"], clusters=clusters, topology="mesh")
    prepared = prepare_job(spec, config)
    records = np.zeros(1 + len(prepared.records), dtype=COMPLETION.dtype)
    records["tag"] = np.arange(len(records))
    records["begin"][0], records["end"][0] = BEGIN, (BEGIN + 300) % (1 << 32)
    for number, one in enumerate(records[1:]):
        begin = BEGIN + 310 + number // clusters * (length + 50)
        one["cluster"], one["begin"], one["cycles"] = number % clusters, begin % (1 << 32), length
        one["end"], one["tested"], one["own"], one["found"] = (begin + length + 100) % (1 << 32), 900, 20, 24
    return JobRun(prepared=prepared, config=config, loads=records[:1], sections=records[1:], read_beats=80,
                  written_beats=90, checked=True)


def scene_runs(*clusters, length=1000):
    scene = SceneRuns(SPEC)
    scene.runs, scene.warm = {count: run_of(clusters=count, length=length) for count in clusters}, 800
    return scene


def test_counts_of_a_job_beyond_the_wrap_of_the_counter():
    run = run_of()
    assert run.cycles == 310 + 5 * 1050 + 1100
    assert (run.load_cycles, run.frustum_cycles, run.cast_cycles) == (300, 1000, 6000)
    assert (run.tests, run.rays) == (5400, 6 * 64)
    assert run.patches == {"own": 120, "kept": 24, "remote": 0, "hits": 0, "misses": 0}
    assert run.bounds == {"tests": 5400, "patches": 576, "memory": 90}
    assert run.bound == "tests"
    assert run.efficiency == pytest.approx(5400 / run.cycles)


def test_rows_compare_with_one_cluster():
    scene = scene_runs(1, 2)
    one, two = (dict(zip(jobs.HEAD, row, strict=True)) for row in rows_of(scene))
    assert (one["cycles"], two["cycles"]) == (6660, 310 + 2 * 1050 + 1100)
    assert (one["speedup"], two["speedup"]) == ("1.00", f"{6660 / 3510:.2f}")
    assert (two["tests"], two["patches"], two["cast"]) == (2700, 288, 3000)
    assert jobs.mean_row(scene)[4:7] == [800, 1000, "1.250"]


def test_where_the_cycles_of_a_cluster_go():
    """Each cluster casts three frusta with 50 cycles between them, the first one 10 cycles after the load."""
    run = run_of(clusters=2)
    assert run.cluster_cycles == {"load": 300, "cast": 3000, "waits": 110, "last_results": 100, "idle": 0}
    # Without the last section cluster 1 ends one cast and one gap earlier.
    shorter = replace(run, sections=run.sections[:-1])
    assert shorter.cluster_cycles == {"load": 300, "cast": 2500, "waits": 85, "last_results": 100, "idle": 525}
    idle = replace(run, sections=run.sections[:1])
    assert idle.cluster_cycles == {"load": 300, "cast": 500, "waits": 5, "last_results": 50, "idle": 555}
    scene = scene_runs(1, 2)
    assert jobs.cycles_rows(scene)[1] == ["cornell", 2, 3510, 300, 3000, 110, 100, 0]


def test_the_warm_frustum_is_the_last_of_its_casts(monkeypatch):
    lengths = iter((1000, 900, 800, 700))
    monkeypatch.setattr(jobs, "console", lambda: SimpleNamespace(note=str))
    monkeypatch.setattr(jobs, "job_machine", lambda *_, **__: nullcontext())
    monkeypatch.setattr(jobs, "run_on", lambda *_, **__: run_of(length=next(lengths)))
    scene = SceneRuns(SPEC)
    jobs.measure([scene], simulation_config(PRESETS["tiny"], clusters=1, topology="mesh"), check=False)
    assert (scene.runs[1].frustum_cycles, scene.warm) == (1000, 700)


def test_groups_and_points_of_a_job():
    config = simulation_config(PRESETS["tiny"], clusters=2, topology="mesh")
    spec = JobSpec(scene="cornell", rays=(32, 8), frusta=3, cell=0.5, hit_format=HitFormat.FULL, group=2)
    job = plan_job([prepare_job(spec, config).request], config)
    assert sum(one is not None for one in job.sections) == 2 * 3
    alone = prepare_job(JobSpec(scene="cornell", rays=(32, 8), point=5, cell=0.5), config)
    assert len(alone.records) == 1


def test_cycles_without_a_load_begin_with_the_earliest_section():
    run = run_of(clusters=2)
    first, second = replace(run, loads=run.loads[:0]), replace(run, loads=run.loads[:0], sections=run.sections[::-1])
    assert first.cycles == second.cycles == run.cycles - 310


@pytest.mark.parametrize("hit_format", HitFormat)
def test_wrong_results_are_noticed(hit_format):
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    prepared = prepare_job(replace(SPEC, frusta=1, hit_format=hit_format), config)
    request, memory = prepared.request, {}
    job = plan_job([request], config)
    done = run_job(job)
    memory = bytearray(job.end)
    for address, data in done.memory.items():
        memory[address:address + len(data)] = data

    def result():
        return SimpleNamespace(frusta=frustum_results(
            job, done.completions, lambda address, size: bytes(memory[address:address + size])))

    check_results(prepared, result(), config)
    memory[int(job.descriptors["sums_address"][1])] ^= 1
    with pytest.raises(SystemExit, match="cornell, 1 clusters, frustum 0: sums differ from the golden model's"):
        check_results(prepared, result(), config)
    memory[int(job.descriptors["sums_address"][1])] ^= 1
    if hit_format != HitFormat.NONE:
        memory[job.phases[0].hits[0]] ^= 1
        with pytest.raises(SystemExit, match="hits differ from the golden model's"):
            check_results(prepared, result(), config)


def test_the_roofline_has_the_three_limits_and_what_was_measured(tmp_path):
    write_roofline(tmp_path / "new" / "x.svg", scene_runs(1, 2))
    text = (tmp_path / "new" / "x.svg").read_text()
    assert all(f">{name}</text>" in text for name in ("tests", "patches", "memory port", "measured"))


def test_activity_has_each_cast_in_the_lane_of_its_cluster():
    """Every second cast of a cluster is lighter; the first one begins 10 cycles after the load."""
    axes, = jobs.activity_figure(run_of(clusters=2), title="job").axes
    load, cast, lighter, results = (rectangles(patch) for patch in axes.patches)
    assert load[:, :2].tolist() == [[0, 300]]
    assert cast.tolist() == [[start, start + 1000, lane + 0.1, lane + 0.65] for lane in (1, 2) for start in (310, 2410)]
    assert lighter.tolist() == [[1360, 2360, lane + 0.1, lane + 0.65] for lane in (1, 2)]
    assert results[:3].tolist() == [[end, end + 100, 1.65, 1.9] for end in (1310, 2360, 3410)]


def test_one_scene_is_one_object(tmp_path, monkeypatch):
    def measure(scenes, config, **_):
        for scene in scenes:
            scene.spec, scene.warm = SPEC, 800
            scene.runs[config.noc.nodes] = run_of(clusters=config.noc.nodes)

    monkeypatch.setattr(jobs, "measure", measure)
    result = CliRunner().invoke(radiosity, ["bench", "jobs", "--scene", "cornell", "--clusters", "2", "--frusta", "6",
                                            "--rays", "16x4", "--json", "-o", str(tmp_path / "jobs.md")],
                                catch_exceptions=False)
    report = json.loads(result.stdout)
    assert {"cycles", "cast_cycles", "speedup", "efficiency", "bound", "scene", "cell", "configuration",
            "versions"} <= set(report)
    assert report["bound"] == {"name": "tests", "cycles": 2700}
    assert report["configuration"]["seed"] == 1
    assert report["speedup"] == pytest.approx(6660 / 3510)
    lanes = (tmp_path / "jobs-cornell-activity.svg").read_text()
    assert lanes.count(">cluster ") == 2
    assert (tmp_path / "jobs-cornell-roofline.svg").exists()
    assert "| cornell | 2 |" in (tmp_path / "jobs.md").read_text()

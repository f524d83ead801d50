"""The commands as a user gives them."""

import csv
import json
import re
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import golden.cli
import golden.memory_map
import radiosity.cli
from golden.cast.rays import Rays
from golden.config import PRESETS
from golden.frustum import Hemisphere
from golden.scene.open import open_scene
from hw.cluster import COUNTERS
from hw.memsys.cache_policy import CachePolicy
from hw.simulator.cast_result import SHARED_COUNTERS, CastResult
from hw.simulator.machine_caster import MachineCaster
from hw.simulator.simulated_machine import SAMPLE_CYCLES
from hw.simulator.simulation_config import overridden, overridden_text, simulation_config
from hw.simulator.utilization import utilization
from radiosity.machine_cast import write_counters
from tb.system.job_machine import ONE_CLUSTER, SMALL

# A small machine with little of everything.
MACHINE = ("--method", "machine", "--preset", "tiny", "--cell", "0.5", "-P", "ctu.run_ahead=2",
           *(word for name, value in SMALL.items() if name != "noc.rows" for word in ("-P", f"{name}={value}")))
COARSE = ("--light-samples", "1", "--depth", "1", "--spp", "1", "--rays", "16x4", "--max-edge", "1000")
CAST = ("cast", "cornell", "--patch", "4", "--rays", "32x8", "--ratio", "16", *MACHINE)
ON = ("--method", "machine")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where outputs go."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(main, *arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exc_info
    return result


BAD = {
    "no scene": (("cast", "nowhere", "--patch", "0", *ON), "nowhere"),
    "no frustum": (("cast", "cornell", *ON), "one of --origin, --patch and --screen"),
    "clusters": (("cast", "cornell", "--patch", "0", *ON, "--clusters", "3"), "a power of two up to 64, not 3"),
    "no clusters": (("cast", "cornell", "--patch", "0", *ON, "--clusters", "0"), "not 0"),
    "topology": (("cast", "cornell", "--patch", "0", *ON, "--topology", "star"), "'star' is not one of"),
    "policy": (("cast", "cornell", "--patch", "0", *ON, "--policy", "random"), "'random' is not one of"),
    "latency": (("cast", "cornell", "--patch", "0", *ON, "--latency", "0"), "0 is not in the range"),
    "cell": (("cast", "cornell", "--patch", "0", *ON, "--cell", "2"), "Cell size must be"),
    "patch": (("cast", "cornell", "--patch", "999", *ON), "Patch must be 0 to"),
    "parameter": (("cast", "cornell", "--patch", "0", *ON, "-P", "icu.speed=1"), "no parameter 'icu.speed'"),
    "two numbers of clusters": (("cast", "cornell", "--patch", "0", *ON, "-P", "noc.rows=2"),
                                "--clusters sets noc.rows (--clusters 1 here), so -P noc.rows cannot be given"),
    "two topologies": (("cast", "cornell", "--patch", "0", *ON, "--preset", "thesis", "--topology", "ring", "-P",
                        "noc.topology=mesh"), "--topology sets noc.topology (--topology ring here)"),
    "room": (("cast", "cornell", "--patch", "0", *ON, "--rays", "256x128"), "the capacity is 16384"),
    "timeline": (("cast", "cornell", "--patch", "0", *ON, "--timeline", "a.png"), "must end in .svg"),
    "waves": (("cast", "cornell", "--patch", "0", *ON, "--waves", "a.fst"), "must end in .vcd"),
    "counters": (("cast", "cornell", "--patch", "0", *ON, "--csv", "a.json"), "must end in .csv"),
    "no output": (("formfactors", "cornell", *ON), "Missing option '-o'"),
    "form factors": (("formfactors", "cornell", *ON, "-o", "a.txt"), "must end in .npz"),
    "rays": (("formfactors", "cornell", *ON, "-o", "a.npz", "--rays", "10x3"), "power"),
    "numbers": (("formfactors", "cornell", *ON, "-o", "a.npz", "-P", "numbers.scene_bits=18"), "numbers."),
    "image": (("render", "cornell", *ON, "-o", "a.jpg"), "must end in .png or .exr"),
    "size": (("render", "cornell", *ON, "-o", "a.png", "--size", "512x512"), "at most 16384 rays"),
    "dark": (("render", "tetra:1", *ON, "-o", "a.png", "--size", "0x4"), "Width must be 1 to"),
    "another method's option": (("render", "cornell", "-o", "a.png", "--topology", "ring"),
                                "--topology needs --method machine"),
    "another method's option of cast": (("cast", "cornell", "--patch", "0", "--casts", "2"),
                                        "--casts needs --method machine"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(folder, case):
    arguments, says = BAD[case]
    result = run(radiosity.cli.main, *arguments)
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1, result.stderr
    assert says in result.stderr
    assert not list(folder.iterdir())


def test_the_machines_errors_are_lines_too(folder, monkeypatch):
    def fails(*_, **__):
        raise RuntimeError("verilator fails")

    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedMachine.__init__", fails)
    result = run(radiosity.cli.main, "cast", "cornell", "--patch", "0", "--rays", "16x4", "--cell", "0.5", "--ratio",
                 "1", *ON)
    assert result.exit_code == 2
    assert result.stderr == "error: machine: verilator fails\n"


OPTIONS = ("--clusters", "4", "--topology", "ring", "--policy", "direct", "--latency", "7", "--spread", "3",
           "--memory-seed", "5", "--preset", "small", "-P", "icu.rays=2048", "-P", "noc.requests=2")


@pytest.mark.parametrize("command", [
    ("cast", "cornell", "--patch", "0", "--rays", "16x4", "--cell", "0.5", "--ratio", "1", "--waves", "a.vcd"),
    ("formfactors", "cornell", "-o", "a.npz", "--rays", "16x4", "--cell", "0.5"),
    ("render", "cornell", "-o", "a.png", "--size", "6x4", "--cell", "0.5", *COARSE)], ids=lambda words: words[0])
def test_options_reach_the_machine(folder, monkeypatch, command):
    machines = []

    def keep(_, config, **given):
        machines.append((config, given))
        raise RuntimeError("enough")

    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedMachine.__init__", keep)
    assert run(radiosity.cli.main, *command, *ON, *OPTIONS).stderr == "error: machine: enough\n"
    ((config, given),) = machines
    assert (config.noc.nodes, config.noc.topology, config.noc.requests, config.icu.rays) == (4, "ring", 2, 2048)
    assert config.icu.side_bits == PRESETS["small"].icu.side_bits
    assert {name: given[name] for name in ("policy", "latency", "spread", "shuffles", "seed", "traced")} == {
        "policy": CachePolicy.DIRECT, "latency": 7, "spread": 3, "shuffles": True, "seed": 5,
        "traced": command[0] == "cast"}


@pytest.fixture
def machines(folder, monkeypatch):
    """The configurations of the machines that commands request; none is built."""
    found = []

    def keep(_, config, **given):
        found.append(config)
        raise RuntimeError("enough")

    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedMachine.__init__", keep)
    return found


COMMAND_WORDS = {"cast": ("cast", "cornell", "--patch", "0", "--rays", "16x4", "--cell", "0.5", "--ratio", "1"),
                 "formfactors": ("formfactors", "cornell", "-o", "a.npz", "--rays", "16x4", "--cell", "0.5")}


@pytest.mark.parametrize("command", COMMAND_WORDS)
@pytest.mark.parametrize(("options", "nodes", "topology", "run_ahead"), [
    (("--preset", "thesis"), 8, "torus", 15),
    (("--preset", "thesis", "--clusters", "1"), 1, "torus", 15),
    (("--preset", "thesis", "--topology", "ring"), 8, "ring", 15),
    (("--preset", "thesis", "-P", "noc.columns=2"), 4, "torus", 15),
    (("--preset", "thesis", "-P", "ctu.run_ahead=2"), 8, "torus", 2),
    (("--preset", "large"), 1, "mesh", 6),
    ((), 1, "mesh", 6)], ids=lambda value: "-".join(value) if isinstance(value, tuple) else None)
def test_the_machine_is_that_of_its_preset(machines, command, options, nodes, topology, run_ahead):
    result = run(radiosity.cli.main, *COMMAND_WORDS[command], *ON, *options)
    assert result.stderr == "error: machine: enough\n"
    (config,) = machines
    assert (config.noc.nodes, config.noc.topology, config.ctu.run_ahead) == (nodes, topology, run_ahead)
    assert (config.icu.rays, config.icu.generation_bits) == (1 << 14, 8)


@pytest.mark.parametrize("command", ["cast", "formfactors", "render"])
def test_help_names_the_defaults_of_the_machine(command):
    text = " ".join(run(radiosity.cli.main, command, "--help").stdout.split()).replace("- ", "-")
    for about in ("Unless -P sets them, it has icu.rays=16384, icu.generation_bits=8 and a run-ahead depth",
                  "With --preset thesis it has the preset's clusters, network and run-ahead depth.",
                  "[default: mesh; the preset's with --preset thesis]"):
        assert about in text, text
    waves = "some 0.03 MB a cycle with four clusters; beside it a save file for GTKWave (.gtkw). Needs a second"
    assert (waves in text) == (command == "cast")


def test_what_the_simulation_overrides_is_named():
    given = PRESETS["thesis"]
    changes = overridden(simulation_config(given, clusters=None, topology=None), given)
    text = "; simulated with icu.rays 16384 instead of 262144, icu.generation_bits 8 instead of 4"
    assert overridden_text(changes) == text
    assert set(changes) == {"icu.rays", "icu.generation_bits"}
    noc = SimpleNamespace(nodes=8, topology="torus")
    caster = SimpleNamespace(_simulated=SimpleNamespace(config=SimpleNamespace(noc=noc)), _changes=changes,
                             frusta=1, rays=1, cycles=1, tested=1, cells={0.5: 1}, _cell=None)
    assert MachineCaster.summary(caster).startswith("machine: 8 clusters, torus, cell 0.5 (chosen), 1 frusta")
    assert MachineCaster.summary(caster).endswith(text)
    assert overridden_text({}) == ""


def test_a_cell_size_is_a_number_or_the_methods_choice(folder):
    words = ("cast", "cornell", "--patch", "0", "--rays", "16x4", "--json")
    reports = [json.loads(run(radiosity.cli.main, *words, *given).stdout)
               for given in ((), ("--cell", "auto"), ("--cell", "0.0625"))]
    assert reports[0] == reports[1] == reports[2]
    for wrong in "automatic", "0":
        result = run(radiosity.cli.main, *words, "--cell", wrong)
        assert (result.exit_code, "is not a finite number above 0" in result.stderr) == (2, True)


def test_a_cast_names_what_the_simulation_overrides(folder, monkeypatch):
    """On a machine that finds nothing."""
    class Machine:
        def __init__(self, config, **_):
            self._config = config

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def cast(self, image, **_):
            return CastResult(image=image.with_results(image.hits()), cycles=1, load_cycles=0, result_cycles=0,
                              counters=[dict.fromkeys(COUNTERS, 0)] * self._config.noc.nodes,
                              shared=dict.fromkeys(SHARED_COUNTERS, 0))

    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedMachine", Machine)
    words = (*COMMAND_WORDS["cast"], *ON, "--preset", "thesis")
    assert ("machine: 8 clusters, torus, 20 patches, cell 0.5; simulated with icu.rays 16384 instead of 262144, "
            "icu.generation_bits 8 instead of 4\n") in run(radiosity.cli.main, *words).stdout
    assert json.loads(run(radiosity.cli.main, *words, "--json").stdout)["machine"]["overridden"] == {
        "icu.rays": {"simulated": 16384, "given": 262144}, "icu.generation_bits": {"simulated": 8, "given": 4}}


@pytest.mark.parametrize("right", [True, False])
def test_sums_that_are_not_those_of_the_hits_are_refused(right):
    """A machine without hits, whose sums say so or say nothing."""
    hemisphere, scene = Hemisphere(16, 4), open_scene("tetra:1")
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")

    def cast(image, **_):
        written = image.with_results(image.hits()) if right else image
        return CastResult(image=written, cycles=1, load_cycles=0, result_cycles=0, shared={},
                          counters=[{"intersection_tested": 0, "traversal_steps": 0}])

    caster = MachineCaster(scene, SimpleNamespace(config=config, cast=cast), cell=0.5)
    point, frames = scene.vertices.mean(axis=(0, 1))[None], np.eye(3)[None]
    found, first = caster.hemispheres(hemisphere, point, frames, np.array([-1])), np.zeros(1, dtype=np.int64)
    with nullcontext() if right else pytest.raises(RuntimeError, match="sums are not those of its hits"):
        assert found(first, first, Rays(origin=point, direction=frames[:, 2])).patch == [-1]


def test_cells_are_chosen_for_each_request(monkeypatch):
    """From four of its frusta, when the first of them is cast."""
    hemisphere, scene = Hemisphere(16, 4), open_scene("tetra:1")
    config, cells = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh"), [0.5, 0.25]
    requested, tables = [], []

    def choose(records, _, given):
        assert given is config
        requested.append([record.origin.tolist() for record in records])
        return SimpleNamespace(cell=cells[len(requested) - 1])

    def cast(image, **_):
        tables.append(len(image["cells"]))
        return CastResult(image=image.with_results(image.hits()), cycles=1, load_cycles=0, result_cycles=0, shared={},
                          counters=[{"intersection_tested": 0, "traversal_steps": 0}])

    monkeypatch.setattr("hw.simulator.machine_caster.choose_cell", choose)
    caster = MachineCaster(scene, SimpleNamespace(config=config, cast=cast), cell=None)
    middle, frames, count = scene.vertices.mean(axis=(0, 1)), np.repeat(np.eye(3)[None], 9, axis=0), 9
    for request in range(2):
        points = middle + np.arange(count)[:, None] * 1e-3
        found = caster.hemispheres(hemisphere, points, frames, np.full(count, -1))
        assert len(requested) == request
        for number in range(3):
            one = np.array([number])
            found(one, np.zeros(1, dtype=np.int64), Rays(origin=points[one], direction=frames[one, 2]))
    assert [len(origins) for origins in requested] == [4, 4]
    assert len(set(map(tuple, requested[0]))) == 4
    assert caster.cells == {0.5: 3, 0.25: 3}
    assert len(set(tables[:3])) == len(set(tables[3:])) == 1
    assert tables[0] < tables[3]
    assert ", cell 0.5, 0.25 (chosen), 6 frusta, " in caster.summary()
    assert caster.counts()["cells"] == {0.5: 3, 0.25: 3}


def test_utilization_of_a_timeline():
    def counters(tests, patches):
        return {"intersection_tested": tests, "intersection_patches": patches, "traversal_steps": 0,
                "traversal_rays": tests // 4, "traversal_requests": 0}

    step = SAMPLE_CYCLES
    samples = [(0, [counters(900, 90)]), (step, [counters(0, 0)]), (2 * step, [counters(step // 2, step // 4)])]
    at, busy = utilization(samples, PRESETS["tiny"])
    assert at.tolist() == [step / 2, 3 * step / 2]
    assert busy["tests"].tolist() == [0, 0.5]
    assert busy["patches"].tolist() == [0, 1]
    assert busy["grid rays"].tolist() == [0, 0.125]


def test_tests_are_shared_out_to_the_last_one():
    shares_of = MachineCaster._shares(11, 4)
    assert shares_of.tolist() == [3, 3, 3, 2]


def test_a_cast_adds_up_its_clusters():
    one = {"traversal_steps": 90, "traversal_requests": 40, "traversal_rays": 30, "traversal_cells": 35,
           "intersection_tested": 70, "intersection_patches": 20, "memory_remote": 10}
    cast = CastResult(image=None, cycles=100, load_cycles=0, result_cycles=0,
                      counters=[one, one | {"memory_remote": 0}], shared={"flits": 120})
    assert cast.bound(PRESETS["tiny"]) == {"traversal": 45, "intersection": 70, "patches": 80}
    cast.counters[1]["traversal_cells"] = 46
    assert cast.bound(PRESETS["tiny"])["traversal"] == 46
    assert cast.total("memory_remote") == 10
    assert cast.links(PRESETS["tiny"]) == 1.0


@ONE_CLUSTER
def test_cast(folder):
    report = json.loads(run(radiosity.cli.main, *CAST, "--json", "-o", "hits.npz", "--compare", "naive").stdout)
    found = report["machine"]
    assert found["differences"] == found["sums"] == report["naive"]["differences"] == 0
    assert report["hits"] == found["hits"] > 0
    assert found["cycles"] <= found["first_cycles"]
    assert 0 < found["efficiency"] <= 1
    assert 0 < found["of_bound"] <= 1
    assert found["overridden"] == {}
    assert sum(found["sources"].values()) == found["each"][0]["memory_found"]
    run(golden.cli.main, "cast", "cornell", "--patch", "4", "--rays", "32x8", "-o", "expected.npz")
    with np.load("hits.npz") as machine, np.load("expected.npz") as expected:
        assert {name: machine[name].tobytes() for name in machine} == {
            name: expected[name].tobytes() for name in expected}
    result = run(radiosity.cli.main, *CAST, "--timeline", "busy.svg")
    assert result.exit_code == 0, result.stderr
    assert "differences from golden: 0 hits, 0 sums" in result.stdout
    assert "intersection tested" in result.stdout
    chart = (folder / "busy.svg").read_text()
    assert chart.count("<polyline") == 5
    # A cast of some thousand cycles has more than a few points.
    assert len(re.search(r'<polyline points="([^"]*)"', chart)[1].split()) > 4


@ONE_CLUSTER
def test_the_timeline_ends_with_the_cast(folder, monkeypatch):
    kept = []
    monkeypatch.setattr("radiosity.machine_cast.write_timeline", lambda path, samples, *_, **__: kept.extend(samples))
    report = json.loads(run(radiosity.cli.main, *CAST, "--json", "--timeline", "busy.svg").stdout)["machine"]
    cycle, counters = kept[-1]
    assert cycle == report["cycles"]
    assert counters[0]["intersection_tested"] == report["each"][0]["intersection_tested"]
    assert [at for at, _ in kept] == sorted({at for at, _ in kept})


def test_counters_as_a_table(tmp_path):
    casts = [CastResult(image=None, cycles=cycles, load_cycles=0, result_cycles=0, shared={},
                        counters=[{"cycles": cycles, "b": 2}, {"cycles": 3, "b": 4}]) for cycles in (100, 90)]
    write_counters(tmp_path / "counters.csv", casts)
    with (tmp_path / "counters.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert len(set(header)) == len(header)
    assert header == ["cast", "cluster", "cast_cycles", "cycles", "b"]
    assert rows == [["0", "0", "100", "100", "2"], ["0", "1", "100", "3", "4"],
                    ["1", "0", "90", "90", "2"], ["1", "1", "90", "3", "4"]]


@pytest.mark.nightly
@pytest.mark.parametrize("clusters", [1, 2])
def test_waveforms(folder, clusters):
    result = run(radiosity.cli.main, *CAST, "--clusters", clusters, "--waves", "cast.vcd", "--waves-begin", "100",
                 "--waves-cycles", "50", "--csv", "counters.csv")
    assert result.exit_code == 0, result.stderr
    text = (folder / "cast.vcd").read_text()
    times = [int(line[1:]) for line in text.splitlines() if line.startswith("#")]
    # Both edges of the clock in each cycle, and units inside the clusters.
    assert times == list(range(times[0], times[0] + 2 * 50))
    assert text.count("module intersection ") >= clusters
    view = (folder / "cast.gtkw").read_text()
    assert view.startswith('[dumpfile] "cast.vcd"\n')
    assert all(f"-cluster_{number} traversal\n" in view for number in range(clusters))
    # A sixth of what all wires and memories take.
    assert len(text) < 2_000_000 * clusters
    assert len((folder / "counters.csv").read_text().splitlines()) == 1 + 3 * clusters


@ONE_CLUSTER
def test_a_difference_is_reported(folder, monkeypatch):
    expected = golden.memory_map.MemoryImage.with_results

    def another(image, hits):
        result = expected(image, hits)
        result["hits"]["patch"][3] += 1
        return result

    monkeypatch.setattr("golden.memory_map.MemoryImage.with_results", another)
    result = run(radiosity.cli.main, *CAST)
    assert result.exit_code == 1
    assert "differences from golden: 1 hit, " in result.stdout


@ONE_CLUSTER
def test_form_factors_are_goldens(folder):
    result = run(radiosity.cli.main, "formfactors", "cornell", "-o", "machine.npz", "--rays", "32x8", *MACHINE)
    assert result.exit_code == 0, result.stderr
    run(golden.cli.main, "formfactors", "cornell", "-o", "golden.npz", "--rays", "32x8", "--method", "shelling")
    with np.load("machine.npz") as machine, np.load("golden.npz") as expected:
        assert set(machine) == set(expected)
        for name in expected:
            assert machine[name].tobytes() == expected[name].tobytes(), name
    assert "frusta" in result.stdout


@ONE_CLUSTER
def test_an_image_is_goldens_with_all_of_its_options(folder):
    view = ("--size", "24x24", "--eye", "278,273,-600", "--target", "278,273,0", "--fov", "45", "--sky", "0.1,0.2,0.3",
            "--tone", "linear", *COARSE)
    result = run(radiosity.cli.main, "render", "cornell", "-o", "machine.png", "-o", "machine.exr", "--stats",
                 "machine.json", *view, *MACHINE)
    assert result.exit_code == 0, result.stderr
    run(golden.cli.main, "render", "cornell", "-o", "golden.png", "-o", "golden.exr", "--method", "shelling", *view)
    for suffix in "png", "exr":
        assert (folder / f"machine.{suffix}").read_bytes() == (folder / f"golden.{suffix}").read_bytes()
    stats = json.loads((folder / "machine.json").read_text())
    assert stats["settings"]["method"] == "machine"
    assert 0 < stats["machine"]["share"] < 1
    assert stats["machine"]["rays"] >= stats["rays"]["primary"]["rays"]
    assert "of all rays by method machine" in result.stdout

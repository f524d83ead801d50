"""The commands as a user gives them."""

import csv
import json
import re
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import golden.engine.schedule.job_shelling
import radiosity.cli.golden.main
import radiosity.cli.main
import radiosity.tasks.machine_cast
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.cast.screen import Screen
from golden.cast.shadow_rays import ShadowRays
from golden.engine.cast.fixed_frusta import ShellingFrusta, shares
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import PRESETS, Noc
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.run_job import run_job
from golden.scene.camera import Camera
from golden.scene.open import open_scene
from hw.cluster import COUNTERS
from hw.ctu.ctu_formats import GRID_GROUP
from hw.memsys.bus.cache_policy import CachePolicy
from hw.registers.error_code import ErrorCode
from radiosity.flow.host import EngineError, EngineTimeoutError
from radiosity.flow.simulator.cast_report import cast_report
from radiosity.flow.simulator.job_result import SHARED_COUNTERS, FrustumResult, JobCycles, JobResult
from radiosity.flow.simulator.machine_caster import MachineCaster
from radiosity.flow.simulator.simulated_machine import SAMPLE_CYCLES
from radiosity.flow.simulator.simulation_config import overridden, overridden_text, simulation_config
from radiosity.flow.simulator.utilization import SAMPLED, utilization
from radiosity.flow.synthesis.history import ROOT
from radiosity.tasks.machine_cast import write_counters
from tb.system.checked_machine import use_checked_machines
from tb.system.job_machine import SHADOWS, SMALL, TWO_CLUSTERS

# The small machine of two clusters that tb/system has too.
MACHINE = ("--method", "machine", "--preset", "tiny", "--clusters", "2", "--cell", "0.5", "-P", "ctu.run_ahead=2",
           *(word for name, value in SMALL.items() if name != "noc.rows" for word in ("-P", f"{name}={value}")))
SHADOW_MACHINE = (*MACHINE, *(word for name, value in SHADOWS.items() for word in ("-P", f"{name}={value}")))
COARSE = ("--light-samples", "1", "--depth", "1", "--spp", "1", "--rays", "16x4", "--max-edge", "1000")
CAST = ("cast", "cornell", "--patch", "4", "--rays", "32x8", "--ratio", "16", *MACHINE)
ON = ("--method", "machine")


@pytest.fixture(autouse=True)
def machine(monkeypatch):
    """Commands cast on the machine that tb/system has built, which checks the rules of its components."""
    use_checked_machines(monkeypatch)


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
    "two numbers of clusters": (("cast", "cornell", "--patch", "0", *ON, "--clusters", "1", "-P",
                                 "noc.rows=2"),
                                "--clusters sets noc.rows (--clusters 1 here), so -P noc.rows cannot be given"),
    "two topologies": (("cast", "cornell", "--patch", "0", *ON, "--preset", "thesis", "--topology", "ring", "-P",
                        "noc.topology=mesh"), "--topology sets noc.topology (--topology ring here)"),
    "room": (("cast", "cornell", "--patch", "0", *ON, "--preset", "thesis", "--cell", "0.5", "--rays", "1024x256"),
             "the capacity is 16384"),
    "timeline": (("cast", "cornell", "--patch", "0", *ON, "--timeline", "a.png"), "must end in .svg"),
    "waves": (("cast", "cornell", "--patch", "0", *ON, "--waves", "a.fst"), "must end in .vcd"),
    "counters": (("cast", "cornell", "--patch", "0", *ON, "--csv", "a.json"), "must end in .csv"),
    "no output": (("formfactors", "cornell", *ON), "Missing option '-o'"),
    "form factors": (("formfactors", "cornell", *ON, "-o", "a.txt"), "must end in .npz"),
    "rays": (("formfactors", "cornell", *ON, "-o", "a.npz", "--rays", "10x3"), "power"),
    "numbers": (("formfactors", "cornell", *ON, "-o", "a.npz", "-P", "numbers.scene_bits=18"), "numbers."),
    "shadow frusta": (("formfactors", "cornell", *ON, "-o", "a.npz", "--rays", "64x16", "-P", "icu.shadow_bits=4", "-P",
                       "icu.side_bits=7"),
                      "Shadow frusta (icu.shadow_bits) need an icu.side_bits of at least 8 here, not 7"),
    "image": (("render", "cornell", *ON, "-o", "a.jpg"), "must end in .png or .exr"),
    "size": (("render", "cornell", *ON, "-o", "a.png", "--size", "5000x4"), "at most 4096 columns and rows of rays "
              "(icu.side_bits), not 10000 x 8"),
    "a chart of shadow rays": (("cast", "cornell", "--kind", "shadow", "--patch", "0", *ON, "--timeline", "a.svg"),
                               "--timeline does not go with --kind shadow"),
    "many rays": (("formfactors", "cornell", *ON, "-o", "a.npz", "--rays", "128x32", "-P", "icu.side_bits=6"),
                  "at most 64 columns and rows of rays (icu.side_bits), not 128 x 32"),
    "dark": (("render", "tetra:1", *ON, "-o", "a.png", "--size", "0x4"), "Width must be 1 to"),
    "another method's option": (("render", "cornell", "-o", "a.png", "--topology", "ring"),
                                "--topology needs --method machine"),
    "another method's option of cast": (("cast", "cornell", "--patch", "0", "--casts", "2"),
                                        "--casts needs --method machine"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(folder, case):
    arguments, says = BAD[case]
    result = run(radiosity.cli.main.main, *arguments)
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1, result.stderr
    assert says in result.stderr
    assert not list(folder.iterdir())


@pytest.mark.parametrize("bits", [5, 12])
@pytest.mark.parametrize("spread", [0, 9])
def test_memory_that_is_slower_than_the_timeout_is_refused(monkeypatch, bits, spread):
    def made(*_, **__):
        raise RuntimeError("made")

    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine.__init__", made)
    for latency, says in ((1 << bits) - 1 - spread, "made"), ((1 << bits) - spread, "memory.timeout_bits"):
        result = run(radiosity.cli.main.main, "cast", "cornell", "--patch", "0", "--rays", "16x4", "--cell", "0.5", *ON,
                     "--latency", latency, "--spread", spread, "-P", f"memory.timeout_bits={bits}")
        assert result.exit_code == 2
        assert says in result.stderr


def test_the_machines_errors_are_lines_too(folder, monkeypatch):
    def fails(*_, **__):
        raise RuntimeError("verilator fails")

    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine.__init__", fails)
    result = run(radiosity.cli.main.main, "cast", "cornell", "--patch", "0", "--rays", "16x4", "--cell", "0.5",
                 "--ratio",
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

    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine.__init__", keep)
    assert run(radiosity.cli.main.main, *command, *ON, *OPTIONS).stderr == "error: machine: enough\n"
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

    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine.__init__", keep)
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
    (("--preset", "large"), 16, "torus", 6),
    (("--clusters", "1"), 1, "mesh", 6),
    ((), 8, "mesh", 6)], ids=lambda value: "-".join(value) if isinstance(value, tuple) else None)
def test_the_machine_is_that_of_its_preset(machines, command, options, nodes, topology, run_ahead):
    result = run(radiosity.cli.main.main, *COMMAND_WORDS[command], *ON, *options)
    assert result.stderr == "error: machine: enough\n"
    (config,) = machines
    assert (config.noc.nodes, config.noc.topology, config.ctu.run_ahead) == (nodes, topology, run_ahead)
    assert (config.icu.rays, config.icu.generation_bits) == (1 << 14, 8)


@pytest.mark.parametrize("command", ["cast", "formfactors", "render"])
def test_help_names_the_defaults_of_the_machine(command):
    text = " ".join(run(radiosity.cli.main.main, command, "--help").stdout.split()).replace("- ", "-")
    for about in ("Unless -P sets them, it has icu.rays=16384, icu.generation_bits=8 and a run-ahead depth",
                  "[default: 1; the preset's with --method machine]" if command == "cast" else
                  "a power of two up to 64. [default: the preset's]",
                  "Set the machine's network. [default: the preset's]"):
        assert about in text, text
    waves = "some 0.03 MB a cycle with four clusters; beside it a save file for GTKWave (.gtkw). Needs a second"
    assert (waves in text) == (command == "cast")


def test_what_the_simulation_overrides_is_named():
    given = PRESETS["thesis"]
    changes = overridden(simulation_config(given, clusters=None, topology=None), given)
    text = "; simulated with icu.rays 16384 instead of 262144, icu.generation_bits 8 instead of 4"
    assert overridden_text(changes) == text
    assert set(changes) == {"icu.rays", "icu.generation_bits"}
    # Ten nodes.
    noc = Noc(topology="torus", columns=5, patch_nodes=2)
    caster = SimpleNamespace(_simulated=SimpleNamespace(config=SimpleNamespace(noc=noc)), _changes=changes,
                             jobs=1, frusta=1, rays=1, cycles=1, tested=1, cells={0.5: 1}, _cell=None, kinds={})
    assert MachineCaster.summary(caster).startswith("machine: 8 clusters, torus, cell 0.5 (chosen), 1 job, 1 frusta")
    assert MachineCaster.summary(caster).endswith(text)
    assert overridden_text({}) == ""


def test_a_cell_size_is_a_number_or_the_methods_choice(folder):
    words = ("cast", "cornell", "--patch", "0", "--rays", "16x4", "--json")
    reports = [json.loads(run(radiosity.cli.main.main, *words, *given).stdout)
               for given in ((), ("--cell", "auto"), ("--cell", "0.0625"))]
    assert reports[0] == reports[1] == reports[2]
    for wrong in "automatic", "0":
        result = run(radiosity.cli.main.main, *words, "--cell", wrong)
        assert (result.exit_code, "is not a finite number above 0" in result.stderr) == (2, True)


def result(request, *, sums=True):
    """The results of a machine that finds nothing, and of the sums that it says so, or none."""
    count, patches = len(request.records[0]), len(request.geometry)
    nothing = np.full(count, -1)
    zeros = np.zeros(count, dtype=np.int64)
    hits = nothing if request.hit_format == HitFormat.IDS else FixedHits(
        inverse=zeros, patch=nothing, u=zeros, v=zeros)
    record = np.zeros(1, COMPLETION.dtype)
    record["tested"], record["steps"] = 2 * count + 1, 3
    one = FrustumResult(hits=hits, records=record,
                        sums=np.full(patches, 0 if sums else 1, dtype=np.int64) if request.sums else None)
    return JobResult(job=None, frusta=((one,) * len(request.records),), records=record,
                     cycles=JobCycles(total=9, load=3, cast=4, results=2),
                     counters=[dict.fromkeys(COUNTERS, 0)] * request.clusters,
                     shared=dict.fromkeys(SHARED_COUNTERS, 0))


def test_a_cast_names_what_the_simulation_overrides(folder, monkeypatch):
    """On a machine that finds nothing."""
    class Machine:
        def __init__(self, config, **_):
            self._config = config

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def run(self, requests, **_):
            (request,) = requests
            return result(request)

    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine", Machine)
    words = (*COMMAND_WORDS["cast"], *ON, "--preset", "thesis")
    text = run(radiosity.cli.main.main, *words).stdout
    assert ("machine: 8 clusters, torus, 20 patches, cell 0.5; simulated with icu.rays 16384 instead of 262144, "
            "icu.generation_bits 8 instead of 4\n") in text
    assert "cycles 9: cast 4, results 2 after it; the first time 9, of which tables 3\n" in text
    assert json.loads(run(radiosity.cli.main.main, *words, "--json").stdout)["machine"]["overridden"] == {
        "icu.rays": {"simulated": 16384, "given": 262144}, "icu.generation_bits": {"simulated": 8, "given": 4}}


@pytest.mark.parametrize("error", [EngineTimeoutError("no answer"), EngineError(ErrorCode.WATCHDOG, 0, 0)])
@pytest.mark.parametrize("command", ["cast", "formfactors"])
def test_errors_of_the_machine_are_one_line(folder, monkeypatch, command, error):
    class Machine:
        def __init__(self, config, **_):
            self.config = config

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def run(self, requests, **_):
            raise error

    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine", Machine)
    result = run(radiosity.cli.main.main, *COMMAND_WORDS[command], *ON)
    assert (result.exit_code, result.stderr) == (2, f"error: machine: {error}\n")


@pytest.mark.parametrize("right", [True, False])
def test_sums_that_are_not_those_of_the_hits_are_refused(right):
    """A machine without hits, whose sums say so or say something else."""
    hemisphere, scene = Hemisphere(16, 4), open_scene("tetra:1")
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")

    def cast(requests, **_):
        return result(*requests, sums=right)

    caster = MachineCaster(scene, SimpleNamespace(config=config, run=cast), cell=0.5)
    point, frames = scene.vertices.mean(axis=(0, 1))[None], np.eye(3)[None]
    found, first = caster.hemispheres(hemisphere, point, frames, np.array([-1])), np.zeros(1, dtype=np.int64)
    with nullcontext() if right else pytest.raises(RuntimeError, match="sums are not those of its hits"):
        assert found(first, first, Rays(origin=point, direction=frames[:, 2])).patch == [-1]


def golden_machine(config):
    """A machine that leaves what golden does of a job of one phase, after a cycle for each descriptor."""
    def run(requests, **_):
        job = plan_job(requests, config)
        memory = bytearray(job.end)
        for address, data in run_job(job).memory.items():
            memory[address:address + len(data)] = data
        tested = np.zeros(1, COMPLETION.dtype)
        tested["tested"] = 1001
        return SimpleNamespace(cycles=SimpleNamespace(total=len(job.descriptors)), frusta=(tuple(FrustumResult(
            hits=job.blocked(0, number, lambda address, size: bytes(memory[address:address + size])), sums=None,
            records=tested) for number in range(len(requests[0].records))),))
    return SimpleNamespace(config=config, run=run)


@pytest.mark.parametrize("bits", [0, 5])
def test_shadow_rays_are_blocked_as_by_shelling(bits):
    """The host casts them where the machine has no shadow frusta; else a list that is too long is cast in parts."""
    scene = open_scene("cornell")
    config = simulation_config(PRESETS["tiny"], clusters=2, topology="mesh").replace(
        {"icu.shadow_bits": bits, "icu.side_bits": 8})
    random, target = np.random.default_rng(1), np.arange(400) % len(scene)
    rays = ShadowRays(points=scene.centres[:1], surfaces=scene.surface[:1], light=np.zeros(400, dtype=int),
                      targets=np.einsum("kc,kci->ki", random.dirichlet(np.ones(4), 400), scene.vertices[target]),
                      normals=scene.normals[target])
    caster = MachineCaster(scene, golden_machine(config), cell=0.5)
    machine, shelling = (one.shadows(rays) for one in (caster, ShellingFrusta(scene)))
    np.testing.assert_array_equal(machine.blocked, shelling.blocked)
    np.testing.assert_array_equal(machine.cast, shelling.cast)
    assert 0 < machine.blocked.sum() < machine.cast.sum()
    if not bits:
        assert caster.kinds == {}
        return
    (name, counts), = caster.kinds.items()
    assert name == "shadow frusta"
    assert machine.cast.sum() - 32 < counts["rays"] <= machine.cast.sum()
    assert counts["frusta"] > counts["rays"] / 32
    assert counts["tests"] == caster.tested == 1001 * counts["frusta"] == machine.tests.sum()
    assert f"rays per cycle: shadow frusta {counts['rays'] / caster.cycles:.3f}, " in caster.summary()


def test_shadow_rays_of_a_cast_have_the_bytes_of_shelling(folder, monkeypatch):
    """On a machine that leaves what golden does."""
    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedMachine",
                        lambda config, **_: nullcontext(golden_machine(config)))
    words = ("cast", "cornell", "--kind", "shadow", "--patch", "0", "--cell", "0.5", "-o")
    result = run(radiosity.cli.main.main, *words, "machine.npz", *ON, "--preset", "tiny", "--clusters", "1")
    assert result.exit_code == 0, result.stderr
    assert "icu.shadow_bits 12 instead of 0" in result.stdout
    assert result.stdout.endswith("machine: 0 differences\n")
    run(radiosity.cli.main.main, *words, "golden.npz")
    assert (folder / "machine.npz").read_bytes() == (folder / "golden.npz").read_bytes()
    with np.load("machine.npz") as found:
        seen = radiosity.visible(radiosity.load("cornell"), patch=0, method="machine", preset="tiny", cell=0.5)
        assert seen.tolist() == found["visible"].tolist()


def test_rays_and_cycles_of_screens_are_counted_apart():
    scene, config = open_scene("tetra:1"), simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    caster = MachineCaster(scene, SimpleNamespace(config=config, run=lambda requests, **_: result(*requests)), cell=0.5)
    Request(caster, scene).cast(*range(9))
    camera = Camera(eye=scene.vertices.mean(axis=(0, 1)), target=scene.vertices[0, 0], up=(1, 2, 3))
    zero = np.zeros(1, dtype=np.int64)
    caster.screen(Screen(camera=camera, width=8, height=4), 2)(
        zero, zero, Rays(origin=np.zeros((1, 3)), direction=np.ones((1, 3))))
    assert caster.kinds == {"hemispheres": {"frusta": 9, "rays": 9 * 64, "cycles": 9, "tests": 9 * 129},
                            "screens": {"frusta": 1, "rays": 16 * 8, "cycles": 9, "tests": 257}}
    assert "rays per cycle: hemispheres 64.000, screens 14.222, pipeline efficiency" in caster.summary()


class Request:
    """Hemispheres at some points of a scene, requested from a caster."""

    count = 9

    def __init__(self, caster, scene):
        self._points = scene.vertices.mean(axis=(0, 1)) + np.arange(self.count)[:, None] * 1e-3
        self._frames = np.repeat(np.eye(3)[None], self.count, axis=0)
        self._found = caster.hemispheres(Hemisphere(16, 4), self._points, self._frames, np.full(self.count, -1))

    def cast(self, *numbers):
        """The hits of one ray of each of some hemispheres."""
        which = np.array(numbers)
        return self._found(which, np.zeros(len(which), dtype=np.int64), Rays(
            origin=self._points[which], direction=self._frames[which, 2]))


def test_cells_are_chosen_for_each_request(monkeypatch):
    """From four of its frusta, when the first of them is cast."""
    scene, config = open_scene("tetra:1"), simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    cells, requested, tables = [0.5, 0.25], [], []

    def choose(records, _, given):
        assert given is config
        requested.append([record.origin.tolist() for record in records])
        return SimpleNamespace(cell=cells[len(requested) - 1])

    def cast(requests, **_):
        tables.append(len(requests[0].table))
        return result(*requests)

    monkeypatch.setattr("radiosity.flow.simulator.machine_caster.choose_cell", choose)
    monkeypatch.setattr(MachineCaster, "together", 3 * 64)
    caster = MachineCaster(scene, SimpleNamespace(config=config, run=cast), cell=None)
    for number in range(2):
        request = Request(caster, scene)
        assert len(requested) == number
        for frustum in range(6):
            request.cast(frustum)
    assert [len(origins) for origins in requested] == [4, 4]
    assert len(set(map(tuple, requested[0]))) == 4
    assert caster.cells == {0.5: 6, 0.25: 6}
    assert len(tables) == 4
    assert len(set(tables[:2])) == len(set(tables[2:])) == 1
    assert tables[0] < tables[3]
    assert ", cell 0.5, 0.25 (chosen), 4 jobs, 12 frusta, " in caster.summary()
    assert caster.counts()["cells"] == {0.5: 6, 0.25: 6}
    assert caster.counts()["kinds"] == {"hemispheres": {
        "frusta": 12, "rays": 12 * 64, "cycles": caster.cycles, "tests": 12 * 129}}
    assert f", rays per cycle: hemispheres {12 * 64 / caster.cycles:.3f}, " in caster.summary()


@pytest.mark.parametrize(("together", "frusta"), [(1 << 22, [9]), (4 * 64, [4, 4, 1]), (64, [1] * 9), (1, [1] * 9)])
def test_all_hemispheres_of_a_request_are_a_job(monkeypatch, together, frusta):
    """Or several, of as many rays as are cast together."""
    scene, config = open_scene("tetra:1"), simulation_config(PRESETS["tiny"], clusters=4, topology="mesh")
    jobs = []

    def cast(requests, **_):
        (request,) = requests
        jobs.append((len(request.records), request.clusters, request.hit_format, request.sums))
        return result(request)

    monkeypatch.setattr(MachineCaster, "together", together)
    caster = MachineCaster(scene, SimpleNamespace(config=config, run=cast), cell=0.5)
    found = Request(caster, scene).cast(*range(9))
    assert [count for count, *_ in jobs] == frusta
    # Fewer frusta than clusters are cut, as far as there are tiles.
    assert [clusters for _, clusters, *_ in jobs] == [1 if count >= 4 else 2 for count in frusta]
    assert {tuple(job[2:]) for job in jobs} == {(HitFormat.IDS, True)}
    assert (caster.jobs, caster.frusta, caster.rays, caster.cycles) == (len(frusta), 9, 9 * 64, 9 * len(frusta))
    # Of each frustum the first rays have what does not divide evenly.
    assert found.tests.tolist() == [3] * 9
    assert found.steps.tolist() == [1] * 9
    assert caster.tested == 9 * 129


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
    # Of two clusters one is idle; each unit has a rate of its own.
    idle = dict.fromkeys(SAMPLED, 0)
    samples = [(100, [idle, idle]), (164, [idle, dict.fromkeys(SAMPLED, 16)])]
    at, busy = utilization(samples, PRESETS["tiny"])
    assert at.tolist() == [132]
    assert {unit: share.tolist() for unit, share in busy.items()} == {
        "tests": [1 / 8], "patches": [1 / 2], "steps": [1 / 16], "grid rays": [1 / 8],
        "requests": [1 / 8 / GRID_GROUP]}


def test_tests_are_shared_out_to_the_last_one():
    assert shares(11, 4).tolist() == [3, 3, 3, 2]


def job_result(counters, *, cast=100, **shared):
    """Of a job, the counters alone."""
    return JobResult(job=None, frusta=(), records=None, counters=counters, shared=shared,
                     cycles=JobCycles(total=2 * cast, load=0, cast=cast, results=0))


def test_a_cast_adds_up_its_clusters():
    one = {"traversal_steps": 90, "traversal_requests": 40, "traversal_rays": 30, "traversal_cells": 35,
           "intersection_tested": 70, "memory_found": 20, "memory_remote": 10}
    cast = job_result([one, one | {"memory_remote": 0}], flits=120)
    assert cast.bound(PRESETS["tiny"]) == {"traversal": 45, "intersection": 70, "patches": 80}
    cast.counters[1]["traversal_cells"] = 46
    assert cast.bound(PRESETS["tiny"])["traversal"] == 46
    assert cast.total("memory_remote") == 10
    assert cast.links(PRESETS["tiny"]) == 1.0
    # Clusters that have cast several sections have fewer counters.
    few = {name: one[name] for name in ("traversal_steps", "intersection_tested", "memory_found")}
    assert job_result([few]).bound(PRESETS["tiny"]) == {"traversal": 45, "intersection": 70, "patches": 80}


@pytest.mark.parametrize(("changes", "unit", "bound"), [
    ({"traversal_steps": 2 * 90 + 1}, "traversal", 91), ({"traversal_rays": 91}, "traversal", 91),
    ({"traversal_cells": 91}, "traversal", 91), ({"traversal_requests": 90 * GRID_GROUP + 1}, "traversal", 91),
    ({"intersection_tested": 91}, "intersection", 91), ({"memory_found": 91}, "patches", 364)])
@pytest.mark.parametrize("busiest", [0, 1])
def test_each_counter_of_the_busiest_cluster_bounds_its_unit(changes, unit, bound, busiest):
    """Rounded up: a part of a cycle is one."""
    one = dict.fromkeys(("traversal_steps", "traversal_requests", "traversal_rays", "traversal_cells",
                         "intersection_tested", "memory_found"), 5)
    clusters = [one, one]
    clusters[busiest] = one | changes
    assert PRESETS["tiny"].ctu.traversal_pipelines(PRESETS["tiny"].noc.nodes) == 2
    assert job_result(clusters).bound(PRESETS["tiny"]) == {
        "traversal": 5, "intersection": 5, "patches": 20} | {unit: bound}


def test_the_report_of_a_cast_has_the_figures_of_the_last_job():
    """Of the first one its cycles and those of its load; each counter, rate and bound is one of its own."""
    zeros = dict.fromkeys(("traversal_requests", "traversal_rays", "traversal_cells"), 0)
    sources = {f"memory_{name}": count for name, count in zip(
        ("own", "kept", "remote", "hits", "misses"), (3, 5, 7, 11, 13), strict=True)}
    one = zeros | sources | {"memory_deferred": 17, "traversal_steps": 90, "intersection_tested": 70,
                             "memory_found": 20}
    two = one | {"intersection_tested": 50, "memory_found": 0}
    frustum = FrustumResult(hits=np.array([-1, 0, 4, -1, 0]), sums=None, records=np.zeros(3, COMPLETION.dtype))
    first, last = (JobResult(
        job=None, frusta=((frustum,),), records=None, counters=[one, two], shared={"flits": flits},
        cycles=JobCycles(total=total, load=load, cast=100, results=results))
        for total, load, results, flits in ((900, 80, 60, 0), (500, 8, 6, 224)))
    report = cast_report(range(5), [first, first, last], PRESETS["tiny"])
    assert report == {
        "rays": 5, "hits": 3, "cycles": 500, "first_cycles": 900, "load_cycles": 80, "cast_cycles": 100,
        "result_cycles": 6, "sections": 3, "bound": {"traversal": 45, "intersection": 70, "patches": 80},
        "of_bound": 0.8, "efficiency": 0.6, "tests_per_ray": 24.0, "edrc": 6.0,
        "links": last.links(PRESETS["tiny"]), "deferred": 34, "shared": {"flits": 224},
        "sources": {name.partition("_")[2]: 2 * count for name, count in sources.items()},
        "each": [one | {"efficiency": 0.7, "edrc": 3.5}, two | {"efficiency": 0.5, "edrc": 50.0}]}


@pytest.mark.nightly
@pytest.mark.parametrize("words", [
    ("room1627", "--origin", "8,4,4", "--normal", "0,0,-1", "--preset", "small", "--casts", "1"),
    ("city", "--patch", "0", "--casts", "1")], ids=lambda words: words[0])
def test_stores_defer_and_routers_carry_in_a_default_cast(words):
    found = json.loads(run(radiosity.cli.main.main, "cast", *words, *ON, "--json").stdout)["machine"]
    assert found["differences"] == found["sums"] == 0
    page = " ".join((ROOT / "docs" / "istructure.md").read_text().split())
    pair = r"([\d,]+) and ([\d,]+)"
    quoted = re.search(rf"stores defer {pair} requests, and routers carry {pair} flits", page)
    counts = quoted.groups()[words[0] == "city"::2]
    assert counts == (f"{found['deferred']:,}", f"{found['shared']['flits']:,}")
    assert "0" not in counts


@TWO_CLUSTERS
def test_cast(folder):
    report = json.loads(run(radiosity.cli.main.main, *CAST, "--json", "-o", "hits.npz", "--compare", "naive").stdout)
    found = report["machine"]
    assert found["differences"] == found["sums"] == report["naive"]["differences"] == 0
    assert report["hits"] == found["hits"] > 0
    assert found["cycles"] <= found["first_cycles"] - found["load_cycles"]
    assert 0 < found["cast_cycles"] < found["cycles"] - found["result_cycles"]
    assert found["sections"] == found["clusters"] == len(found["each"]) == 2
    assert 0 < found["efficiency"] <= 1
    assert 0 < found["of_bound"] <= 1
    assert found["overridden"] == {}
    assert sum(found["sources"].values()) == sum(one["memory_found"] for one in found["each"])
    assert found["deferred"] == sum(one["memory_deferred"] for one in found["each"]) > 0
    assert found["shared"]["flits"] > 0
    run(radiosity.cli.golden.main.main, "cast", "cornell", "--patch", "4", "--rays", "32x8", "-o", "expected.npz")
    with np.load("hits.npz") as machine, np.load("expected.npz") as expected:
        assert {name: machine[name].tobytes() for name in machine} == {
            name: expected[name].tobytes() for name in expected}
    result = run(radiosity.cli.main.main, *CAST, "--timeline", "busy.svg")
    assert result.exit_code == 0, result.stderr
    assert "differences from golden: 0 hits, 0 sums" in result.stdout
    assert "intersection tested" in result.stdout
    chart = (folder / "busy.svg").read_text()
    assert all(f">{unit}</text>" in chart for unit in ("tests", "patches", "steps", "grid rays", "requests"))
    # A cast of some thousand cycles has more than a few points.
    assert max(1 + path.count("\nL ") for path in re.findall(r'<path d="([^"]*)"', chart)) > 4


@TWO_CLUSTERS
def test_the_timeline_ends_with_the_cast(folder, monkeypatch):
    kept = []
    monkeypatch.setattr("radiosity.tasks.machine_cast.write_timeline", lambda path, samples, *_,
                        **__: kept.extend(samples))
    report = json.loads(run(radiosity.cli.main.main, *CAST, "--json", "--timeline", "busy.svg").stdout)["machine"]
    cycle, counters = kept[-1]
    assert cycle == report["cycles"]
    assert counters[0]["intersection_tested"] == report["each"][0]["intersection_tested"]
    assert [at for at, _ in kept] == sorted({at for at, _ in kept})


def test_counters_as_a_table(tmp_path):
    casts = [job_result([{"cycles": cycles, "b": 2}, {"cycles": 3, "b": 4}], cast=cycles) for cycles in (100, 90)]
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
    result = run(radiosity.cli.main.main, *CAST, "--clusters", clusters, "--waves", "cast.vcd", "--waves-begin", "100",
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


@TWO_CLUSTERS
def test_a_difference_is_reported(folder, monkeypatch):
    class Another(golden.engine.schedule.job_shelling.Shelling):
        def cast(self, record, *arguments, **given):
            hits, counts = super().cast(record, *arguments, **given)
            patch = hits.patch.copy()
            patch[3] += 1
            return replace(hits, patch=patch), counts

    monkeypatch.setattr("golden.engine.schedule.job_shelling.Shelling", Another)
    result = run(radiosity.cli.main.main, *CAST)
    assert result.exit_code == 1
    assert "differences from golden: 1 hit, " in result.stdout


@TWO_CLUSTERS
def test_a_frustum_is_larger_than_the_ray_memories(folder):
    """Of 1024 rays in each of two clusters."""
    report = json.loads(run(radiosity.cli.main.main, "cast", "cornell", "--patch", "4", "--rays", "64x64", "--ratio",
                            "16",
                            *MACHINE, "--casts", "1", "--csv", "counters.csv", "--json").stdout)["machine"]
    assert (report["rays"], report["sections"], report["differences"], report["sums"]) == (4096, 4, 0, 0)
    header, *rows = (folder / "counters.csv").read_text().splitlines()
    assert "intersection_tested" in header
    assert len(rows) == 2


@TWO_CLUSTERS
def test_an_error_in_a_job_is_a_line(folder, monkeypatch):
    monkeypatch.setattr("golden.cast.hemisphere.Hemisphere.polar_weights", property(
        lambda hemisphere: np.full(hemisphere.polars, (1 << 42) - 1)))
    result = run(radiosity.cli.main.main, *CAST)
    assert result.exit_code == 2
    assert re.fullmatch(r"error: machine: frustum 0, columns \d+ to \d+, rows \d+ to \d+: OVERFLOW: the sum of the "
                        r"weights .* \(cluster \d, at 0x\w+\)\n", result.stderr), result.stderr


@TWO_CLUSTERS
def test_form_factors_are_goldens(folder):
    result = run(radiosity.cli.main.main, "formfactors", "cornell", "-o", "machine.npz", "--rays", "32x8", *MACHINE)
    assert result.exit_code == 0, result.stderr
    run(radiosity.cli.golden.main.main, "formfactors", "cornell", "-o", "golden.npz", "--rays", "32x8", "--method",
        "shelling")
    with np.load("machine.npz") as machine, np.load("golden.npz") as expected:
        assert set(machine) == set(expected)
        for name in expected:
            assert machine[name].tobytes() == expected[name].tobytes(), name
    assert "frusta" in result.stdout


@TWO_CLUSTERS
def test_an_image_is_goldens_with_all_of_its_options(folder):
    view = ("--size", "24x20", "--eye", "278,273,-600", "--target", "278,273,0", "--fov", "45", "--sky", "0.1,0.2,0.3",
            "--tone", "linear", *COARSE, "--max-edge", "200")
    result = run(radiosity.cli.main.main, "render", "cornell", "-o", "machine.png", "-o", "machine.exr", "--stats",
                 "machine.json", *view, *MACHINE)
    assert result.exit_code == 0, result.stderr
    run(radiosity.cli.golden.main.main, "render", "cornell", "-o", "golden.png", "-o", "golden.exr", "--method",
        "shelling", *view)
    for suffix in "png", "exr":
        assert (folder / f"machine.{suffix}").read_bytes() == (folder / f"golden.{suffix}").read_bytes()
    stats = json.loads((folder / "machine.json").read_text())
    assert stats["settings"]["method"] == "machine"
    assert 0 < stats["machine"]["share"] < 1
    # Hemispheres, those of elements that adaptive refinement cuts, a screen, and hemispheres beside the boxes.
    assert stats["machine"]["rays"] >= stats["rays"]["primary"]["rays"] == 24 * 20
    assert stats["machine"]["jobs"] == 4
    assert "of all rays by method machine" in result.stdout


@pytest.mark.sim
def test_shadow_rays_of_an_image_are_goldens(folder):
    view = ("--size", "16x12", *COARSE, "--light-samples", "4", "--max-edge", "400")
    result = run(radiosity.cli.main.main, "render", "cornell", "-o", "machine.exr", "--stats", "machine.json", *view,
                 *SHADOW_MACHINE)
    assert result.exit_code == 0, result.stderr
    run(radiosity.cli.golden.main.main, "render", "cornell", "-o", "golden.exr", "--method", "shelling", *view)
    assert (folder / "machine.exr").read_bytes() == (folder / "golden.exr").read_bytes()
    stats = json.loads((folder / "machine.json").read_text())
    shadow, machine = stats["rays"]["shadow"]["rays"], stats["machine"]["kinds"]["shadow frusta"]
    # Without those that end at once, which the machine is not given.
    assert 0.95 * shadow < machine["rays"] <= shadow
    assert sum(one["tests"] for one in stats["machine"]["kinds"].values()) == stats["machine"]["tested"]
    assert shadow > 500


@pytest.mark.sim
def test_shadow_rays_of_a_cast_are_goldens(folder):
    words = ("cast", "cornell", "--kind", "shadow", "--patch", "0", "-o")
    result = run(radiosity.cli.main.main, *words, "machine.npz", *SHADOW_MACHINE)
    assert result.exit_code == 0, result.output
    run(radiosity.cli.main.main, *words, "golden.npz")
    assert (folder / "machine.npz").read_bytes() == (folder / "golden.npz").read_bytes()


@TWO_CLUSTERS
def test_a_cast_in_python_is_that_of_the_command(folder):
    """With the counters that --csv writes, as arrays of casts and clusters."""
    result = run(radiosity.cli.main.main, *CAST, "--casts", "2", "-o", "hits.npz", "--csv", "counters.csv")
    assert result.exit_code == 0, result.output
    parameters = {name: value for name, value in SMALL.items() if name != "noc.rows"} | {"ctu.run_ahead": 2}
    cast = radiosity.machine(radiosity.load("cornell"), patch=4, rays=(32, 8), preset="tiny", clusters=2, cell=0.5,
                             casts=2, parameters=parameters)
    assert cast.agrees
    assert repr(cast).startswith("<MachineCastResult: 32 x 8 rays, 2 clusters, ")
    with np.load("hits.npz") as stored:
        np.testing.assert_array_equal(cast.patch.ravel(), stored["patch"])
    with open("counters.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert set(rows[0]) == {"cast", "cluster", "cast_cycles", *cast.counters}
    for name in "intersection_patches", "intersection_visited":
        assert [[int(row[name]) for row in rows if row["cast"] == str(number)] for number in range(2)] == \
            cast.counters[name].tolist()

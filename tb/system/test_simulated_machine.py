"""A machine with its host: what is loaded again, what is counted, which results are whose."""

import functools
from contextlib import nullcontext
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import Kind, load_descriptor
from golden.engine.jobs.job import HeldTables, plan_job
from golden.engine.jobs.load_regions import region_bits
from golden.engine.jobs.phase_request import phase_request
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.scene.open import open_scene
from hw.cluster import COUNTERS, RECORDED
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from radiosity.flow.host import EngineError
from radiosity.flow.simulator.job_result import (
    KEPT,
    OF_CACHES,
    SHARED_COUNTERS,
    SINCE_RESET,
    JobCycles,
    cluster_counters,
    loads_scene,
)
from radiosity.flow.simulator.simulated_machine import SAMPLE_CYCLES, SimulatedMachine, WaveformWindow
from radiosity.flow.simulator.simulated_port import complete
from radiosity.flow.simulator.simulation_config import SIMULATION_DEFAULTS, simulation_config
from tb.system.checked_machine import use_checked_machines
from tb.system.job_machine import CONFIGS, TWO_CLUSTERS

CONFIG = CONFIGS[2]
RAYS = Hemisphere(32, 8)


@functools.cache
def scene(cell):
    """`cornell`: geometry, cells, points of the ceiling and their normal."""
    opened = open_scene("cornell")
    points, down = ceiling_points(opened)
    geometry = PatchGeometry.of(opened, CONFIG.numbers, [*points, (opened.camera or default_camera(opened)).eye])
    return geometry, Shelling(geometry, CONFIG, cell=cell).table, points, down


def hemispheres(*points, cell=0.5, rays=RAYS, **given):
    geometry, table, ceiling, down = scene(cell)
    given = {"ratio": 16, "weights": rays.polar_weights, "sums": True, "hit_format": HitFormat.FULL} | given
    return phase_request([hemisphere_record(rays, geometry.coordinates, ceiling[point], down) for point in points],
                         geometry, table, CONFIG, **given)


def screen(**given):
    geometry, table, *_ = scene(0.5)
    opened = open_scene("cornell")
    record = screen_record(Screen(camera=opened.camera or default_camera(opened), width=30, height=19),
                           geometry.coordinates)
    return phase_request([record], geometry, table, CONFIG, ratio=16, **given)


def test_a_configuration_for_so_many_clusters():
    config = simulation_config(PRESETS["paper"], clusters=8, topology="torus")
    assert (config.noc.columns, config.noc.rows, config.noc.topology) == (4, 2, "torus")
    assert config.icu.rays == SIMULATION_DEFAULTS["icu.rays"]
    assert simulation_config(PRESETS["paper"], clusters=1, topology="mesh", given=("icu.rays",)).icu.rays == 1 << 18
    with pytest.raises(InputError, match="must be at most 64"):
        simulation_config(PRESETS["paper"], clusters=128, topology="mesh")
    # Patch nodes stay beside them.
    noc = simulation_config(PRESETS["board"], clusters=4, topology=None).noc
    assert (noc.clusters, noc.patch_nodes, noc.nodes) == (4, 1, 5)
    with pytest.raises(InputError, match=r"at most 63 beside 1 patch node \(noc.patch_nodes\), not 64"):
        simulation_config(PRESETS["board"], clusters=64, topology=None)


def test_registers_and_counters_have_names_of_their_own():
    assert not set(SHARED_COUNTERS) & set(COUNTERS)
    assert all(name in COUNTERS for name in (*RECORDED.values(), *SINCE_RESET))


def test_a_field_of_a_record_has_the_name_of_its_counter():
    assert [counter.partition("_")[2] for counter in RECORDED.values()] == [*RECORDED]


def records_of(job, *casts, load=(0, 0)):
    """Completion records: (tag, cluster, begin, cycles, end) of sections, and begin and end of the load."""
    records = np.zeros(1 + len(casts), COMPLETION.dtype)
    records["cluster"][0], records["begin"][0], records["end"][0] = 0xFF, *load
    for record, one in zip(records[1:], casts, strict=True):
        record["tag"], record["cluster"], record["begin"], record["cycles"], record["end"] = one
        record["tested"], record["found"] = 100 * one[0], one[0]
    assert job.descriptors["kind"][0] == Kind.LOAD
    return records


def test_cycles_of_a_job_are_counted_from_its_doorbell():
    """Also when the machine's cycle counter wraps between."""
    job = plan_job([hemispheres(5, 1)], CONFIG)
    for doorbell in 1000, (1 << 32) - 60, (1 << 32) - 700:
        def at(cycle, doorbell=doorbell):
            return (doorbell + cycle) % (1 << 32)
        records = records_of(job, (1, 0, at(300), 200, at(600)), (2, 1, at(350), 400, at(755)), load=(at(50), at(250)))
        assert JobCycles.of(job, records, doorbell) == JobCycles(total=755, load=200, cast=450, results=5)
    # The last result is not that of the last cast.
    records = records_of(job, (1, 0, 300, 200, 900), (2, 1, 350, 400, 800), load=(50, 250))
    assert JobCycles.of(job, records, 0) == JobCycles(total=900, load=200, cast=450, results=150)
    # Nothing is loaded again.
    again = plan_job([hemispheres(5, 1)], CONFIG, held=job.held)
    records = records_of(job, (1, 0, 30, 200, 260))[1:]
    records["tag"] = 0
    assert JobCycles.of(again, records, 10) == JobCycles(total=250, load=0, cast=200, results=30)


def test_counters_are_those_of_the_job():
    """Registers are of the last section of a cluster; those since reset are differences, modulo their range."""
    job = plan_job([hemispheres(5, 1)], CONFIG)
    before = [dict.fromkeys(SINCE_RESET, (1 << 32) - 1)] * 2
    now = [dict.fromkeys(COUNTERS, 7), dict.fromkeys(COUNTERS, 8)]
    each = cluster_counters(job, records_of(job, (1, 0, 0, 50, 60), (2, 1, 0, 70, 90)), now, before)
    assert [tuple(one) for one in each] == [tuple(COUNTERS)] * 2
    for number, one in enumerate(each):
        assert {one[name] for name in SINCE_RESET} == {8 + number}
        assert (one["cycles"], one["intersection_tested"], one["memory_found"]) == (
            (50, 70)[number], 100 * (1 + number), 1 + number)
        assert one["traversal_cells"] == 7 + number
    # One of them casts both, the other none: what it has counted before does not count.
    each = cluster_counters(job, records_of(job, (1, 0, 0, 50, 60), (2, 0, 0, 70, 90)), now, before)
    assert [set(one) for one in each] == [{"cycles", *RECORDED.values(), KEPT, *SINCE_RESET}] * 2
    assert [one[KEPT] for one in each] == [3, 0], "no other source has served the patches found"
    assert [one["intersection_tested"] for one in each] == [300, 0]
    assert [one["cycles"] for one in each] == [120, 0]
    each = cluster_counters(job, records_of(job, (1, 0, 0, 50, 60)), now, before)
    assert each[1] | dict.fromkeys(SINCE_RESET, 0) == dict.fromkeys(COUNTERS, 0)


class KeepingHost:
    """Keeps what jobs load; one of them may end in an error, or halt the queue."""

    def __init__(self, *fails):
        self.loads, self.resumed, self.fails, self.halted, self._job = [], [], fails, 0, None

    async def identify(self):
        pass

    async def begin(self, job, *, policy):
        self._job = job
        self.loads.append([int(one["regions"]) for one in job.descriptors if one["kind"] == Kind.LOAD])

    async def status(self):
        return {"halted": self.halted}

    async def resume(self, image):
        self.resumed.append(image)
        self.halted = 0

    async def run(self, job, *, watch):
        await watch(0)
        if len(self.loads) in self.fails and len(self.loads) % 2:
            self.halted = 1
            raise EngineError(ErrorCode.PATH_TIMEOUT, 0, 0)
        records = np.zeros(len(job.descriptors), COMPLETION.dtype)
        records["tag"] = np.arange(len(records))
        if len(self.loads) in self.fails:
            records["error"][-1] = ErrorCode.OVERFLOW.value
        return records

    async def counters(self, names=COUNTERS):
        return [dict.fromkeys(names, 0)] * CONFIG.noc.nodes

    async def read(self, name):
        return 10 * len(self.loads)


@pytest.fixture(autouse=True)
def checked(monkeypatch):
    """Machines check the rules of their components."""
    use_checked_machines(monkeypatch)


@pytest.fixture
def machine_at(monkeypatch):
    """A machine whose host is given; its main memory is 0."""
    def machine(host):
        class Memory(SimpleNamespace):
            async def read_memory(self, _, size):
                return bytes(size)

            def resize(self, size):
                self.size = size

        monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.SimulatedPort", lambda *_,
                            **__: Memory(cycles=0, size=0))
        monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.Host", lambda *_: host)
        return SimulatedMachine(CONFIG)
    return machine


def bits(*requests, held=None):
    """What a job of these loads."""
    job = plan_job(requests, CONFIG, held=held or HeldTables())
    return [int(one["regions"]) for one in job.descriptors if one["kind"] == Kind.LOAD]


def test_only_what_differs_is_loaded(machine_at):
    """A frustum with fewer shells needs no other grid rays; one with more, or with other rays, does."""
    shells = {point: plan_job([hemispheres(point, cell=0.2)], CONFIG).phases[0].image.last_shell for point in range(10)}
    least, most = (choose(shells, key=shells.get) for choose in (min, max))
    assert shells[least] < shells[most]
    few, many = hemispheres(least, cell=0.2), hemispheres(most, cell=0.2)
    host, wider = KeepingHost(), hemispheres(most, cell=0.2, rays=Hemisphere(64, 8))
    machine = machine_at(host)
    for request in few, many, few, many, wider:
        machine.run([request])
    held = plan_job([few], CONFIG).held
    (everything,) = bits(few)
    assert host.loads[:4] == [[everything], bits(many, held=held), [], []]
    ((grid,),), ((rays,),) = host.loads[1:2], host.loads[4:]
    assert grid not in (0, everything)
    assert rays & everything == rays != everything


@pytest.mark.parametrize("fails", [2, 3])
def test_after_an_error_everything_is_loaded_again(machine_at, fails):
    """After one that ends in a reset, of the image with which the queue is resumed."""
    host, request = KeepingHost(fails), hemispheres(5, 1)
    machine = machine_at(host)
    (everything,) = bits(request)
    for number in range(1, 6):
        if number == fails:
            with pytest.raises(EngineError, match=(
                    r"^frustum \d, .*: OVERFLOW" if fails == 2 else r"^PATH_TIMEOUT")):
                machine.run([request])
        else:
            machine.run([request])
    expected = [[everything], [], [], [], []]
    expected[fails] = [everything]
    assert host.loads == expected
    assert len(host.resumed) == (fails == 3)


def test_caches_are_counted_since_the_scene_was_loaded(machine_at):
    """A load of cells empties them."""
    machine, request = machine_at(KeepingHost()), hemispheres(5)
    first, second = machine.run([request]).shared, machine.run([request]).shared
    assert {first[name] for name in OF_CACHES} == {10}
    assert {first[name] for name in set(SHARED_COUNTERS) - set(OF_CACHES)} == {0}
    assert set(second.values()) == {0}


@pytest.mark.parametrize(("regions", "empties"), [(("patches",), False), (("rows", "columns"), False),
                                                  (("cells", "patches"), True)])
def test_a_load_of_cells_empties_the_caches(regions, empties):
    loads = np.array([load_descriptor(0, region_bits(*regions), tag=0, copies=False)])
    assert loads_scene(SimpleNamespace(descriptors=loads)) == empties


@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize(("begin", "cycles"), [(30, 7), (0, SAMPLE_CYCLES), (3 * SAMPLE_CYCLES + 1, 2000)])
def test_waveforms_are_of_their_window_and_a_timeline_goes_on_in_them(machine_at, tmp_path, monkeypatch, begin, cycles,
                                                                      sampled):
    machine, done, samples = machine_at(KeepingHost()), [], [] if sampled else None
    monkeypatch.setattr("radiosity.flow.simulator.simulated_machine.write_wave_view", lambda *paths: done.append(paths))
    monkeypatch.setattr(SimulatedMachine, "_end_timeline", lambda *_: None)

    async def wait(cycles):
        machine.port.cycles += cycles

    def trace(path):
        done.append((machine.port.cycles, path is not None))
        if path:
            path.write_text("waves")

    machine.port.wait, machine.port.trace = wait, trace
    path = tmp_path / "job.vcd"
    machine.run([hemispheres(5)], waves=WaveformWindow(path=path, begin=begin, cycles=cycles), timeline=samples)
    assert done == [(begin, True), (begin + cycles, False), (path, tmp_path / "job.gtkw")]
    assert path.read_text() == "waves"
    if sampled:
        at = [0, *(cycle for cycle, _ in samples), begin + cycles]
        assert samples[0][0] == 0
        assert max(np.diff(at)) < 2 * SAMPLE_CYCLES
    machine.run([hemispheres(5)])
    assert len(done) == 3


def check(request, frusta):
    """Hits and sums are those of brute force."""
    naive = NaiveFixed(request.geometry, CONFIG.replace({"icu.rays": 1 << 12}))
    for record, one in zip(request.records, frusta, strict=True):
        expected = naive.cast(record)
        if request.hit_format == HitFormat.IDS:
            assert one.hits.tolist() == expected.patch.tolist()
        else:
            assert not len(one.hits.differences(expected))
        assert (one.sums is not None) == request.sums
        if request.sums:
            met = np.flatnonzero(expected.patch >= 0)
            sums = np.bincount(expected.patch[met], request.weights[met // record.columns], len(request.geometry))
            assert one.sums.tolist() == sums.astype(np.int64).tolist()


@TWO_CLUSTERS
def test_results_are_the_frustas_and_what_is_the_same_is_not_loaded_again():
    hemis, one, view = hemispheres(5, 1, 6, 2, 9), hemispheres(3), screen(hit_format=HitFormat.IDS)
    other = hemispheres(5, cell=0.25, hit_format=HitFormat.COMPACT)
    with SimulatedMachine(CONFIG, latency=5) as machine:
        def run(*requests, **options):
            done = machine.run(requests, **options)
            for request, frusta in zip(requests, done.frusta, strict=True):
                check(request, frusta)
            assert machine.port.outside == 0
            return done

        looks, complete = [], []
        first = run(hemis, progress=complete.append)
        again = run(hemis, timeline=looks)
        assert again.cycles.load == 0 < first.cycles.load
        assert again.cycles.total < first.cycles.total - first.cycles.load / 2
        assert complete == sorted(complete)
        assert all(before < after for (before, _), (after, _) in pairwise(looks))
        assert len(looks) > 3
        assert all(after - before >= SAMPLE_CYCLES for (before, _), (after, _) in pairwise(looks[:-1]))
        assert looks[-1] == (again.cycles.total, again.counters)
        # Five frusta on two clusters: whole ones. A single one is cut, and so is a screen.
        assert [len(one.records) for one in first.frusta[0]] == [1] * 5
        mixed = run(one, view)
        assert [len(phase[0].records) for phase in mixed.frusta] == [4, 4]
        assert mixed.records["error"].tolist() == [0] * len(mixed.records)
        assert 0 < mixed.cycles.load < first.cycles.load
        assert mixed.total("memory_found") == sum(phase[0].total("found") for phase in mixed.frusta) > 0
        # Frusta of more rays than the ray memory has.
        wide = run(hemispheres(5, rays=Hemisphere(64, 64), hit_format=HitFormat.COMPACT))
        assert len(wide.frusta[0][0].records) == 4
        # Another scene, of which more has to be loaded; and one whose vertices alone are others.
        assert run(other).cycles.load > first.cycles.load
        run(hemis)
        moved = hemis.geometry.vertices.copy()
        moved[:, 0] ^= 1 << 20
        changed = replace(hemis, geometry=replace(hemis.geometry, vertices=moved))
        different = machine.run([changed]).frusta[0][0].hits.differences(first.frusta[0][0].hits)
        assert len(different) > 20
        run(hemis)


@TWO_CLUSTERS
def test_a_machine_goes_on_after_errors():
    """After one of a frustum, and after one that ends in a reset."""
    request = hemispheres(5, 1, 6)
    heavy = replace(request, weights=np.full(RAYS.polars, (1 << 42) - 1))
    with SimulatedMachine(CONFIG, latency=5) as machine:
        check(request, machine.run([request]).frusta[0])
        with pytest.raises(EngineError, match=r"^frustum \d, columns \d+ to \d+, rows 0 to 7: OVERFLOW: the sum"):
            machine.run([heavy])
        check(request, machine.run([request]).frusta[0])
        late = pytest.raises(EngineError, match=r"^frustum \d, .*: WATCHDOG: .* a reset \(")
        for limit, raises in (100, late), (0, nullcontext()):
            complete(machine.port.write(addresses(ENGINE_REGISTERS)["watchdog"], limit))
            with raises:
                check(request, machine.run([request]).frusta[0])
        assert machine.port.outside == 0

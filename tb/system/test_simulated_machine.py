"""A machine with its host: what is loaded again, what is counted."""

from types import SimpleNamespace

import pytest
from hw.simulator.cast_result import SHARED_COUNTERS, SINCE_RESET

from golden.config import PRESETS
from golden.errors import InputError
from golden.memory_map import MemoryImage
from hw.cluster import COUNTERS
from hw.host import LIVES, EngineError
from hw.registers.error_code import ErrorCode
from hw.simulator.simulated_machine import SimulatedMachine
from hw.simulator.simulation_config import SIMULATION_DEFAULTS, simulation_config
from tb.lib.configurations import config_of
from tb.system.job_machine import LISTS, ONE_CLUSTER, SMALL
from tb.system.scenes import frusta

CONFIG = config_of(SMALL | {"noc.columns": 1})


def test_a_configuration_for_so_many_clusters():
    config = simulation_config(PRESETS["paper"], clusters=8, topology="torus")
    assert (config.noc.columns, config.noc.rows, config.noc.topology) == (4, 2, "torus")
    assert config.icu.rays == SIMULATION_DEFAULTS["icu.rays"]
    assert simulation_config(PRESETS["paper"], clusters=1, topology="mesh", given=("icu.rays",)).icu.rays == 1 << 18
    with pytest.raises(InputError, match="must be at most 64"):
        simulation_config(PRESETS["paper"], clusters=128, topology="mesh")


def test_registers_and_counters_have_names_of_their_own():
    assert not set(SHARED_COUNTERS) & set(COUNTERS)


class CountingHost:
    """A host whose machine adds the same to `SINCE_RESET` with each cast, modulo a register's range."""

    value = 0

    async def start(self):
        self.value = (self.value + (1 << 31) + 1) % (1 << 32)

    async def finish(self, *_, **__):
        pass

    async def counters(self, names=COUNTERS):
        return [{name: self.value if name in SINCE_RESET else 7 for name in names}] * CONFIG.noc.nodes

    async def read(self, name):
        return 0

    async def identify(self):
        pass

    async def results(self, **_):
        return None


def test_all_counters_are_those_of_the_cast(monkeypatch):
    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedPort", lambda *_, **__: SimpleNamespace(cycles=0))
    monkeypatch.setattr("hw.simulator.simulated_machine.Host", lambda *_: CountingHost())
    machine = SimulatedMachine(CONFIG)
    for _ in range(3):
        (counters,) = machine.cast(None, again=True).counters
        assert tuple(counters) == tuple(COUNTERS)
        assert {counters[name] for name in SINCE_RESET} == {(1 << 31) + 1}
        assert counters["cycles"] == 7


def test_after_a_load_that_fails_everything_is_loaded_again(monkeypatch):
    loads = []

    class FailingHost(CountingHost):
        async def load(self, image, *, lives, policy):
            loads.append(lives)
            if len(loads) == 2:
                raise EngineError(ErrorCode.READ_REPLY, 0, 0)

    port = SimpleNamespace(cycles=0, size=1 << 40)
    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedPort", lambda *_, **__: port)
    monkeypatch.setattr("hw.simulator.simulated_machine.Host", lambda *_: FailingHost())
    machine, image = SimulatedMachine(CONFIG), frusta("cornell", CONFIG, cell=0.5, points=(5,))[0].image
    machine.cast(image)
    with pytest.raises(EngineError, match="READ_REPLY"):
        machine.cast(image)
    machine.cast(image)
    assert loads == [tuple(LIVES), ("frustum",), tuple(LIVES)]


class KeepingHost(CountingHost):
    """Keeps which tables are loaded."""

    def __init__(self):
        super().__init__()
        self.loads = []

    async def load(self, image, *, lives, policy):
        self.loads.append(lives)


def test_only_what_differs_is_loaded(monkeypatch):
    """A frustum with fewer shells needs no other grid rays; one with more, or with other rays, does."""
    host, port = KeepingHost(), SimpleNamespace(cycles=0, size=1 << 40)
    monkeypatch.setattr("hw.simulator.simulated_machine.SimulatedPort", lambda *_, **__: port)
    monkeypatch.setattr("hw.simulator.simulated_machine.Host", lambda *_: host)
    given = frusta("cornell", CONFIG, cell=0.2, points=(0, 5, 1, 2, 3, 4, 6, 7, 8, 9))
    least, *_, most = sorted((one.image for one in given), key=lambda image: len(image["shells"]))
    assert len(least["grid_rows"]) < len(most["grid_rows"])
    assert (least["grid_rows"] == most["grid_rows"][:len(least["grid_rows"])]).all()
    wider = frusta("cornell", CONFIG, cell=0.2, points=(5,), rays=(64, 8))[0].image
    machine = SimulatedMachine(CONFIG)
    for image in (least, most, least, most, wider):
        machine.cast(image)
    assert host.loads == [tuple(LIVES), ("rays", "frustum"), ("frustum",), ("frustum",),
                          ("phase", "rays", "frustum")]


@ONE_CLUSTER
def test_what_is_the_same_is_not_loaded_again():
    given = frusta("cornell", CONFIG, cell=0.5, points=(5, 1))
    other = frusta("cornell", CONFIG, cell=0.25, points=(5,))[0]
    with SimulatedMachine(CONFIG, latency=5) as machine:
        def cast(frustum, **options):
            done = machine.cast(frustum.image, total=frustum.total, sums=True, **options)
            for name in "hits", "sums":
                assert done.image[name].tobytes() == frustum.written[name].tobytes(), name
            return done

        looks = []
        first, second = cast(given[0]), cast(given[1], timeline=looks)
        assert second.load_cycles < first.load_cycles
        assert cast(given[1], again=True).load_cycles < second.load_cycles
        assert [cycle for cycle, _ in looks] == sorted(cycle for cycle, _ in looks)
        assert len(looks) > 3
        assert cast(given[0]).load_cycles < first.load_cycles / 2
        # Another scene, of which more has to be loaded; and one whose vertices alone are others.
        assert cast(other).load_cycles > second.load_cycles
        cast(given[0])
        moved = MemoryImage({**given[0].image.regions, "patches": given[0].image["patches"].copy()})
        moved["patches"]["vertex"][:, 0] ^= 1 << 20
        changed = machine.cast(moved, total=given[0].total, sums=True).image.hits()
        assert len(changed.differences(given[0].hits)) > 20
        assert second.total("memory_found") == second.counters[0]["memory_found"] > 0
        assert set(second.shared) == set(SHARED_COUNTERS)


@ONE_CLUSTER
def test_a_machine_without_lists():
    bare = config_of(SMALL | {"noc.columns": 1})
    given = frusta("cornell", bare, cell=0.5, points=(5,))[0]
    with SimulatedMachine(bare, latency=5) as machine:
        done = machine.cast(given.image, total=given.total, sums=True)
        for name in "hits", "sums":
            assert done.image[name].tobytes() == given.written[name].tobytes(), name
        with pytest.raises(InputError, match=r"Subshells of a cluster must be at most 0 \(ctu.subshell_bits\), not"):
            machine.cast(frusta("cornell", bare.replace(LISTS), cell=0.5, points=(5,))[0].image)

"""Faults of images, commands and memory on small machines; after each the next frustum is right."""

import random

import numpy as np
import pytest

from golden.memory_map import MemoryImage
from hw.host import EngineError
from hw.registers.error_code import ErrorCode
from tb.system.scenes import frusta
from tb.system.small_machine import BASE, CLUSTERS, CONFIGS, SMALL, Driven, cut, resident

BUS = ErrorCode.READ_REPLY, ErrorCode.PATH_BUS
SILENT = ErrorCode.READ_TIMEOUT, ErrorCode.PATH_BUS
# Rays of a tile, and the tiles of a ray memory.
TILE = 16
TILES = SMALL["icu.rays"] // TILE


@pytest.fixture
def given(clusters):
    return frusta("cornell", CONFIGS[clusters], cell=0.5, points=(5,))[0]


@pytest.fixture
def machine(given):
    with Driven([given], latency=10) as machine:
        yield machine


def right(machine, given):
    """With a sound, idle memory and a long watchdog a whole frustum is right."""
    machine.port.fault()
    machine(machine.port.wait(200))
    machine(machine.host.write("watchdog", 1 << 20))
    machine.check(given)


def loading(machine, given):
    return machine.host.load(given.image, base=BASE)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_commands_that_are_refused(machine, given):
    machine.fails(ErrorCode.NOT_LOADED, machine.host.cast())
    machine(machine.host.command("write"))
    machine.fails(ErrorCode.COMMAND, machine.host.finish("writes", timeout=1000))
    right(machine, given)
    for name in ("load", "cast", "write"):
        machine.load(given)
        machine(machine.host.start())
        machine(machine.host.command(name))
        machine.fails(ErrorCode.COMMAND, machine.host.finish("casts", timeout=100_000))
        machine.results(given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_images_that_are_wrong(machine, given):
    offsets, data = given.image.offsets, given.image.to_bytes()
    for at, code in ((0, ErrorCode.IMAGE), (4, ErrorCode.IMAGE), (16, ErrorCode.REGION),
                     (offsets["near_cells"] + 3, ErrorCode.POINTER)):
        broken = bytearray(data)
        broken[at] ^= 0x7F
        machine.load(given)
        machine.put(bytes(broken))
        machine(machine.host.command("load"))
        machine.fails(code, machine.host.finish("loads", timeout=100_000))
        machine.fails(ErrorCode.NOT_LOADED, machine.host.cast())
        machine.is_as_expected()
        right(machine, given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_errors_of_memory(machine, given):
    offsets = given.image.offsets
    for region in ("cells", "patch_lists", "clusters", "residents", "columns", "grid_columns"):
        machine.port.fault(first=BASE + offsets[region], size=1)
        error = machine.fails(ErrorCode.READ_REPLY, loading(machine, given))
        assert error.address == BASE + offsets[region], region
        right(machine, given)
    # Patches that are read during a cast.
    bus = resident(given, None)
    machine.load(bus)
    machine.port.fault(first=BASE + bus.image.offsets["patches"], size=bus.image["patches"].nbytes)
    machine.fails(BUS, machine.host.cast())
    right(machine, given)
    for region in "hits", "sums":
        machine.port.fault(first=BASE + offsets[region], size=1)
        machine.fails(ErrorCode.WRITE_REPLY, machine.host.results(total=given.total))
        right(machine, given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_memory_that_does_not_answer(machine, given):
    machine.port.fault(mute_reads=True)
    machine.fails(ErrorCode.READ_TIMEOUT, loading(machine, given))
    right(machine, given)
    machine.load(resident(given, None))
    machine.port.fault(mute_reads=True)
    machine.fails(SILENT, machine.host.cast())
    right(machine, given)
    machine.port.fault(mute_writes=True)
    machine.fails(ErrorCode.WRITE_TIMEOUT, machine.host.results(total=given.total))
    right(machine, given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_accesses_outside_the_windows(machine, given):
    right(machine, given)
    size = len(given.image.to_bytes())
    for base, limit in ((BASE, BASE + 4096), (BASE + 8, BASE + size), (BASE + (1 << 20), BASE + size)):
        machine.load(given)
        machine(machine.host.write("read_base", base))
        machine(machine.host.write("read_limit", limit))
        machine(machine.host.command("load"))
        machine.fails(ErrorCode.READ_OUTSIDE, machine.host.finish("loads", timeout=100_000))
        machine.fails(ErrorCode.NOT_LOADED, machine.host.cast())
    right(machine, given)
    offsets = given.image.offsets
    for base, limit in ((offsets["hits"] + 8, size), (offsets["hits"], offsets["sums"] + 8)):
        machine.load(given)
        machine.cast()
        machine(machine.host.write("write_base", BASE + base))
        machine(machine.host.write("write_limit", BASE + limit))
        machine(machine.host.write("total", given.total))
        machine(machine.host.write("results", 3))
        machine(machine.host.command("write"))
        machine.fails(ErrorCode.WRITE_OUTSIDE, machine.host.finish("writes", timeout=100_000))
        right(machine, given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_windows_rewritten_while_they_are_used(machine, given):
    """The host rewrites them word by word, to any value; a command keeps the windows with which it began."""
    host, data, draw = machine.host, given.image.to_bytes(), random.Random(1)
    windows = {"read_base": BASE, "read_limit": BASE + len(data), "write_base": BASE + given.image.offsets["hits"],
               "write_limit": BASE + len(data)}
    machine.load(given)
    for name, value in (("total", given.total), ("results", 3)):
        machine(host.write(name, value))
    for command, busy in (("load", "loads"), ("cast", "casts"), ("write", "writes")):
        for name, value in windows.items():
            machine(host.write(name, value))
        machine(host.command(command))
        while machine(host.status())[busy]:
            machine(host.write(draw.choice([*windows]), draw.getrandbits(64)))
        machine(host.finish(busy, timeout=100_000))
    assert machine(machine.port.read_memory(BASE, len(data))) == given.written.to_bytes()
    machine.put(data)
    right(machine, given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_the_watchdog_ends_what_takes_too_long_and_nothing_else(machine, given):
    machine.load(given)
    cycles = machine.cast()
    machine.results(given)
    # Longer than each command, shorter than two of them.
    machine(machine.host.write("watchdog", 1 << 12))
    for _ in range(2):
        machine.load(given, "rays", "frustum")
        machine(machine.port.wait(1 << 13))
        assert machine.cast() < 1 << 12
        machine.results(given)
        machine(machine.port.wait(1 << 13))
    assert not machine(machine.host.status())["failed"]
    machine(machine.host.write("watchdog", cycles // 2))
    machine.fails(ErrorCode.WATCHDOG, machine.host.cast())
    assert not machine(machine.host.status())["loaded"]
    right(machine, given)
    machine(machine.host.write("watchdog", 100))
    machine.fails(ErrorCode.WATCHDOG, loading(machine, given))
    right(machine, given)
    machine(machine.host.write("watchdog", 100))
    machine.fails(ErrorCode.WATCHDOG, machine.host.results(total=given.total))
    machine.stops_with_results_of(given)
    right(machine, given)


def too_large(given, cluster):
    """A cluster's section has one tile more than its ray memory."""
    side, columns, rows = 64, 20, 52
    sizes = {"columns": side, "rows": side, "hits": side**2}
    image = MemoryImage({**given.image.regions, "clusters": given.image["clusters"].copy(),
                         "frustum": given.image["frustum"].copy(),
                         **{name: np.zeros(size, given.image[name].dtype) for name, size in sizes.items()}})
    image["frustum"]["columns"] = image["frustum"]["rows"] = side
    section = image["clusters"][cluster]
    section["first_column"], section["first_row"], section["end_column"], section["end_row"] = 0, 0, columns, rows
    assert columns * rows == TILE * (TILES + 1)
    return image


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_fault_of_one_cluster_names_it(given, clusters):
    """Each cluster has a fault, alone: its section is too large, or it does not hold the patch that it should."""
    with Driven([given], images=8, latency=10) as machine:
        for cluster in range(clusters):
            image = too_large(given, cluster)
            machine(machine.host.load(image, check=False, base=BASE))
            assert machine.fails(ErrorCode.SECTION, machine.host.cast()).cluster == cluster
            # Memory has been written by the host only.
            machine.put(image.to_bytes())
            machine.check(given)
            for patch in 3, len(given.image["patches"]) - 1:
                broken = resident(given, None)
                broken.image["residence"]["cluster"][patch], broken.image["residence"]["address"][patch] = cluster, 9
                machine.load(broken)
                error = machine.fails(ErrorCode.PATH_RESIDENCE, machine.host.cast())
                assert (error.cluster, error.address) == (cluster, patch)
                machine.check(given)


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("latency", [3, 40])
def test_stops_at_any_time(given, clusters, latency):
    """Of a load, a cast, and the writing of results: what has been written is golden's, and the next frustum is right,
    although its sections are others.
    """
    other = cut(given, *((0, 20) if clusters > 1 else (0,)))
    with Driven([given], latency=latency, spread=8, shuffles=True) as machine:
        machine.load(given)
        for cycles in (1, 5, 60, 131, 302, 555, 900):
            machine(machine.host.command("load"))
            machine(machine.port.wait(cycles))
            machine(machine.host.stop())
            machine.fails(ErrorCode.NOT_LOADED, machine.host.cast())
            machine.check(other)
            machine(machine.host.start())
            machine(machine.port.wait(cycles))
            machine(machine.host.stop())
            status = machine(machine.host.status())
            assert not any(status[name] for name in ("present", "earlier", "loaded", "casts"))
            machine.check(given)
            machine.load(given)
            machine.cast()
            machine(machine.host.write("results", 3))
            machine(machine.host.command("write"))
            machine(machine.port.wait(cycles // 2))
            machine(machine.host.stop())
            machine.stops_with_results_of(given)
            machine.is_as_expected()
            machine.check(given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_resets_at_any_time(given, clusters):
    """Of machine and memory together."""
    with Driven([given], latency=8) as machine:
        for cycles in (1, 77, 300, 900, 1500):
            machine.load(given)
            machine(machine.host.start())
            machine(machine.port.wait(cycles))
            machine.port.reset()
            with pytest.raises(EngineError):
                machine.cast()
            machine.check(given)

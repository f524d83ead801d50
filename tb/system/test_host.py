"""The host's driver at a machine that only has registers."""

import asyncio

import numpy as np
import pytest

from golden.config import PRESETS
from golden.errors import InputError
from golden.memory_map import MemoryImage
from hw.host import LIVES, POLL, EngineError, EngineTimeoutError, Host, Port, check_image
from hw.registers.engine_registers import ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from tb.system.scenes import frusta

CONFIG = PRESETS["tiny"].replace({"noc.columns": 2, "noc.rows": 1})
ADDRESSES = addresses(ENGINE_REGISTERS)


class Registers(Port):
    """Registers without a machine; busy for some reads of ``status``."""

    def __init__(self):
        self.values, self.memory, self.commands = {}, {}, []
        self.set("magic", MAGIC)
        self.set("version", VERSION)
        self.set("clusters", 2)
        self.looks, self.busy, self.waited = 0, 0, 0
        # Commands that the machine refuses, with the error.
        self.refuses = {}

    def set(self, name, value):
        """What a register holds."""
        for word in range(register(name).words):
            self.values[ADDRESSES[name] + 4 * word] = value >> 32 * word & 0xFFFFFFFF

    async def read(self, address):
        if address == ADDRESSES["status"] and self.busy:
            self.busy -= 1
            return register("status").pack(loads=1, casts=1, writes=1)
        return self.values.get(address, 0)

    async def write(self, address, value):
        if address == ADDRESSES["command"]:
            self.commands.append(command := register("command").unpack(value))
            self.busy = self.looks
            refused = next((self.refuses[name] for name, bit in command.items() if bit and name in self.refuses), None)
            if refused is not None:
                self.busy = 0
                self.set("error", refused.value)
            if refused is not None or command["clear"]:
                self.set("status", register("status").pack(failed=int(not command["clear"])))
        else:
            self.values[address] = value

    async def read_memory(self, address, size):
        return self.memory[address][:size]

    async def write_memory(self, address, data):
        self.memory[address] = data

    async def wait(self, cycles):
        self.waited += cycles


@pytest.fixture(scope="module")
def frustum():
    return frusta("cornell", CONFIG, cell=0.5)[0]


@pytest.fixture
def port():
    return Registers()


def test_a_load_says_where_everything_is(port, frustum):
    host, base = Host(port, CONFIG, base=0x12_0000_0040), 0x12_0000_0040
    port.looks = 3
    asyncio.run(host.identify())
    asyncio.run(host.load(frustum.image))
    data = frustum.image.to_bytes()
    assert port.memory == {base: data}
    assert [asyncio.run(host.read(name)) for name in ("image", "read_base", "read_limit")] == [
        base, base, base + len(data)]
    assert asyncio.run(host.read("regions")).bit_count() == sum(map(len, LIVES.values()))
    assert [command["load"] for command in port.commands] == [1]
    assert port.waited > 0
    # A frustum from another address: the scene is still read from the first one.
    asyncio.run(host.load(frustum.image, lives=("rays", "frustum"), base=base + (1 << 20)))
    assert asyncio.run(host.read("read_base")) == base
    assert asyncio.run(host.read("read_limit")) == base + (1 << 20) + len(data)


@pytest.mark.parametrize(("name", "message"), [("magic", "magic must be"), ("version", "version must be"),
                                               ("clusters", "clusters must be 2, not 7")])
def test_another_machine_is_refused(port, name, message):
    port.set(name, 7)
    with pytest.raises(InputError, match=message):
        asyncio.run(Host(port, CONFIG).identify())


def test_errors_are_reported_and_cleared(port, frustum):
    host = Host(port, CONFIG)
    for name, value in ("error", ErrorCode.PATH_BUS.value), ("error_cluster", 1), ("error_address", 99):
        port.set(name, value)
    port.set("status", register("status").pack(failed=1))
    with pytest.raises(EngineError, match=r"PATH_BUS: a cell or a patch .* \(cluster 1, at 0x63\)") as raised:
        asyncio.run(host.load(frustum.image))
    assert (raised.value.code, raised.value.cluster, raised.value.address) == (ErrorCode.PATH_BUS, 1, 99)
    assert port.commands[-1]["clear"]


class Resets(Registers):
    """After a command units are in reset for some reads of ``status``."""

    async def read(self, address):
        if address == ADDRESSES["status"] and self.busy:
            self.busy -= 1
            return register("status").pack(stops=1, failed=1)
        return await super().read(address)


def test_an_error_that_ends_in_a_reset_is_reported_after_it(frustum):
    port = Resets()
    port.looks = 3
    port.set("error", ErrorCode.READ_TIMEOUT.value)
    port.set("status", register("status").pack(failed=1))
    with pytest.raises(EngineError, match="READ_TIMEOUT"):
        asyncio.run(Host(port, CONFIG).load(frustum.image))
    assert port.waited == 3 * POLL
    assert port.commands[-1]["clear"]


def test_an_endless_command_times_out(port, frustum):
    host = Host(port, CONFIG)
    port.looks = 1000
    with pytest.raises(EngineTimeoutError, match="loads after 5000 cycles still"):
        asyncio.run(host.load(frustum.image, timeout=5000))


@pytest.mark.parametrize(("changes", "message"), [
    ({"noc.columns": 4}, "must be for 4 clusters, not 2"),
    ({"icu.rays": 64}, r"Tiles of a section must be at most 4 \(icu.rays\), not"),
    ({"ctu.shell_bits": 3, "ctu.grid_row_bits": 6, "ctu.grid_column_bits": 6},
     r"Columns of grid rays must be at most 64 \(ctu.grid_column_bits\), not")])
def test_images_beyond_the_capacity_are_refused(frustum, changes, message):
    check_image(frustum.image, CONFIG)
    with pytest.raises(InputError, match=message):
        check_image(frustum.image, CONFIG.replace(changes))


# By region: its capacity, and the records that it can hold besides.
CAPACITIES = {
    "columns": ("Columns", 1 << CONFIG.icu.side_bits, 0), "rows": ("Rows", 1 << CONFIG.icu.side_bits, 0),
    "patches": ("Patches", 1 << CONFIG.icu.patch_bits, 0), "cells": ("Cells", CONFIG.memsys.scene_cells, 0),
    "near_cells": ("Cells of shell 1", 1 << CONFIG.ctu.near_cell_bits, 0),
    "shells": ("Shells", 1 << CONFIG.ctu.shell_bits, 2),
    "grid_rows": ("Rows of grid rays", 1 << CONFIG.ctu.grid_row_bits, 0),
    "grid_columns": ("Columns of grid rays", 1 << CONFIG.ctu.grid_column_bits, 0)}


@pytest.mark.parametrize("region", CAPACITIES)
def test_capacities(frustum, region):
    what, most, besides = CAPACITIES[region]
    for count in most - 1, most, most + 1:
        records = np.zeros(count - besides, dtype=frustum.image[region].dtype)
        image = MemoryImage({**frustum.image.regions, region: records})
        if count <= most:
            check_image(image, CONFIG)
        else:
            with pytest.raises(InputError, match=rf"{what} must be at most {most} \(.*\), not {count}"):
                check_image(image, CONFIG)


@pytest.mark.parametrize(("field", "most", "message"), [
    ("residents", CONFIG.memsys.own_patches, "Patches of a resident set"),
    ("subshells", CONFIG.ctu.subshells, "Subshells of a cluster"), ("end_column", 256, "Tiles of a section")])
def test_capacities_of_a_cluster(frustum, field, most, message):
    clusters = frustum.image["clusters"].copy()
    # Of 4 x 4 rays each.
    clusters["first_column"], clusters["first_row"], clusters["end_row"] = 0, 0, 16
    clusters["end_column"], clusters["subshells"], clusters["residents"] = 64, 0, 0
    image = MemoryImage({**frustum.image.regions, "clusters": clusters})
    for value in range(max(0, most - 1), most + 2):
        clusters[field][1] = value
        if value <= most:
            check_image(image, CONFIG)
        else:
            with pytest.raises(InputError, match=f"{message} must be at most"):
                check_image(image, CONFIG)


@pytest.mark.parametrize(("name", "most"), [("total", (1 << 44) - 1), ("regions", (1 << 17) - 1), ("policy", 3),
                                            ("image", (1 << 64) - 1)])
def test_registers_hold_what_is_written(port, name, most):
    host = Host(port, CONFIG)
    asyncio.run(host.write(name, most))
    assert asyncio.run(host.read(name)) == most
    for value in -1, most + 1:
        with pytest.raises(ValueError, match=f"{name} must be from 0 to {most}, not {value}"):
            asyncio.run(host.write(name, value))


def test_clusters_are_their_nodes(frustum):
    clusters = frustum.image["clusters"].copy()
    clusters["processor"] = np.array([1, 0])
    with pytest.raises(InputError, match="Cluster k must be processor k"):
        check_image(MemoryImage({**frustum.image.regions, "clusters": clusters}), CONFIG)


def test_a_refused_command_changes_nothing(port, frustum):
    host, far = Host(port, CONFIG), 1 << 20
    image = frustum.image
    size = image.offsets["hits"]
    port.memory = {at + image.offsets[name]: image[name].tobytes() for at in (0, far) for name in ("hits", "sums")}

    async def bench():
        await host.load(image)
        await host.cast()
        port.refuses = {"load": ErrorCode.COMMAND}
        with pytest.raises(EngineError, match="COMMAND"):
            await host.load(image, base=far)
        port.refuses = {"cast": ErrorCode.NOT_LOADED}
        with pytest.raises(EngineError, match="NOT_LOADED"):
            await host.start()
        port.refuses = {}
        # The frustum that was cast is the one at 0 still, and there is none before it.
        await host.results()
        assert await host.read("write_base") == size
        with pytest.raises(InputError, match="A frustum must have been cast"):
            await host.results(earlier=True)
        # A load of a frustum reads the scene from 0, where the load was accepted.
        await host.load(image, lives=("rays", "frustum"), base=far)
        assert await host.read("read_base") == 0
        await host.cast()
        await host.results()
        assert await host.read("write_base") == far + size
        await host.results(earlier=True)
        assert await host.read("write_base") == size

    asyncio.run(bench())


def test_nothing_is_left_after_a_stop(port, frustum):
    host = Host(port, CONFIG)

    async def bench():
        await host.load(frustum.image)
        await host.cast()
        await host.stop()
        with pytest.raises(InputError, match="A frustum must have been cast"):
            await host.results()

    asyncio.run(bench())


def test_an_image_ends_within_memory(port, frustum):
    top = 1 << CONFIG.memory.address_bits
    size = len(frustum.image.to_bytes())
    asyncio.run(Host(port, CONFIG, base=top - size).load(frustum.image))
    assert asyncio.run(Host(port, CONFIG).read("read_limit")) == top
    with pytest.raises(InputError, match="must end at 0x"):
        asyncio.run(Host(port, CONFIG, base=top - size + 64).load(frustum.image))

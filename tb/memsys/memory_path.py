"""The path from cells to vertices of several clusters with their bus and its caches; memory and network around it."""

import random
from collections import deque

import cocotb
import numpy as np
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In
from cocotb.triggers import RisingEdge

from golden.engine.config import Config
from golden.engine.memory_map import BEATS, REGIONS, pack_beats
from hw.lib.payload import pack, unpack
from hw.memsys.bus.local_bus import LocalBus
from hw.memsys.bus.system_bus_interface import READERS, SystemBusInterface
from hw.memsys.memory_system import MemorySystem
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["Memory", "MemoryPath", "Mesh", "scene_image"]

DTYPE = {region.name: region.dtype for region in REGIONS}


class MemoryPath(wiring.Component):
    """Clusters' memory systems on a bus. Each port of a memory system is an array; ``o_read`` and ``i_read`` are those
    of main memory.
    """

    OUTSIDE = ("o_bus", "i_bus", "scene", "cluster")

    def __init__(self, *, config: Config, clusters: int):
        self.systems = [MemorySystem(config=config) for _ in range(clusters)]
        self.bus = LocalBus(config=config, clusters=clusters)
        self.interface = SystemBusInterface(config=config)
        members = {name: member.array(clusters) for name, member in self.systems[0].signature.members.items()
                   if name not in self.OUTSIDE}
        shared = self.interface.signature.members
        super().__init__({**members, "scene": In(PathFormats(config).scene),
            "i_invalidate": shared["i_invalidate"], "o_read": shared["o_request"], "i_read": shared["i_reply"],
            "bases": shared["bases"]})

    def elaborate(self, platform):
        """Memory systems, bus and interface."""
        m = Module()
        m.submodules.bus, m.submodules.interface = bus, interface = self.bus, self.interface
        wiring.connect(m, bus.o_request, interface.i_request)
        for kind in range(2):
            wiring.connect(m, interface.o_reply[kind], bus.i_reply[kind])
        wiring.connect(m, wiring.flipped(self.i_invalidate), interface.i_invalidate)
        wiring.connect(m, wiring.flipped(self.i_read), interface.i_reply)
        wiring.connect(m, interface.o_request, wiring.flipped(self.o_read))
        m.d.comb += [interface.scene.eq(self.scene), interface.bases.eq(self.bases)]
        for number, system in enumerate(self.systems):
            m.submodules[f"system_{number}"] = system
            wiring.connect(m, system.o_bus, bus.i_request[number])
            wiring.connect(m, bus.o_reply[number], system.i_bus)
            m.d.comb += [system.scene.eq(self.scene), system.cluster.eq(number)]
            for name, member in system.signature.members.items():
                if name in self.OUTSIDE:
                    continue
                outside, inside = getattr(self, name)[number], getattr(system, name)
                if member.is_signature:
                    outside = wiring.flipped(outside)
                    wiring.connect(m, *((outside, inside) if member.flow is In else (inside, outside)))
                elif member.flow is In:
                    m.d.comb += inside.eq(outside)
                else:
                    m.d.comb += outside.eq(inside)
        return m


def scene_image(pointer, count, lists, vertices, surface) -> tuple[bytes, dict[str, int]]:
    """The tables of a scene in memory, and where each begins."""
    low, high = pack_beats(np.asarray(vertices))
    records = {"cells": np.zeros(len(count), DTYPE["cells"]), "lists": np.zeros(len(lists), DTYPE["patch_lists"]),
               "patches": np.zeros(len(low), DTYPE["patches"])}
    records["cells"]["pointer"], records["cells"]["count"] = pointer, count
    records["lists"]["patch"] = lists
    records["patches"]["id"], records["patches"]["surface"] = np.arange(len(low)), surface
    records["patches"]["top"][:, 1:BEATS], records["patches"]["vertex"] = high, low
    image, bases = b"", {}
    for name, array in records.items():
        bases[name] = len(image)
        image += array.tobytes()
        image += bytes(-len(image) % 64)
    return image, bases


class _Wires:
    """A stream of an array of the component."""

    def __init__(self, dut, name, shape):
        self.valid, self.ready, self.payload = (getattr(dut, f"{name}__{part}", None)
                                                for part in ("valid", "ready", "payload"))
        self.shape, self.dut = shape, dut

    def take(self):
        """What is transferred in this cycle, from a component."""
        moves = int(self.valid.value) and int(self.ready.value)
        return unpack(self.shape, int(self.payload.value)) if moves else None

    def offer(self, items):
        """Shows the first of some items."""
        self.valid.value = int(bool(items))
        if items:
            self.payload.value = pack(self.shape, items[0])

    def taken(self):
        """Whether what was shown is taken in this cycle."""
        return int(self.valid.value) and int(self.ready.value)


class Memory:
    """Main memory behind the system bus interface: beats in the order of the requests, late by chance.

    Parameters
    ----------
    data, base
        What it holds, from which address on.
    latency
        Cycles to the first beat at most.
    fails
        Addresses of beats that come with an error.
    """

    def __init__(self, dut, config: Config, data: bytes, *, base: int, latency: int, seed: int = 1, fails=()):
        formats = MemoryFormats(config)
        self._data, self._base, self._bytes, self._fails = data, base, config.memory.beat_bytes, set(fails)
        self._latency, self._random = latency, random.Random(seed)
        self._requested = _Wires(dut, "o_read", formats.request(range(READERS)))
        self._given = _Wires(dut, "i_read", formats.reply(range(READERS)))
        self.reads = []
        self._requested.ready.value = self._given.valid.value = 0
        self._task = cocotb.start_soon(self._run(RisingEdge(dut.clk)))

    async def _run(self, edge):
        beats, now = deque(), 0
        while True:
            self._requested.ready.value = int(self._random.random() < 0.7)
            self._given.offer([beats[0][1]] if beats and beats[0][0] <= now else [])
            await edge
            now += 1
            if self._given.taken():
                beats.popleft()
            request = self._requested.take()
            if request is None:
                continue
            first = request["address"]
            self.reads.append(first)
            due = now + self._random.randint(1, self._latency)
            for k in range(request["length"] + 1):
                at = first - self._base + k * self._bytes
                assert 0 <= at < len(self._data), f"{first:#x} is outside the image"
                word = int.from_bytes(self._data[at:at + self._bytes], "little")
                beats.append((due, {"data": word, "tag": request["tag"], "last": k == request["length"],
                                    "error": first + k * self._bytes in self._fails}))

    def stop(self):
        """Answer nothing more."""
        self._task.cancel()
        self._requested.ready.value = self._given.valid.value = 0


class Mesh:
    """A network that is late by chance, and keeps its order from one cluster to another one only."""

    def __init__(self, dut, config: Config, clusters: int, *, delay: int, seed: int = 1):
        members = MemorySystem(config=config).signature.members
        self._random, self._delay, self._clusters = random.Random(seed), delay, clusters

        def wires(name):
            shape = members[name].signature.members["payload"].shape
            return [_Wires(dut, f"{name}__{k}", shape) for k in range(clusters)]

        self._sides = (("o_request", "i_remote"), ("o_remote", "i_reply"))
        self._wires = {name: wires(name) for side in self._sides for name in side}
        self.request_count = 0
        for _, name in self._sides:
            for one in self._wires[name]:
                one.valid.value = 0
        self._task = cocotb.start_soon(self._run(RisingEdge(dut.clk)))

    async def _run(self, edge):
        # By destination and source, requests and replies; of replies four at a time go on.
        queues = [{(to, source): deque() for to in range(self._clusters) for source in range(self._clusters)}
                for _ in self._sides]
        shown, now = [[[] for _ in range(self._clusters)] for _ in self._sides], 0
        while True:
            for side, (out, given) in enumerate(self._sides):
                for k in range(self._clusters):
                    self._wires[out][k].ready.value = int(self._random.random() < 0.8)
                    if not shown[side][k]:
                        shown[side][k] = self._next(side, k, queues[side], now)
                    self._wires[given][k].offer(shown[side][k])
            await edge
            now += 1
            for side, (out, given) in enumerate(self._sides):
                for k in range(self._clusters):
                    if shown[side][k] and self._wires[given][k].taken():
                        shown[side][k].pop(0)
                    item = self._wires[out][k].take()
                    if item is not None:
                        to = item["node"]
                        self.request_count += side == 0
                        came = {"node": k, "patch": item["patch"]} if side == 0 else item["vertex"]
                        queues[side][to, k].append((now + self._random.randint(1, self._delay), came))

    def _next(self, side, to, queues, now):
        """Items that go on to a cluster, from any source."""
        size = 1 if side == 0 else 4
        ready = [queue for (at, _), queue in queues.items()
                 if at == to and len(queue) >= size and queue[size - 1][0] <= now]
        if not ready:
            return []
        queue = self._random.choice(ready)
        return [queue.popleft()[1] for _ in range(size)]

    def stop(self):
        """Answer nothing more."""
        self._task.cancel()
        for _, name in self._sides:
            for one in self._wires[name]:
                one.valid.value = 0

"""A memory system alone, whose bus and network answer late, with errors, or not at all."""

import random
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from itertools import count

from amaranth.hdl import Cat, Module, ResetInserter, Signal, Value
from amaranth.lib.data import View

from golden.engine.config import Config
from hw.lib.payload import pack, unpack
from hw.memsys.memory_system import LOADS, MemorySystem
from hw.memsys.patches.path_fault import PathFault
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind
from tb.lib.simulator import simulator_of
from tb.memsys.patch_words import load_of

__all__ = ["OWN", "FaultBench", "Faults", "Scene"]

# The cluster whose memory system it is.
OWN, NOWHERE = 0, (1 << 32) - 1
# Cycles of a section at most that ends, beside a time-out.
LIMIT = 3000
# Cycles from a transfer to all that follows from it without a reply.
SETTLES = 40


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Cells with the patches in them, and where the patches are.

    Parameters
    ----------
    lists
        By cell its patches.
    residence
        By patch the cluster and the local address that hold it; none: main memory alone.
    """

    lists: dict[int, tuple[int, ...]]
    residence: dict[int, tuple[int, int]]

    @property
    def count(self) -> int:
        """Patches."""
        return 1 + max(patch for patches in self.lists.values() for patch in patches)


@dataclass(frozen=True, kw_only=True)
class Faults:
    """What goes wrong in a section.

    Parameters
    ----------
    parts, patches
        Replies of the bus that are errors: parts of lists, as cell and number of the part, and patches.
    void
        Patches that the cluster named for them has not.
    cells
        Cells that the scene has not.
    silent
        Replies after which the bus and the network say nothing more.
    """

    parts: Collection[tuple[int, int]] = ()
    patches: Collection[int] = ()
    void: Collection[int] = ()
    cells: Collection[int] = ()
    silent: tuple[int | None, int | None] = field(default=(None, None))

    @property
    def reports(self) -> set[tuple[PathFault, int]]:
        """What of it may be reported."""
        return ({(PathFault.BUS, cell) for cell, _ in self.parts} | {(PathFault.BUS, patch) for patch in self.patches}
                | {(PathFault.RESIDENCE, patch) for patch in self.void}
                | {(PathFault.CELL, cell) for cell in self.cells})


class FaultBench:
    """Sections of a scene, one after the other.

    Parameters
    ----------
    config
        The configuration.
    scene
        The scene.
    """

    def __init__(self, config: Config, scene: Scene):
        self._config, self._scene, self._formats = config, scene, PathFormats(config)
        dut, reset, top = MemorySystem(config=config), Signal(), Module()
        # One signal for all inputs, and one for all outputs: the simulator is slow in accesses from outside.
        given = {"reset": reset, "clear": dut.clear, "cluster": dut.cluster, "scene": dut.scene}
        for name in (*(f"i_load_{name}" for name in LOADS), "i_start", "i_cell", "i_bus", "i_reply"):
            port = getattr(dut, name)
            given |= {f"{name} valid": port.valid, name: port.payload}
        given |= {"o_vertex ready": dut.o_vertex.ready}
        seen = {**{f"{name} ready": getattr(dut, name).ready for name in ("i_start", "i_cell", "i_reply")},
                "o_vertex valid": dut.o_vertex.valid, "o_vertex": dut.o_vertex.payload, "o_bus valid": dut.o_bus.valid,
                "o_bus": dut.o_bus.payload, "o_request valid": dut.o_request.valid, "o_request": dut.o_request.payload,
                "drained": dut.drained, "fault": dut.fault}
        self._shapes = {name: one.shape() for name, one in (given | seen).items() if isinstance(one, View)}
        self._given, self._seen = ({name: Value.cast(one) for name, one in some.items()} for some in (given, seen))
        self._inputs, self._outputs = (Signal(sum(map(len, some.values()))) for some in (self._given, self._seen))
        top.submodules.dut = ResetInserter(reset)(dut)
        top.d.comb += [Cat(*(one for one in self._given.values() if len(one))).eq(self._inputs),
                       self._outputs.eq(Cat(*self._seen.values())), dut.o_bus.ready.eq(1), dut.o_request.ready.eq(1)]
        self._simulator = simulator_of(top)
        self._script, self._has_run, self._stable, self._ctx = None, False, {}, None
        self._faults, self._draw, self._delay = Faults(), random.Random(0), 1

    def run(self, script) -> None:
        """Run a coroutine with this bench, from the beginning of a simulation."""
        self._script, self._stable = script, {}
        if self._has_run:
            self._simulator.reset()
        else:
            self._simulator.add_testbench(self._follow)
        self._has_run = True
        self._simulator.run()

    async def _follow(self, ctx):
        self._ctx = ctx
        await self._script(self)

    async def _cycle(self, **values):
        """One cycle with some inputs, by name, all others 0; the outputs in it."""
        bits = shift = 0
        values = self._stable | values
        for name, port in self._given.items():
            value = values.get(name, 0)
            bits |= (pack(self._shapes[name], value) if isinstance(value, dict) else int(value)) << shift
            shift += len(port)
        self._ctx.set(self._inputs, bits)
        *_, seen = await self._ctx.tick().sample(self._outputs)
        found = {}
        for name, port in self._seen.items():
            value = seen & (1 << len(port)) - 1
            found[name] = unpack(self._shapes[name], value) if name in self._shapes else value
            seen >>= len(port)
        return found

    def vertices(self, patch: int) -> list[list[int]]:
        """Those of a patch."""
        return [[16 * patch + 4 * k + axis + 1 for axis in range(3)] for k in range(BEATS - 1)]

    async def load(self) -> None:
        """All tables, which empties the patch store."""
        scene = self._scene
        cells, pointers, lists = 1 + max(scene.lists), {}, []
        for cell, patches in scene.lists.items():
            pointers[cell] = len(lists)
            lists += patches
        self._stable = {"cluster": OWN, "scene": {"cells": cells, "lists": len(lists), "patches": scene.count}}
        records = {
            "cells": [(cell, {"pointer": pointers.get(cell, 0), "count": len(scene.lists.get(cell, ()))})
                      for cell in range(cells)],
            "lists": [*enumerate(lists)],
            "types": [(patch, dict(zip(("cluster", "address"), scene.residence.get(patch, (NOWHERE, NOWHERE)),
                                       strict=True))) for patch in range(scene.count)]}
        loads = {name: [{"address": address, "record": record} for address, record in some]
                 for name, some in records.items()}
        loads["geometry"] = [load for patch, (cluster, address) in scene.residence.items() if cluster == OWN
                             for load in load_of(address, patch, patch, self.vertices(patch))]
        assert {*loads} == {*LOADS}
        for step in range(max(map(len, loads.values())) + 4):
            now = {f"i_load_{name}": items[step] for name, items in loads.items() if step < len(items)}
            await self._cycle(**now, **{f"{name} valid": 1 for name in now})

    async def section(self, cells, *, seed: int, faults: Faults | None = None,
                      delay: int | Mapping = 12) -> None:
        """Cast a section: all that is not lost comes once, and what is lost is reported.

        Parameters
        ----------
        cells
            In their order; one more faulty cell for each of `Faults.cells`.
        seed
            Of what is drawn.
        delay
            Replies come after 1 to so many cycles; or those of some requests, by kind (of the network None) and key,
            others after 1.
        """
        self._faults, self._draw, self._delay = faults or Faults(), random.Random(seed), delay
        order = [*cells]
        for cell in self._faults.cells:
            order.insert(self._draw.randrange(len(order) + 1), cell)
        came, ended = await self._cast(order)
        fault = (await self._cycle())["fault"]
        found = PathFault(fault["code"]), fault["number"]
        if self._faults.silent != (None, None) and not ended:
            assert found[0] is PathFault.TIMEOUT, f"a section that does not end has {found[0].name}"
        else:
            assert ended, f"neither an end nor a time-out, but {found[0].name}"
            # Patches come when their sources answer.
            assert sorted(came) == sorted(self._expected(cells)), "each patch that is not lost comes once"
            reports = self._faults.reports or {(PathFault.NONE, 0)}
            assert found in reports, f"{found} is none of {reports}"

    def _expected(self, cells):
        """Patches with their vertices; part by part of the lists, until one is lost."""
        faults, scene, ids, own = self._faults, self._scene, self._config.memsys.reply_ids, self._config.memsys
        found, at = set(), 0
        extents = {}
        for cell, patches in scene.lists.items():
            extents[cell] = at + len(patches)
            at += len(patches)
        for cell in cells:
            patches = scene.lists.get(cell, ())
            if cell >= own.own_cells or extents[cell] > own.own_entries:
                lost = min((part for one, part in faults.parts if one == cell), default=len(patches))
                patches = patches[:lost * ids]
            found |= {*patches}
        zeros = [[0] * 3] * (BEATS - 1)
        return [(patch, zeros if patch in faults.void else self.vertices(patch)) for patch in found
                if patch not in faults.patches]

    async def clear(self) -> None:
        """The fault has been read."""
        await self._cycle(clear=1)
        await self._cycle()

    async def reset(self) -> None:
        """All but the tables."""
        await self._cycle(reset=1)

    async def _cast(self, cells):
        """What came, and whether the section ended."""
        draw = self._draw
        for waited in count():
            if (await self._cycle(**{"i_start valid": 1}))["i_start ready"]:
                break
            assert waited < LIMIT, "a section never begins"
        queue, vertices = deque(cells), []
        bus, network = _Replies(2), _Replies(1)
        for now in range(LIMIT + (8 << self._config.memory.timeout_bits)):
            given = {"o_vertex ready": draw.random() < 0.8}
            offers = {"i_cell": queue[0] if queue else None, "i_bus": bus.shown(now, draw),
                      "i_reply": network.shown(now, draw)}
            for name, offer in offers.items():
                if offer is not None:
                    given |= {f"{name} valid": 1, name: offer}
            seen = await self._cycle(**given)
            if queue and seen["i_cell ready"]:
                queue.popleft()
            bus.take(offers["i_bus"] is not None)
            network.take(offers["i_reply"] is not None and seen["i_reply ready"])
            if seen["o_vertex valid"] and given["o_vertex ready"]:
                vertices.append(seen["o_vertex"])
            if seen["o_bus valid"] and self._speaks(0, bus):
                kind, key = RequestKind(seen["o_bus"]["kind"]), seen["o_bus"]["key"]
                bus.add(kind.value, now + self._after(kind, key), self._bus_reply(kind, key))
            if seen["o_request valid"] and self._speaks(1, network):
                patch = seen["o_request"]["patch"]
                network.add(0, now + self._after(None, patch), self._patch_reply(patch))
            is_late = seen["fault"]["code"] == PathFault.TIMEOUT.value
            is_over = not queue and seen["drained"] and now > SETTLES
            if is_over or is_late:
                break
        for _ in range(SETTLES):
            seen = await self._cycle(**{"o_vertex ready": 1})
            assert is_late or not seen["o_vertex valid"], "a vertex comes after the end"
        four = [vertices[k:k + 4] for k in range(0, len(vertices), 4)]
        assert all(len({one["patch"] for one in vertices}) == 1 for vertices in four), "a patch stays together"
        return [(one[0]["patch"], [vertex["vertex"] for vertex in one]) for one in four], bool(is_over)

    def _after(self, kind, key):
        """Cycles until a reply."""
        return self._delay.get((kind, key), 1) if isinstance(self._delay, dict) else self._draw.randint(1, self._delay)

    def _speaks(self, side, replies):
        silent = self._faults.silent[side]
        return silent is None or replies.count < silent

    def _bus_reply(self, kind, key):
        """Beats of a reply, an error or not."""
        if kind is RequestKind.PATCH:
            head = pack(self._formats.patch_head, {"patch": key, "surface": key})
            bits = self._config.numbers.scene.width
            beats = [head, *(sum(part << bits * axis for axis, part in enumerate(one)) for one in self.vertices(key))]
            return [{"kind": kind.value, "last": k == BEATS - 1, "error": key in self._faults.patches, "data": data}
                    for k, data in enumerate(beats)]
        cell, part = key & (1 << self._formats.cell_bits) - 1, key >> self._formats.cell_bits
        ids, patches = self._config.memsys.reply_ids, self._scene.lists.get(cell, ())
        error = (cell, part) in self._faults.parts
        some = [] if error else patches[part * ids:(part + 1) * ids]
        more = not error and len(patches) > (part + 1) * ids
        beats = [{"number": patch, "is_id": 1, "more": more} for patch in some] or [{"number": 0}]
        return [{"kind": kind.value, "last": k == len(beats) - 1, "error": error,
                 "data": pack(self._formats.cell_beat, beat)} for k, beat in enumerate(beats)]

    def _patch_reply(self, patch):
        """Vertices from another cluster."""
        vertices = [[0] * 3] * (BEATS - 1) if patch in self._faults.void else self.vertices(patch)
        return [{"patch": patch, "surface": patch, "vertex": vertex} for vertex in vertices]


class _Replies:
    """Replies of some kinds, those of a kind in order, each from its cycle on.

    Parameters
    ----------
    kinds
        Number of kinds.
    """

    def __init__(self, kinds: int):
        self._queues, self._at, self.count = [deque() for _ in range(kinds)], None, 0

    def add(self, kind: int, due: int, items: list) -> None:
        """Another one."""
        self._queues[kind].extend((due, item) for item in items)
        self.count += 1

    def shown(self, now: int, draw: random.Random):
        """The item that is offered; an offer stays."""
        if self._at is None:
            due = [queue for queue in self._queues if queue and queue[0][0] <= now]
            if not due:
                return None
            self._at = draw.choice(due)
        return self._at[0][1]

    def take(self, is_taken: bool) -> None:
        """The offer was accepted."""
        if is_taken:
            self._at.popleft()
            self._at = None

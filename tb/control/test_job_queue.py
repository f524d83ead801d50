"""The queue from the ring to the completion records, with clusters, loads and a memory that take their time."""

import random
from collections import Counter, deque

import pytest
from amaranth.hdl import Module, ResetInserter, Signal, Value
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.jobs.completion import COMPLETION, has_arrived, parse_completions
from golden.jobs.descriptor import DESCRIPTOR, check_descriptor
from hw.control.completion_writer import CompletionWriter
from hw.control.descriptor_fetch import DescriptorFetch
from hw.control.frustum_slot import FrustumSlot
from hw.control.job_control import JobControl
from hw.control.job_dispatch import JobDispatch
from hw.registers.engine_registers import register
from hw.registers.error_code import ErrorCode
from tb.control.job_descriptors import byte_at, changed, descriptor
from tb.lib.payload import unpack

RING, COMPLETIONS, BITS = 0x1000, 0x8000, 3
ALL = (1 << 20) - 1


class Queue(wiring.Component):
    """All blocks of the queue, connected as in an engine; clusters are slots whose sections the bench takes."""

    def __init__(self, config):
        super().__init__({})
        self.fetch, self.dispatch = DescriptorFetch(config=config), JobDispatch(config=config)
        self.control, self.writer = JobControl(config=config), CompletionWriter(config=config)
        self.slots = [FrustumSlot(config=config) for _ in range(config.noc.nodes)]

    def elaborate(self, platform):
        m = Module()
        fetch, dispatch, control, writer = self.fetch, self.dispatch, self.control, self.writer
        m.submodules.control, m.submodules.writer = control, writer
        m.submodules.fetch, m.submodules.dispatch = (ResetInserter(control.stops)(one) for one in (fetch, dispatch))
        wiring.connect(m, fetch.o, dispatch.i)
        wiring.connect(m, dispatch.o_load, control.i_load)
        wiring.connect(m, dispatch.o_refused, control.i_refused)
        wiring.connect(m, control.o_record, writer.i_record)
        # Events pass a register, as they would between clusters far apart.
        word, requests = Signal.like(dispatch.o.payload), Signal(len(self.slots))
        valid = Signal()
        with m.If(control.stops):
            m.d.sync += [valid.eq(0), requests.eq(0)]
        with m.Else():
            m.d.sync += [valid.eq(dispatch.o.valid), word.eq(dispatch.o.payload)]
            m.d.sync += [requests[k].eq(slot.requests) for k, slot in enumerate(self.slots)]
        for k, slot in enumerate(self.slots):
            m.submodules[f"slot_{k}"] = ResetInserter(control.stops)(slot)
            m.d.comb += [slot.i.valid.eq(valid & (word.cluster == k)), slot.i.payload.eq(word)]
        m.d.comb += [
            dispatch.requests.eq(requests), dispatch.enable.eq(control.enable), dispatch.loaded.eq(control.loaded),
            dispatch.last_shell.eq(-1),
            control.unread.eq(dispatch.failed), control.dispatches.eq(dispatch.busy),
            control.i_sent.valid.eq(dispatch.o_sent.valid), control.i_sent.payload.eq(dispatch.o_sent.payload),
            fetch.ring.eq(control.kept.ring), fetch.ring_bits.eq(control.kept.ring_bits),
            fetch.doorbell.eq(control.doorbell), fetch.taken.eq(control.taken), fetch.enable.eq(control.enable),
            writer.completions.eq(control.kept.completions), writer.ring_bits.eq(control.kept.ring_bits),
            writer.stops.eq(control.stops), writer.retry.eq(control.retry), writer.tag.eq(control.tag),
            control.source.eq(writer.source), control.i_collected.valid.eq(writer.o_collected.valid),
            control.i_collected.payload.eq(writer.o_collected.payload), control.completed.eq(writer.completed),
            control.empty.eq(writer.empty), control.unwritten.eq(writer.failed), control.address.eq(writer.address)]
        return m


class Machine:
    """A queue, its host and its memory.

    Parameters
    ----------
    nodes
        Clusters.

    Members
    -------
    records
        Completion records in their order.
    begun
        Sections that clusters have begun, as (cluster, address of their hits).
    cycles
        Of the run.
    """

    def __init__(self, nodes):
        self.config = PRESETS["tiny"].replace({"noc.columns": nodes, "noc.rows": 1})
        self.nodes, self._top, self._has_run = nodes, Queue(self.config), False
        self._simulator = Simulator(self._top)
        self._simulator.add_clock(1e-8)

    def run(self, ones, *, seed=0, stops=(), bad=(), cast=(20, 60), write=(5, 40), cycles=6000):
        """Execute descriptors; ``stops``: cycles of stops, ``bad``: descriptors that cannot be read the first time."""
        self._given = list(ones), seed, set(stops), set(bad), cast, write, cycles
        self.records, self.begun, self.halts = [], [], 0
        if self._has_run:
            self._simulator.reset()
        else:
            self._simulator.add_testbench(self._drive)
        self._has_run = True
        self._simulator.run()
        return self.records

    def _set_constants(self, ctx):
        """The ring's place, and memory that always accepts."""
        top, control = self._top, self._top.control
        for name, value in ("ring", RING), ("completions", COMPLETIONS), ("ring_bits", BITS), ("image", 0x40):
            ctx.set(getattr(control, name), value)
        for accepted in control.o_load, top.writer.o_request, top.writer.o_data, top.fetch.o_request:
            ctx.set(accepted.ready, 1)

    async def _drive(self, ctx):
        top = self._top
        fetch, control, writer, slots = top.fetch, top.control, top.writer, top.slots
        ones, seed, stops, bad, cast, _, cycles = self._given
        draw, memory, size = random.Random(seed), {}, self.config.memory.beat_bytes
        reads, beats, answers, load = deque(), deque(), deque(), None
        sections, words = [deque() for _ in slots], [deque() for _ in slots]
        self._set_constants(ctx)
        ports = [Value.cast(one) for one in (
            control.stops, control.status, control.completed, fetch.o_request.valid, fetch.o_request.payload,
            fetch.i_reply.ready, control.o_load.valid, writer.o_request.valid, writer.o_request.payload,
            writer.o_data.valid, writer.o_data.payload,
            *(slot.o.valid for slot in slots), *(slot.o.payload for slot in slots), *(one.ready for one in writer.i))]
        nodes, known, submitted, halted = self.nodes, {}, 0, 0

        def put(signal, value):
            # The simulator is slow in accesses from outside.
            if known.get(id(signal)) != value:
                ctx.set(signal, value)
                known[id(signal)] = value

        for cycle in range(cycles):
            # The host keeps the ring full.
            room = submitted < len(ones) and submitted - len(self.records) < 1 << BITS
            if cycle > 3 and room and draw.random() < 0.5:
                entry = RING + DESCRIPTOR.dtype.itemsize * (submitted % (1 << BITS))
                memory |= dict(enumerate(ones[submitted].tobytes(), start=entry))
                submitted += 1
            put(control.doorbell, submitted)
            command = 1 if cycle in stops else 4 if halted == 10 else 0
            put(control.i_command.valid, int(command > 0))
            put(control.i_command.payload, command)
            # Clusters.
            begins = 0
            for k in range(nodes):
                states = [one[0] for one in sections[k]]
                takes = "cast" not in states and len(states) < 2 and ctx.get(slots[k].o.valid)
                put(slots[k].o.ready, int(takes))
                begins |= int(takes) << k
                put(slots[k].free, int(not ctx.get(slots[k].o.valid) and len(states) < 2))
                put(writer.i[k].valid, int(bool(words[k])))
                put(writer.i[k].payload, words[k][0] if words[k] else 0)
            put(control.begins, begins)
            over = load is not None and load == 0
            put(control.load_over.valid, int(over))
            beat = beats and beats[0][0] <= cycle
            put(fetch.i_reply.valid, int(bool(beat)))
            if beat:
                put(fetch.i_reply.payload, beats[0][1])
            due = answers and answers[0] <= cycle
            put(writer.i_written.valid, int(bool(due)))
            put(control.memory_busy, int(bool(beats or reads or answers)))
            (_, _, stopped, status, completed, reading, request, took, loading, writing, place, sending, data,
             *rest) = await ctx.tick().sample(*ports)
            full, offered, accepted = rest[:nodes], rest[nodes:2 * nodes], rest[2 * nodes:]
            status = register("status").unpack(status)
            load = None if over or load is None else load - 1
            halted = halted + 1 if status["halted"] and not status["stops"] else 0
            self.halts += halted == 1
            if due:
                answers.popleft()
            if beat and (took or stopped):
                beats.popleft()
            if stopped:
                sections, words = [deque() for _ in slots], [deque() for _ in slots]
                load = None
                reads.clear()
                continue
            if reading:
                found = unpack(fetch.o_request.payload.shape(), request)
                beats += self._beats(found, memory, bad, cycle + 12)
            if loading:
                load = draw.randint(5, 60)
            if writing:
                found = unpack(writer.o_request.payload.shape(), place)
                reads.append([found["address"], found["length"] + 1])
            if sending:
                found, current = unpack(writer.o_data.payload.shape(), data), reads[0]
                memory |= dict(enumerate(found["data"].to_bytes(size, "little"), start=current[0]))
                current[0], current[1] = current[0] + size, current[1] - 1
                if not current[1]:
                    reads.popleft()
                    answers.append(cycle + draw.randint(3, 20))
            for k in range(nodes):
                for one in sections[k]:
                    one[1] = max(0, one[1] - 1)
                if begins >> k & 1 and full[k]:
                    slot = unpack(slots[k].o.payload.shape(), offered[k])
                    sections[k].append(["cast", draw.randint(*cast)])
                    self.begun.append((k, slot["results"]["hits"]))
                if accepted[k] and words[k]:
                    words[k].popleft()
                    if not words[k]:
                        sections[k].popleft()
                if sections[k]:
                    self._go_on(draw, sections[k][0], words[k])
            self._read(memory, completed)
            if len(self.records) == len(ones) and not status["busy"]:
                break
        self.cycles = cycle


    def _go_on(self, draw, section, words):
        """A cluster's oldest section is cast, then written, then it has a record."""
        state, left = section
        if state == "cast" and not left:
            section[:] = ["write", draw.randint(*self._given[5])]
        elif state == "write" and not left:
            section[0] = "done"
            words.extend([*(draw.getrandbits(64) for _ in range(7)), draw.getrandbits(8) << 48])

    def _beats(self, request, memory, bad, cycle):
        """The answer of memory to a read, from a cycle on; descriptors that are bad are so once."""
        size, found = self.config.memory.beat_bytes, []
        for k in range(request["length"] + 1):
            address = request["address"] + size * k
            content = bytes(memory.get(address + j, byte_at(address + j)) for j in range(size))
            found.append((cycle + k, {
                "data": int.from_bytes(content, "little"), "tag": 0, "last": int(k == request["length"]),
                "error": int(address in bad)}))
            bad.discard(address)
        return found

    def _read(self, memory, completed):
        """The host reads the records that have been counted, each of which is in the ring."""
        ring = parse_completions(bytes(memory.get(COMPLETIONS + k, 0) for k in range(
            COMPLETION.dtype.itemsize << BITS)))
        while len(self.records) < completed:
            assert has_arrived(ring, len(self.records))
            self.records.append(ring[len(self.records) % (1 << BITS)].copy())


@pytest.fixture(scope="module", params=[pytest.param(1, marks=pytest.mark.sim), 3])
def machine(request):
    return Machine(request.param)


def draws(machine, count, seed, first=({"kind": 1, "regions": ALL},)):
    draw = random.Random(seed)
    changes = [*first, *draw.choices(({}, {}, {}, {"version": 2}, {"last_shell": 0}, {"kind": 1, "regions": ALL}),
                                     weights=(8, 8, 8, 1, 1, 1), k=count - len(first))]
    return [changed(descriptor(machine.config, draw, tag=number), **{"hits": 64 * number, **change})
            for number, change in enumerate(changes)]


def test_every_descriptor_has_its_record(machine):
    ones = draws(machine, 26, machine.nodes)
    records = machine.run(ones, seed=machine.nodes)
    assert Counter(int(one["tag"]) for one in records) == Counter(range(26))
    for record in records:
        refusal = check_descriptor(ones[int(record["tag"])], machine.config)
        assert ErrorCode(int(record["error"])).name == (refusal.code if refusal else "NONE")
    sections = [int(one["hits"]) for one in ones if not check_descriptor(one, machine.config) and one["kind"] == 0]
    assert [hits for _, hits in machine.begun] == sections or machine.nodes > 1
    assert Counter(hits for _, hits in machine.begun) == Counter(sections)
    assert not machine.halts


def test_stops_at_any_time(machine):
    """Each descriptor has one record still; the aborted ones say so."""
    for stop in (50 * machine.nodes, 150 + 90 * machine.nodes):
        ones = draws(machine, 12, stop)
        records = machine.run(ones, seed=stop, stops={stop})
        assert Counter(int(one["tag"]) for one in records) == Counter(range(12))
        assert machine.halts == 1
        codes = {ErrorCode(int(record["error"])).name for record in records}
        assert codes <= {"NONE", "ABORTED", "DESCRIPTOR"}


def test_a_ring_that_cannot_be_read_once(machine):
    ones = draws(machine, 10, 5)
    records = machine.run(ones, bad={RING + DESCRIPTOR.dtype.itemsize * 5 + 64})
    assert Counter(int(one["tag"]) for one in records) == Counter(range(10))
    assert machine.halts == 1
    assert "ABORTED" not in {ErrorCode(int(record["error"])).name for record in records}


def test_nothing_is_cast_before_a_load(machine):
    records = machine.run(draws(machine, 4, 1, first=({}, {}, {}, {"kind": 1, "regions": ALL})))
    assert [ErrorCode(int(one["error"])).name for one in records] == ["NOT_LOADED"] * 3 + ["NONE"]


def test_dispatch_does_not_bound_short_sections(machine):
    """Sections of 60 cycles on each cluster: the next one waits in the slot when the present one has been cast."""
    draw = random.Random(1)
    count = 11 * min(machine.nodes, 2)
    ones = [changed(descriptor(machine.config, draw, tag=number), near_count=14) for number in range(count)]
    ones.insert(0, changed(ones[0], kind=1, regions=ALL))
    machine.run(ones, cast=(60, 60), write=(5, 5))
    assert machine.cycles < (60 * count * 1.2 if machine.nodes == 1 else 45 * count) + 300

"""Completion writer: the completion records of all descriptors, one after the other, to a ring in main memory."""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.job_formats import COMPLETION_WORDS, WORD_BITS, JobFormats, elements
from hw.lib.round_robin import RoundRobin
from hw.memsys.port.memory_formats import MemoryFormats, saturated
from hw.registers.engine_registers import RING_BITS

__all__ = ["CompletionWriter"]

# Records that are held: a power of two.
RECORDS = 4
COUNT_BITS = 32
LAP_BITS = 16


class CompletionWriter(wiring.Component):
    """Collects the 8 words of a record from a cluster, or makes one of a `JobFormats.record`, and writes it.

    Records are collected in round-robin order and written in the order of their collection. A record is held until its
    write has been answered: ``completed`` advances then. The last word has the descriptor's tag, which the table of
    sections in flight gives by the cluster, the cluster, and the lap of the ring: a host that reads the lap in memory
    reads the whole record.

    During a reset of the units a record that is being collected is dropped, and writes that are not answered are
    forgotten; their records are written again after it. After a write that memory refuses nothing is written until a
    reset, and a retry after it.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, ``clusters`` streams of 64 bits
        Words of the clusters' records, 8 each in their order. Of the last one only the error counts.
    i_record : In, stream of `JobFormats.record`
        Records that no cluster writes; accepted when they have been collected.
    source : Out(JobFormats.cluster)
        The cluster whose record is being collected.
    tag : In(32)
        Of the oldest section of cluster ``source``, in the same cycle.
    o_collected : Out, stream of a cluster
        The record of its oldest section has been collected. Always ready.
    completions : In(address_bits)
        Address of the ring, a multiple of 64. Stable unless ``empty`` or ``failed``, like ``ring_bits``.
    ring_bits : In(RING_BITS)
        It has 2^b entries.
    completed : Out(32)
        Records ever written, modulo 2^32.
    empty : Out(1)
        No record is held or being collected.
    stops : In(1)
        The units are in reset.
    retry : In(1)
        Write again after a failure.
    failed : Out(1)
        A record could not be written.
    address : Out(address_bits)
        Address of the oldest record that is held.
    o_request : Out, stream of `MemoryFormats.request`
        `WriteMerge`'s ``i_request``.
    o_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_data``.
    i_written : In, stream of `MemoryFormats.written`
        Its ``o_written``. Always ready.

    Timing
    ------
    Latency: ``9`` cycles from the offer of a record to its request. A record takes 8 cycles, without a gap to one of
    another source; a beat per cycle, without a gap between records; stalls with ``o_request`` and ``o_data``, and while
    4 records have not been answered.

    Golden counterpart: `golden.engine.jobs.completion`.
    """

    latency = COMPLETION_WORDS + 1

    def __init__(self, *, config: Config):
        self._config, memory, formats = config, MemoryFormats(config), JobFormats(config)
        self._lanes = config.memory.data_bits // WORD_BITS
        self._beats = COMPLETION_WORDS // self._lanes
        # Beats of a request, and requests of a record.
        self._length = min(self._beats, 1 << config.memory.length_bits)
        address = config.memory.address_bits
        super().__init__({
            "i": In(stream.Signature(WORD_BITS)).array(config.noc.clusters), "i_record": In(stream.Signature(
                formats.record)), "source": Out(formats.cluster), "tag": In(32),
            "o_collected": Out(stream.Signature(formats.cluster, always_ready=True)), "completions": In(address),
            "ring_bits": In(RING_BITS), "completed": Out(COUNT_BITS), "empty": Out(1), "stops": In(1),
            "retry": In(1), "failed": Out(1), "address": Out(address),
            "o_request": Out(stream.Signature(memory.request(0))), "o_data": Out(stream.Signature(memory.write_data)),
            "i_written": In(stream.Signature(memory.written(0), always_ready=True))})

    def elaborate(self, platform):
        m = Module()
        self._memories = [Memory(shape=WORD_BITS, depth=RECORDS * self._beats, init=[],
                                 attrs={"ram_style": "distributed"}) for _ in range(self._lanes)]
        for lane, memory in enumerate(self._memories):
            m.submodules[f"lane_{lane}"] = memory
        # Numbers of the next records to collect, to request, to send.
        collected, requested, sent = (Signal(COUNT_BITS, name=name) for name in ("collected", "requested", "sent"))
        m.d.comb += self.address.eq(self._address(self.completed))
        busy = self._add_words(m, collected)
        self._add_writes(m, collected, requested, sent)
        m.d.comb += self.empty.eq(~busy & (collected == self.completed))
        return m

    def _entry(self, number):
        return number & ((1 << self.ring_bits) - 1)

    def _address(self, number):
        return self.completions + (self._entry(number) << 6)

    def _add_words(self, m, collected):
        """Records into the memories. Gives whether one is being collected."""
        clusters, word_bits = self._config.noc.clusters, (COMPLETION_WORDS - 1).bit_length()
        m.submodules.turn = turn = RoundRobin(count=clusters + 1)
        requests, granted, index = Signal(clusters + 1), Signal(clusters + 1), Signal(word_bits)
        busy, is_own, moves, ends, free = (Signal(name=name) for name in ("busy", "is_own", "moves", "ends", "free"))
        number = Signal(range(clusters))
        valid, word = Signal(), Signal(WORD_BITS)
        record = self.i_record.payload
        # After the last word its source offers another record at the earliest.
        m.d.comb += [
            requests.eq(Cat(*(one.valid for one in self.i), self.i_record.valid)
                        & ~Mux(busy, granted, 0)), is_own.eq(granted[-1]), self.source.eq(number),
            free.eq((collected + busy - self.completed)[:RECORDS.bit_length()] != RECORDS),
            turn.request.eq(requests), turn.eligible.eq(requests),
            turn.accept.eq((~busy | ends) & free & requests.any() & ~self.stops),
            valid.eq(Mux(is_own, self.i_record.valid, Array(one.valid for one in self.i)[number])),
            moves.eq(busy & valid & ~self.stops), ends.eq(moves & (index == COMPLETION_WORDS - 1)),
            self.i_record.ready.eq(ends & is_own), self.o_collected.valid.eq(ends & ~is_own),
            self.o_collected.payload.eq(number)]
        for k, one in enumerate(self.i):
            m.d.comb += one.ready.eq(busy & granted[k] & ~self.stops)
        with m.If(turn.accept):
            m.d.sync += [granted.eq(turn.grant), busy.eq(1), index.eq(0)]
            for k in range(clusters):
                with m.If(turn.grant[k]):
                    m.d.sync += number.eq(k)
        with m.Elif(ends | self.stops):
            m.d.sync += busy.eq(0)
        with m.If(moves):
            m.d.sync += index.eq(index + 1)
        with m.If(ends):
            m.d.sync += collected.eq(collected + 1)

        # The last word of a cluster's record, and all words of other records.
        own, last, given = Array(Signal(WORD_BITS, name=f"own_{k}") for k in range(COMPLETION_WORDS)), Signal(
            WORD_BITS), Signal(WORD_BITS)
        lap = Signal(LAP_BITS)

        def put(target, name, value):
            (_, bits), = elements(name, record="completion")
            m.d.comb += target[bits].eq(value)

        (_, error), = elements("error", record="completion")
        m.d.comb += [lap.eq((collected >> self.ring_bits) + 1), given.eq(Array(one.payload for one in self.i)[number])]
        put(last, "tag", Mux(is_own, record.tag, self.tag))
        put(last, "error", Mux(is_own, record.code, given[error]))
        put(last, "cluster", Mux(is_own, record.cluster, number))
        put(last, "lap", lap)
        for name in "number", "begin", "end":
            field = {"number": "address"}.get(name, name)
            (offset, _), = elements(field, record="completion")
            put(own[offset], field, record[name])
        m.d.comb += word.eq(Mux(index == COMPLETION_WORDS - 1, last, Mux(is_own, own[index], given)))
        lane_bits = self._lanes.bit_length() - 1
        entry = collected[:RECORDS.bit_length() - 1]
        for lane, memory in enumerate(self._memories):
            write = memory.write_port()
            m.d.comb += [write.en.eq(moves & (index[:lane_bits] == lane)), write.data.eq(word),
                         write.addr.eq(Cat(index[lane_bits:], entry))]
        return busy

    def _add_writes(self, m, collected, requested, sent):
        """Requests, beats, and answers, each record by record."""
        parts = self._beats // self._length
        part, beat, answers = (Signal(range(max(2, count)), name=name) for name, count in (
            ("part", parts), ("beat", self._beats), ("answers", parts)))
        request, data, answer, wrong = self.o_request, self.o_data, self.i_written, Signal()
        requests, sends, failing = Signal(), Signal(), Signal()
        step = self._length * self._lanes * WORD_BITS // 8
        m.d.comb += [
            request.valid.eq((requested != collected) & ~self.failed & ~self.stops),
            request.payload.address.eq(saturated(self._address(requested) + part * step, len(self.completions))),
            request.payload.length.eq(self._length - 1), requests.eq(request.valid & request.ready),
            # Beats follow their request.
            data.valid.eq(((sent != requested) | (beat < part * self._length)) & ~self.stops),
            sends.eq(data.valid & data.ready), data.payload.strobe.eq(Const(-1, len(data.payload.strobe)))]
        entry = sent[:RECORDS.bit_length() - 1]
        for lane, memory in enumerate(self._memories):
            read = memory.read_port(domain="comb")
            m.d.comb += [read.addr.eq(Cat(beat[:self._beats.bit_length() - 1], entry)),
                         data.payload.data.word_select(lane, WORD_BITS).eq(read.data)]
        with m.If(requests):
            m.d.sync += part.eq(Mux(part == parts - 1, 0, part + 1))
            with m.If(part == parts - 1):
                m.d.sync += requested.eq(requested + 1)
        with m.If(sends):
            m.d.sync += beat.eq(Mux(beat == self._beats - 1, 0, beat + 1))
            with m.If(beat == self._beats - 1):
                m.d.sync += sent.eq(sent + 1)
        m.d.comb += failing.eq(answer.valid & (answer.payload.error | wrong) & (answers == parts - 1) & ~self.stops)
        with m.If(answer.valid & ~self.failed):
            m.d.sync += [answers.eq(Mux(answers == parts - 1, 0, answers + 1)),
                         wrong.eq((wrong | answer.payload.error) & (answers != parts - 1))]
            with m.If((answers == parts - 1) & ~failing & ~self.stops):
                m.d.sync += self.completed.eq(self.completed + 1)
        with m.If(failing & ~self.failed):
            m.d.sync += self.failed.eq(1)
        with m.Elif(self.retry):
            m.d.sync += self.failed.eq(0)
        with m.If(self.stops):
            m.d.sync += [requested.eq(self.completed), sent.eq(self.completed), part.eq(0), beat.eq(0), answers.eq(0),
                         wrong.eq(0)]

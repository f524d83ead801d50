"""Record words: the words of a region's records, numbered and checked."""

from amaranth.hdl import Array, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.load.image_layout import COUNT_BITS, PATCH_WORDS, RECORD_WORDS, RegionNumber
from hw.memsys.load.table_check import TableCheck
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["RecordWords"]


class RecordWords(wiring.Component):
    """Numbers the words of extents that follow each other, and checks them with `TableCheck`.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    region : In(RegionNumber)
        Of the words. Stable while words are in flight.
    start : In(1)
        The next word is the first one of a record; words in flight keep their numbers. Not beside a word.
    record : In(COUNT_BITS)
        That record.
    i : In, stream of `MemoryFormats.word`
        Words as they are read.
    o : Out, stream of ``item`` (`MemoryFormats.table_word`), ``last``, ``fault`` (`Fault`)
        Records of 4 bytes are words too; a patch has `PATCH_WORDS`. ``last``: of its extent. ``fault``: ``NONE``,
        ``READ_REPLY``, ``POINTER`` or ``SIZE``.
    table : Out(RegionNumber)
        As of `TableCheck`.
    limit : In(COUNT_BITS)
        As of `TableCheck`.

    Timing
    ------
    Latency: ``5`` cycles. One word per cycle; stalls with ``o``.
    """

    def __init__(self, *, config: Config):
        formats = MemoryFormats(config)
        self._check = TableCheck(config=config, tag=StructLayout({"last": 1, "error": 1}))
        super().__init__({
            "region": In(RegionNumber), "start": In(1), "record": In(COUNT_BITS),
            "i": In(stream.Signature(formats.word)),
            "o": Out(stream.Signature(StructLayout({"item": formats.table_word, "last": 1, "fault": Fault}))),
            "table": Out(RegionNumber), "limit": In(COUNT_BITS)})
        self.latency = self._check.latency + 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.check = check = self._check
        given = check.i.payload
        record, word = Signal(COUNT_BITS), Signal.like(given.item.word)
        counts = [PATCH_WORDS if region is RegionNumber.PATCHES else words
                  for region, words in zip(RegionNumber, RECORD_WORDS, strict=True)]
        last_word = Signal.like(word, reset_less=True)
        m.d.sync += last_word.eq(Array(Const(words - 1) for words in counts)[self.region])
        m.d.comb += [
            check.i.valid.eq(self.i.valid), self.i.ready.eq(check.i.ready), given.item.region.eq(self.region),
            given.item.record.eq(record), given.item.word.eq(word), given.item.data.eq(self.i.payload.data),
            given.tag.last.eq(self.i.payload.last), given.tag.error.eq(self.i.payload.error),
            self.table.eq(check.table), check.limit.eq(self.limit)]
        with m.If(self.start):
            m.d.sync += [record.eq(self.record), word.eq(0)]
        with m.Elif(self.i.valid & self.i.ready):
            m.d.sync += word.eq(word + 1)
            with m.If(word == last_word):
                m.d.sync += [word.eq(0), record.eq(record + 1)]

        # Registered: no combinational path from a fault to the reader.
        m.submodules.checked = checked = SkidBuffer(check.o.payload.shape())
        wiring.connect(m, check.o, checked.i)
        out, found = self.o.payload, checked.o.payload
        m.d.comb += [
            self.o.valid.eq(checked.o.valid), checked.o.ready.eq(self.o.ready), out.item.eq(found.item),
            out.last.eq(found.tag.last),
            out.fault.eq(Mux(found.tag.error, Fault.READ_REPLY, found.fault))]
        return m

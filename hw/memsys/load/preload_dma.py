"""Preload DMA: the tables of a memory image, checked, word by word."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memory_map import REGIONS
from hw.lib.checks import claim_steps
from hw.memsys.load.image_header import TABLES, ImageHeader
from hw.memsys.load.image_layout import COUNT_BITS, RegionNumber, halves
from hw.memsys.load.patch_extents import PatchExtents
from hw.memsys.load.record_extent import RecordExtent
from hw.memsys.load.record_words import RecordWords
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.word_reader import WordReader

__all__ = ["PreloadDma"]

# Regions of which a cluster has a part of its own, as bits; its record in the table of clusters says which part.
OWN = sum(1 << RegionNumber[name].value for name in ("CLUSTERS", "SUBSHELLS", "RESIDENTS", "PATCHES"))
# Of that record.
PARTS = ("first_subshell", "subshells", "first_resident", "residents")


class PreloadDma(wiring.Component):
    """Reads the header of an image, and of the requested regions all records or those of one cluster.

    ::

        ImageHeader --------.
        RecordExtent -------+- extents - WordReader - words -+- ImageHeader
        PatchExtents -------'                                '- RecordWords -+- o
              '------------------------- ids --------------------------------'

    Of ``clusters``, ``subshells``, ``residents`` and ``patches`` these are the cluster's: its own record, its lists,
    and the geometry of its resident set, one patch for each local address.

    A word leaves after it has been checked. The first fault ends the command; the words before it must not be used.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `MemoryFormats.preload`
        Commands.
    o : Out, stream of `MemoryFormats.table_word`
        Words. Records of 4 bytes are words too; a patch has `PATCH_WORDS`.
    o_done : Out, stream of `MemoryFormats.fault`
        One for each command, after its last word has been taken; the address of the faulty region.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``.
    i_reply : In, stream of `MemoryFormats.reply`
        Its ``o_read``.
    cells, patch_lists, patches, shells : Out(MemoryFormats.table)
        Of the image that was read last, as of `ImageHeader`.

    Timing
    ------
    Latency: ``5`` cycles from a reply to its word. One word per cycle within a region; stalls with ``o``. A patch takes
    7 cycles, one for its id. Regions wait for one round trip to memory each, and every 512 patches for two: one for
    the ids, one for the patches.

    Golden counterpart: `golden.engine.memory_map`.
    """

    def __init__(self, *, config: Config):
        self._config, formats = config, MemoryFormats(config)
        self._words = RecordWords(config=config)
        super().__init__({
            "i": In(stream.Signature(formats.preload)), "o": Out(stream.Signature(formats.table_word)),
            "o_done": Out(stream.Signature(formats.fault)), "o_request": Out(stream.Signature(formats.request(0))),
            "i_reply": In(stream.Signature(formats.reply(0))),
            **{name: Out(formats.table) for name in TABLES}})
        self.latency = self._words.latency

    def elaborate(self, platform):
        m = Module()
        config, number = self._config, RegionNumber
        m.submodules.header = header = ImageHeader(config=config)
        m.submodules.records = records = RecordExtent(config=config)
        m.submodules.patches = patches = PatchExtents(config=config)
        m.submodules.words = words = self._words
        m.d.comb += [*(getattr(self, name).eq(getattr(header, name)) for name in TABLES),
                     words.limit.eq(header.table_count), header.table.eq(words.table)]

        command, region = Signal.like(self.i.payload, reset_less=True), Signal(RegionNumber)
        # Ids of patches are read for the DMA itself.
        in_header, ids_only = Signal(), Signal()
        own = Signal(StructLayout(dict.fromkeys(PARTS, COUNT_BITS)))
        code, base = Signal(Fault), Signal(config.memory.address_bits)
        # Patches of the resident set that have been read, and those that are left; ids that are read at once.
        group = 1 << patches.index_bits
        done, left, chunk = Signal(COUNT_BITS), Signal(COUNT_BITS), Signal(range(group + 1))
        # Registered: the records of a region, and where they are, are known one cycle after the region.
        first, count, offset = (Signal.like(value, reset_less=True) for value in (
            records.i.payload.first, records.i.payload.records, header.offset))
        m.d.comb += [
            self.o_done.payload.code.eq(code), self.o_done.payload.address.eq(base), header.region.eq(region),
            words.region.eq(region), chunk.eq(Mux(left < group, left, group)),
            records.i.payload.image.eq(command.image), records.i.payload.offset.eq(offset),
            records.i.payload.region.eq(region), records.i.payload.first.eq(first),
            records.i.payload.records.eq(count), patches.i.payload.base.eq(command.image + offset),
            patches.i.payload["count"].eq(chunk), header.i.payload.eq(self.i.payload.image)]
        # Registered: they are looked at many cycles after a group has begun.
        is_last, emits = Signal(), Signal()
        m.d.sync += [left.eq(own.residents - done), is_last.eq(left == 0)]
        m.d.sync += emits.eq(command.regions.bit_select(region, 1) & ~ids_only)
        in_flight = self._add_reader(m, header=header, records=records, patches=patches, words=words,
                                     in_header=in_header)
        self._add_words(m, words=words, patches=patches, code=code, emits=emits, ids_only=ids_only, own=own)
        m.d.sync += [first.eq(0), count.eq(header.count), offset.eq(header.offset)]
        with m.Switch(region):
            with m.Case(number.CLUSTERS):
                m.d.sync += [first.eq(command.cluster), count.eq(1)]
            with m.Case(number.SUBSHELLS):
                m.d.sync += [first.eq(own.first_subshell), count.eq(own.subshells)]
            with m.Case(number.RESIDENTS):
                m.d.sync += [first.eq(own.first_resident), count.eq(own.residents)]
                with m.If(ids_only):
                    m.d.sync += [first.eq(own.first_resident + done), count.eq(chunk)]

        def follow(following):
            m.d.sync += region.eq(following)
            m.next = "Choose"

        with m.FSM():
            with m.State("Wait for a command"):
                m.d.comb += [header.i.valid.eq(self.i.valid), self.i.ready.eq(header.i.ready)]
                m.d.sync += [command.eq(self.i.payload), base.eq(self.i.payload.image), region.eq(number.CLUSTERS),
                             ids_only.eq(0), done.eq(0)]
                with m.If(self.i.valid & self.i.ready):
                    m.d.sync += code.eq(Fault.NONE)
                    m.next = "Check the header"
            with m.State("Check the header"):
                m.d.comb += [in_header.eq(1), header.o.ready.eq(1)]
                with m.If(header.o.valid):
                    m.d.sync += code.eq(header.o.payload)
                    m.next = "Find the cluster"
            with m.State("Find the cluster"):
                m.next = "Locate"
                with m.If(code != Fault.NONE):
                    m.next = "Answer"
                with m.Elif((command.regions & OWN) == 0):
                    follow(number(0))
                with m.Elif(command.cluster >= header.count):
                    m.d.sync += code.eq(Fault.POINTER)
                    m.next = "Answer"
            # The record of the cluster has been read before all else.
            with m.State("Choose"):
                m.next = "Locate"
                with m.If(region == len(REGIONS)):
                    m.next = "Answer"
                with m.Elif(~command.regions.bit_select(region, 1) | (region == number.CLUSTERS)):
                    follow(region + 1)
                with m.Elif(region == number.PATCHES):
                    m.d.sync += [region.eq(number.RESIDENTS), ids_only.eq(1)]
                    m.next = "Choose ids"
            with m.State("Choose ids"):
                m.next = "Locate"
            with m.State("Locate"):
                m.d.comb += [records.i.valid.eq(count != 0), words.start.eq(1), words.record.eq(0)]
                m.d.sync += base.eq(command.image + offset)
                with m.If(records.i.ready):
                    m.next = "Read"
                with m.If(count == 0):
                    follow(region + 1)
                    with m.If(ids_only):
                        m.d.sync += ids_only.eq(0)
                        follow(number(number.PATCHES.value + 1))
            with m.State("Read"), m.If(in_flight == 0):
                follow(region + 1)
                with m.If(region == number.CLUSTERS):
                    follow(number(0))
                with m.If(ids_only):
                    m.d.sync += [region.eq(number.PATCHES), ids_only.eq(0)]
                    m.next = "Choose patches"
                with m.If(code != Fault.NONE):
                    m.next = "Answer"
            with m.State("Choose patches"):
                m.next = "Locate patches"
            with m.State("Locate patches"):
                m.d.comb += [patches.i.valid.eq(1), words.start.eq(1), words.record.eq(done)]
                m.d.sync += [base.eq(patches.i.payload.base), done.eq(done + chunk)]
                m.next = "Read patches"
            with m.State("Read patches"), m.If(patches.i.ready & (in_flight == 0)):
                with m.If(is_last):
                    follow(number(number.PATCHES.value + 1))
                with m.Else():
                    m.d.sync += [region.eq(number.RESIDENTS), ids_only.eq(1)]
                    m.next = "Choose ids"
                with m.If(code != Fault.NONE):
                    m.next = "Answer"
            with m.State("Answer"):
                m.d.comb += self.o_done.valid.eq(1)
                with m.If(self.o_done.ready):
                    m.next = "Wait for a command"
        return m

    def _add_reader(self, m, *, header, records, patches, words, in_header):
        """Extents to the reader, its words to the header or to the records; the extents in flight."""
        m.submodules.reader = reader = WordReader(config=self._config)
        wiring.connect(m, reader.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, wiring.flipped(self.i_reply), reader.i_reply)
        # At most one of them is valid.
        for extents in (header.o_extent, records.o, patches.o):
            m.d.comb += extents.ready.eq(reader.i.ready)
            with m.If(extents.valid):
                m.d.comb += [reader.i.valid.eq(1), reader.i.payload.eq(extents.payload)]
        m.d.comb += [
            header.i_word.valid.eq(reader.o.valid & in_header), header.i_word.payload.eq(reader.o.payload),
            words.i.valid.eq(reader.o.valid & ~in_header), words.i.payload.eq(reader.o.payload),
            reader.o.ready.eq(words.i.ready | in_header)]
        # Those that the reader holds, and one for each word that the check holds.
        extents = max(2, self._config.memory.outstanding) + words.latency + 1
        in_flight = Signal(range(extents + 1))
        begins, patch_begins, ends = (records.i.valid & records.i.ready, patches.o.valid & patches.o.ready,
                                      words.o.valid & words.o.ready & words.o.payload.last)
        claim_steps(m, in_flight, up=begins + patch_begins, down=ends, most=extents)
        m.d.sync += in_flight.eq(in_flight + begins + patch_begins - ends)
        return in_flight

    def _add_words(self, m, *, words, patches, code, emits, ids_only, own):
        """Checked words leave, or give ids and the cluster's part of each region; the first fault is latched."""
        moves, item = words.o.valid & words.o.ready, words.o.payload.item
        good = (words.o.payload.fault == Fault.NONE) & (code == Fault.NONE)
        m.d.comb += [
            self.o.valid.eq(words.o.valid & emits & good), self.o.payload.eq(item),
            words.o.ready.eq(self.o.ready | ~self.o.valid), patches.i_id.valid.eq(moves & ids_only),
            patches.i_id.payload.index.eq(item.record), patches.i_id.payload.id.eq(item.data)]
        with m.If(moves & (code == Fault.NONE)):
            m.d.sync += code.eq(words.o.payload.fault)
        for part in PARTS:
            ((word, is_high),) = halves("clusters", part)
            with m.If(moves & (item.region == RegionNumber.CLUSTERS) & (item.word == word)):
                m.d.sync += own[part].eq(item.data[32:] if is_high else item.data[:32])

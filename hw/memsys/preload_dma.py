"""Preload DMA: the tables of a memory image, checked, word by word."""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Shape, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from golden.memory_map import ALIGNMENT, MAGIC, REGIONS, VERSION
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.fault import Fault
from hw.memsys.image_layout import HEADER_WORDS, RECORD_BYTES, RECORD_WORDS, RegionNumber
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.table_check import COUNT_BITS, TableCheck
from hw.memsys.word_reader import LENGTH_BITS, WordReader

__all__ = ["PreloadDma"]

# Of a patch's record the words that are more than padding.
PATCH_WORDS = 6
# Patches whose ids are read at once.
CHUNK_BITS = 4
# Regions that are written, and such as are read again.
PLACES = ("hits", "sums", "cells", "patch_lists", "patches")


class PreloadDma(wiring.Component):
    """Reads the header of an image, and of the regions that it is told all records, or those of one cluster.

    Of ``clusters``, ``subshells``, ``residents`` and ``patches`` these are the cluster's: its own record, its lists,
    and the geometry of its resident set, a patch for each local address.

    Everything is checked before it goes out: magic and version; that each region lies in the image, is aligned, and has
    as many records as it may; that there is a hit for each ray; and what `TableCheck` knows of records. With the first
    thing that is wrong the command ends, with a fault, and what has come of it before must not be used.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        ``image`` (its address, a multiple of 64), ``cluster``, ``regions`` (a bit for each of `RegionNumber`).
    o
        Words: ``region``, ``record`` (from 0 on), ``word`` (of the record), ``data``. Records of 4 bytes are words too,
        of patches there are 6 words each.
    o_done
        `MemoryFormats.fault`, one for each command. Where a region is wrong its address.
    o_request, i_reply
        `MainMemoryPort`'s ``i_read`` and ``o_read``.
    hits, sums, cells, patch_lists, patches, columns
        Of the image that was read last: ``address`` and ``count`` of what the machine writes and of what it reads
        again, and how many columns of rays there are.

    Timing
    ------
    Latency: ``5`` cycles from a reply to its word. One word per cycle within a region; stalls with ``o``. Between
    regions, and between every sixteen patches, memory is waited for once.

    Golden counterpart: `golden.memory_map`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, MemoryFormats(config)
        address = config.memory.address_bits
        place = StructLayout({"address": address, "count": COUNT_BITS})
        super().__init__({
            "i": In(stream.Signature(StructLayout({"image": address, "cluster": 16, "regions": len(REGIONS)}))),
            "o": Out(stream.Signature(StructLayout({"region": RegionNumber, "record": COUNT_BITS,
                                                    "word": range(max(RECORD_WORDS)), "data": 64}))),
            "o_done": Out(stream.Signature(self._formats.fault)),
            "o_request": Out(stream.Signature(self._formats.request(0))),
            "i_reply": In(stream.Signature(self._formats.reply(0))),
            **{name: Out(place) for name in PLACES}, "columns": Out(COUNT_BITS)})
        self._tag = StructLayout({"record": COUNT_BITS, "last": 1, "error": 1})
        self._check = TableCheck(tag=self._tag)
        self.latency = self._check.latency + 1

    def elaborate(self, platform):
        m = Module()
        self._add_registers(m)
        self._add_words(m)
        self._add_header(m)
        with m.FSM():
            self._add_checks(m)
            self._add_regions(m)
            self._add_patches(m)
        return m

    def _add_registers(self, m):
        """The command, the regions of its image, and what is being read."""
        address = self._config.memory.address_bits
        self._command = Signal.like(self.i.payload, reset_less=True)
        # By region, offset and records.
        place = StructLayout({"offset": address, "count": COUNT_BITS})
        m.submodules.places = places = Memory(shape=place, depth=1 << Shape.cast(RegionNumber).width, init=[],
                                              attrs={"ram_style": "distributed"})
        self._places, self._place, self._limits = (
            places.write_port(), places.read_port(domain="comb"), places.read_port(domain="comb"))
        self._region = Signal(RegionNumber)
        m.d.comb += self._place.addr.eq(self._region)
        # Of the region that is read: records from ``first`` on, and where the region is.
        self._first, self._records, self._base = Signal(COUNT_BITS), Signal(COUNT_BITS), Signal(address)
        self._in_header, self._emits, self._ids_only, self._own_known = (
            Signal(name=name) for name in ("in_header", "emits", "ids_only", "own_known"))
        self._own = Signal(StructLayout(dict.fromkeys(
            ("first_subshell", "subshells", "first_resident", "residents"), COUNT_BITS)))
        self._position = Signal(COUNT_BITS)
        self._size = Signal(64, reset_less=True)
        self._rows = Signal(COUNT_BITS, reset_less=True)
        # The first thing that went wrong.
        self._code = Signal(Fault)
        m.d.comb += [self.o_done.payload.code.eq(self._code), self.o_done.payload.address.eq(self._base)]

    def _fail(self, m, code):
        with m.If(self._code == Fault.NONE):
            m.d.sync += self._code.eq(code)

    def _add_words(self, m):
        """From the reader through the checks: out, and into the registers of what is the cluster's."""
        m.submodules.reader = self._reader = reader = WordReader(config=self._config)
        m.submodules.check = check = self._check
        wiring.connect(m, reader.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, wiring.flipped(self.i_reply), reader.i_reply)
        self._record, self._word = Signal(COUNT_BITS), Signal(range(max(RECORD_WORDS)))
        self._last_word = Signal.like(self._word)
        came = check.i.payload
        m.d.comb += [
            check.i.valid.eq(reader.o.valid & ~self._in_header), reader.o.ready.eq(check.i.ready | self._in_header),
            came.region.eq(self._region), came.word.eq(self._word), came.data.eq(reader.o.payload.data),
            came.tag.record.eq(self._record), came.tag.last.eq(reader.o.payload.last),
            came.tag.error.eq(reader.o.payload.error),
            self._limits.addr.eq(check.table), check.limit.eq(self._limits.data.count)]
        with m.If(check.i.valid & check.i.ready):
            m.d.sync += self._word.eq(self._word + 1)
            with m.If(self._word == self._last_word):
                m.d.sync += [self._word.eq(0), self._record.eq(self._record + 1)]

        # Else the first fault would decide in the same cycle whether the reader moves.
        m.submodules.checked = checked = SkidBuffer(check.o.payload.shape())
        wiring.connect(m, check.o, checked.i)
        out, word = checked.o, checked.o.payload
        wrong, failed, ends = word.bad | word.tag.error, self._code != Fault.NONE, Signal()
        m.submodules.ids = ids = Memory(shape=COUNT_BITS, depth=1 << CHUNK_BITS, init=[],
                                        attrs={"ram_style": "distributed"})
        self._ids, write = ids.read_port(domain="comb"), ids.write_port()
        goes = out.valid & out.ready
        m.d.comb += [
            self.o.valid.eq(out.valid & self._emits & ~wrong & ~failed),
            out.ready.eq(self.o.ready | ~self.o.valid), ends.eq(goes & word.tag.last),
            *(self.o.payload[name].eq(word[name]) for name in ("region", "word", "data")),
            self.o.payload.record.eq(word.tag.record),
            write.addr.eq(word.tag.record[:CHUNK_BITS]), write.data.eq(word.data[:COUNT_BITS]),
            write.en.eq(goes & self._ids_only)]
        with m.If(goes & wrong):
            self._fail(m, Mux(word.tag.error, Fault.READ_REPLY, Fault.POINTER))
        low, high, own = word.data[:32], word.data[32:], self._own
        with m.If(goes & (word.region == RegionNumber.CLUSTERS)), m.Switch(word.word):
            with m.Case(2):
                m.d.sync += own.first_subshell.eq(high)
            with m.Case(3):
                m.d.sync += [own.subshells.eq(low), own.first_resident.eq(high)]
            with m.Case(4):
                m.d.sync += own.residents.eq(low)
        # Stretches under way.
        self._pending = Signal(range(64))
        starts = reader.i.valid & reader.i.ready & ~self._in_header
        m.d.sync += self._pending.eq(self._pending + starts - ends)

    def _add_header(self, m):
        """The header's words; where the results are."""
        # In registers, as it comes through the reader's memory.
        reader, number = self._reader, Signal(range(HEADER_WORDS))
        word, goes = Signal(reader.o.payload.shape(), reset_less=True), Signal()
        m.d.sync += [word.eq(reader.o.payload), goes.eq(reader.o.valid & self._in_header)]
        offset, wide = Signal(self._config.memory.address_bits, reset_less=True), Signal()
        low, high = word.data[:32], word.data[32:]
        region = number[1:] - 1
        write = self._places
        m.d.comb += [write.addr.eq(region), write.data.offset.eq(offset), write.data.count.eq(low),
                     write.en.eq(goes & number[0] & (number != 1))]
        with m.If(goes):
            m.d.sync += number.eq(Mux(word.last, 0, number + 1))
            with m.If(word.error):
                self._fail(m, Fault.READ_REPLY)
            with m.Elif((number == 0) & ((low != MAGIC) | (high != VERSION))):
                self._fail(m, Fault.IMAGE)
            with m.Elif(number[0] & (number != 1) & (wide | (high != 0))):
                self._fail(m, Fault.REGION)
            with m.If(number == 1):
                m.d.sync += self._size.eq(word.data)
            with m.If(~number[0]):
                m.d.sync += [offset.eq(word.data),
                             wide.eq((word.data[len(offset):] != 0) | (word.data[:ALIGNMENT.bit_length() - 1] != 0))]
        for name in PLACES:
            taken = getattr(self, name)
            with m.If(write.en & (region == RegionNumber[name.upper()].value)):
                m.d.sync += [taken.address.eq(self._command.image + offset), taken.count.eq(low)]
        for name, taken in ("columns", self.columns), ("rows", self._rows):
            with m.If(write.en & (region == RegionNumber[name.upper()].value)):
                m.d.sync += taken.eq(low)

    def _add_checks(self, m):
        """Each region ends within the image: offset + count x size, bit by bit of the size; and it is not too long.

        Then hits = columns x rows, in the same way.
        """
        icu, ctu, reader = self._config.icu, self._config.ctu, self._reader
        lines, patches = 1 << icu.side_bits, 1 << icu.patch_bits
        # Shells are counted from shell 2 on.
        most = {"cell_grid": 1, "frustum": 1, "cells": self._config.memsys.scene_cells, "patches": patches,
                "residence": patches, "sums": patches + 1, "columns": lines, "rows": lines,
                "near_cells": 1 << ctu.near_cell_bits, "shells": (1 << ctu.shell_bits) - 2,
                "grid_rows": 1 << ctu.grid_row_bits, "grid_columns": 1 << ctu.grid_column_bits}
        most = Array(Const(most.get(region.name, (1 << COUNT_BITS) - 1), COUNT_BITS) for region in REGIONS)
        sizes = Array(Const(size, 8) for size in RECORD_BYTES)
        end = Signal(self._config.memory.address_bits + 9, reset_less=True)
        factor_bits = max(8, icu.side_bits + 1)
        term, size, rays = Signal(COUNT_BITS + 8, reset_less=True), Signal(factor_bits, reset_less=True), Signal()
        region, place = self._region, self._place.data
        # What is compared comes from registers: the region's records, and how many there may be.
        self._count, limit = Signal(COUNT_BITS, reset_less=True), Signal(COUNT_BITS, reset_less=True)
        with m.State("Wait for a command"):
            m.d.comb += self.i.ready.eq(1)
            with m.If(self.i.valid):
                m.d.sync += [self._command.eq(self.i.payload), self._base.eq(self.i.payload.image), region.eq(0),
                             self._code.eq(Fault.NONE), self._own_known.eq(0), self._ids_only.eq(0),
                             self._in_header.eq(1)]
                m.next = "Ask for the header"
        with m.State("Ask for the header"):
            m.d.comb += [reader.i.valid.eq(1), reader.i.payload.address.eq(self._base),
                         reader.i.payload.length.eq(HEADER_WORDS - 1)]
            with m.If(reader.i.ready):
                m.next = "Read the header"
        with m.State("Read the header"), m.If(reader.o.valid & reader.o.payload.last):
            m.d.sync += self._in_header.eq(0)
            m.next = "Take a region"
        with m.State("Take a region"):
            m.d.sync += [end.eq(place.offset), term.eq(place.count), size.eq(sizes[region]), rays.eq(0),
                         self._count.eq(place.count), limit.eq(most[region])]
            m.next = "Add its size"
            with m.If(self._code != Fault.NONE):
                m.next = "Answer"
        with m.State("Add its size"):
            m.d.sync += [term.eq(term << 1), size.eq(size >> 1)]
            with m.If(size[0]):
                m.d.sync += end.eq(end + term)
            with m.If(size == 0):
                m.next = "Compare its end"
                with m.If(rays):
                    m.next = "Compare the rays"
        with m.State("Compare its end"):
            m.d.sync += region.eq(region + 1)
            m.next = "Take a region"
            wrong = (end > self._size) | (self._count > limit)
            same = (region == RegionNumber.RESIDENCE.value) & (self._count != self.patches.count)
            more = (region == RegionNumber.SUMS.value) & (self._count != self.patches.count + 1)
            with m.If(wrong | same | more):
                self._fail(m, Fault.REGION)
            with m.If(region == len(REGIONS) - 1):
                m.next = "Count the rays"
        with m.State("Count the rays"):
            m.d.sync += [end.eq(0), term.eq(self.columns), size.eq(self._rows), rays.eq(1)]
            m.next = "Add its size"
            with m.If(self._code != Fault.NONE):
                m.next = "Answer"
        with m.State("Compare the rays"):
            with m.If(end != self.hits.count):
                self._fail(m, Fault.REGION)
            m.d.sync += region.eq(RegionNumber.CLUSTERS.value)
            m.next = "Count the clusters"

    def _add_regions(self, m):
        """Region after region, those that have been asked for; the cluster's record before all."""
        region, place, command = self._region, self._place.data, self._command
        number, reader, own = RegionNumber, self._reader, self._own
        needs_own = sum(1 << number[name].value for name in ("CLUSTERS", "SUBSHELLS", "RESIDENTS", "PATCHES"))
        with m.State("Count the clusters"):
            m.d.sync += self._count.eq(place.count)
            m.next = "Find the cluster"
        with m.State("Find the cluster"):
            m.d.sync += [self._first.eq(command.cluster), self._records.eq(1)]
            m.next = "Locate"
            with m.If((command.regions & needs_own) == 0):
                m.d.sync += region.eq(0)
                m.next = "Choose"
            with m.Elif(command.cluster >= self._count):
                self._fail(m, Fault.POINTER)
                m.next = "Answer"
            with m.If(self._code != Fault.NONE):
                m.next = "Answer"
        with m.State("Choose"):
            m.d.sync += [self._first.eq(0), self._records.eq(place.count)]
            m.next = "Locate"
            with m.Switch(self._region):
                with m.Case(number.SUBSHELLS):
                    m.d.sync += [self._first.eq(own.first_subshell), self._records.eq(own.subshells)]
                with m.Case(number.RESIDENTS):
                    m.d.sync += [self._first.eq(own.first_resident), self._records.eq(own.residents)]
            with m.If(~command.regions.bit_select(region, 1) | (region == number.CLUSTERS.value)):
                m.d.sync += region.eq(region + 1)
                m.next = "Choose"
            with m.Elif(region == number.PATCHES.value):
                m.d.sync += self._position.eq(0)
                m.next = "Take ids"
            with m.If(region == number.HITS.value):
                m.next = "Answer"
        address, length = Signal(self._config.memory.address_bits), Signal(LENGTH_BITS)
        # Only of these regions less than everything is read.
        shift = {number.CLUSTERS: 6, number.SUBSHELLS: 3, number.RESIDENTS: 2}
        less, ahead = Signal(COUNT_BITS), Signal(COUNT_BITS + max(shift.values()))
        part, rest = Signal.like(length), Signal.like(length)
        with m.State("Locate"):
            m.d.sync += [self._base.eq(command.image + place.offset), less.eq(self._records - 1)]
            m.next = "Count"
            with m.If(self._records == 0):
                m.d.sync += region.eq(region + 1)
                m.next = "Choose"
        with m.State("Count"):
            m.d.sync += [ahead.eq(0), rest.eq(0), self._record.eq(0), self._word.eq(0),
                         self._emits.eq(command.regions.bit_select(region, 1) & ~self._ids_only)]
            with m.Switch(self._region):
                for k, words in enumerate(RECORD_WORDS):
                    with m.Case(number(k)):
                        m.d.sync += self._last_word.eq(words - 1)
                        # Records times words, but one: words are one or two powers of two.
                        low = (words & -words).bit_length() - 1
                        high = words >> low + 1
                        m.d.sync += part.eq(Cat(Const((1 << low) - 1, low), less))
                        if high:
                            m.d.sync += rest.eq(self._records << words.bit_length() - 1)
                        if number(k) in shift:
                            m.d.sync += ahead.eq(self._first << shift[number(k)])
            m.next = "Add"
        with m.State("Add"):
            m.d.sync += [address.eq(self._base + ahead), length.eq(part + rest)]
            m.next = "Ask"
        narrow = Signal()
        m.d.comb += narrow.eq(Array(size == 4 for size in RECORD_BYTES)[region])
        with m.State("Ask"):
            m.d.comb += [reader.i.valid.eq(1), reader.i.payload.address.eq(address),
                         reader.i.payload.length.eq(length), reader.i.payload.narrow.eq(narrow)]
            with m.If(reader.i.ready):
                m.next = "Wait"
        with m.State("Wait"), m.If(self._pending == 0):
            m.d.sync += [region.eq(region + 1), self._own_known.eq(1)]
            m.next = "Choose"
            with m.If(~self._own_known & (region == number.CLUSTERS.value)):
                m.d.sync += region.eq(0)
            with m.If(self._ids_only):
                m.d.sync += region.eq(number.PATCHES.value)
                m.next = "Locate patches"
            with m.If(self._code != Fault.NONE):
                m.next = "Answer"
        with m.State("Answer"):
            m.d.comb += self.o_done.valid.eq(1)
            with m.If(self.o_done.ready):
                m.next = "Wait for a command"

    def _add_patches(self, m):
        """Patches of the resident set: some ids, then the geometry of each of them."""
        region, place, own, reader = self._region, self._place.data, self._own, self._reader
        number, at, address = Signal(CHUNK_BITS + 1), self._position, Signal(self._config.memory.address_bits)
        left = Signal(COUNT_BITS)
        m.d.comb += [left.eq(own.residents - at), self._ids.addr.eq(number)]
        with m.State("Take ids"):
            m.d.sync += [region.eq(RegionNumber.RESIDENTS.value), self._ids_only.eq(1),
                         self._first.eq(own.first_resident + at),
                         self._records.eq(Mux(left >> CHUNK_BITS == 0, left[:CHUNK_BITS], 1 << CHUNK_BITS))]
            m.next = "Locate"
            with m.If(left == 0):
                m.d.sync += [region.eq(RegionNumber.PATCHES.value + 1), self._ids_only.eq(0)]
                m.next = "Choose"
        with m.State("Locate patches"):
            m.d.sync += [self._ids_only.eq(0), self._base.eq(self._command.image + place.offset), number.eq(0),
                         self._emits.eq(1), self._record.eq(at), self._word.eq(0),
                         self._last_word.eq(PATCH_WORDS - 1)]
            m.next = "Locate a patch"
        with m.State("Locate a patch"):
            m.d.sync += address.eq(self._base + (self._ids.data << 6))
            m.next = "Ask for a patch"
        with m.State("Ask for a patch"):
            m.d.comb += [reader.i.valid.eq(1), reader.i.payload.address.eq(address),
                         reader.i.payload.length.eq(PATCH_WORDS - 1)]
            with m.If(reader.i.ready):
                m.d.sync += number.eq(number + 1)
                m.next = "Locate a patch"
                with m.If((number + 1 == self._records) | (self._code != Fault.NONE)):
                    m.next = "Wait for the patches"
        with m.State("Wait for the patches"), m.If(self._pending == 0):
            m.d.sync += at.eq(at + self._records)
            m.next = "Take ids"
            with m.If(self._code != Fault.NONE):
                m.next = "Answer"

"""Image header: where the regions of a memory image are, checked."""

from amaranth.hdl import Array, Const, Module, Mux, Shape, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memory_map import ALIGNMENT, MAGIC, REGIONS, VERSION
from hw.memsys.load.image_layout import COUNT_BITS, HEADER_WORDS, RECORD_BYTES, RegionNumber
from hw.memsys.load.serial_product import SerialProduct
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["TABLES", "ImageHeader"]

# Regions whose address or number of records is needed while sections are cast.
TABLES = ("cells", "patch_lists", "patches", "shells")


class ImageHeader(wiring.Component):
    """Reads the header of an image, keeps the offset and the records of each region, and checks them.

    Magic and version are right. Each region is aligned, ends within the image, and has as many records as it may; the
    image ends within memory. The grid of cells is one record, and each patch has a residence.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of an address
        Of an image, a multiple of 64. Accepted when the previous header has been answered.
    o : Out, stream of `Fault`
        The first fault of the header, or ``NONE``.
    o_extent : Out, stream of `MemoryFormats.read_extent`
        The header, for `WordReader`.
    i_word : In, stream of `MemoryFormats.word`
        Its words. Always ready.
    region, table : In(RegionNumber)
        Two regions that are looked up.
    offset : Out(address_bits)
        First byte of ``region`` in the image, in the same cycle. Undefined until ``o``.
    count, table_count : Out(COUNT_BITS)
        Records of ``region`` and of ``table``, likewise.
    cells, patch_lists, patches, shells : Out(MemoryFormats.table)
        Of the image that was read last.

    Timing
    ------
    Latency: some hundred cycles after the last word. One header in flight.

    Golden counterpart: `golden.engine.memory_map.from_bytes`.
    """

    def __init__(self, *, config: Config):
        self._config, formats = config, MemoryFormats(config)
        address = config.memory.address_bits
        super().__init__({
            "i": In(stream.Signature(address)), "o": Out(stream.Signature(Fault)),
            "o_extent": Out(stream.Signature(formats.read_extent)),
            "i_word": In(stream.Signature(formats.word, always_ready=True)),
            "region": In(RegionNumber), "table": In(RegionNumber), "offset": Out(address), "count": Out(COUNT_BITS),
            "table_count": Out(COUNT_BITS), **{name: Out(formats.table) for name in TABLES}})

    def _limits(self):
        """By region, the largest number of records. Shells are counted from shell 2 on."""
        icu, ctu = self._config.icu, self._config.ctu
        lines, patches = 1 << icu.side_bits, 1 << icu.patch_bits
        limits = {"cells": self._config.memsys.scene_cells, "patches": patches, "residence": patches,
                  "columns": lines, "rows": lines, "shells": (1 << ctu.shell_bits) - 2,
                  "grid_rows": 1 << ctu.grid_row_bits, "grid_columns": 1 << ctu.grid_column_bits}
        return [limits.get(region.name, (1 << COUNT_BITS) - 1) for region in REGIONS]

    def elaborate(self, platform):
        m = Module()
        address_bits = self._config.memory.address_bits
        image, code = Signal(address_bits, reset_less=True), Signal(Fault)
        checked = Signal(RegionNumber)
        # By region, in one memory; the address comes from the check until the header has been answered.
        entry = StructLayout({"offset": address_bits, "count": COUNT_BITS})
        m.submodules.entries = entries = Memory(shape=entry, depth=1 << Shape.cast(RegionNumber).width, init=[],
                                                attrs={"ram_style": "distributed"})
        write, read, read_table = entries.write_port(), *(entries.read_port(domain="comb") for _ in range(2))
        checks = Signal()
        m.d.comb += [
            read.addr.eq(Mux(checks, checked, self.region)), read_table.addr.eq(self.table),
            self.offset.eq(read.data.offset), self.count.eq(read.data.count),
            self.table_count.eq(read_table.data.count), self.o.payload.eq(code)]

        def fail(fault):
            with m.If(code == Fault.NONE):
                m.d.sync += code.eq(fault)

        size, past_memory = self._add_words(m, write, image, fail)
        most = Array(Const(value, COUNT_BITS) for value in self._limits())
        bytes_of = Array(Const(value, 8) for value in RECORD_BYTES)
        # The end of a region.
        m.submodules.product = product = SerialProduct(a=COUNT_BITS, b=8, addend=address_bits)
        count, limit = Signal(COUNT_BITS, reset_less=True), Signal(COUNT_BITS, reset_less=True)
        m.d.comb += [checks.eq(1), self.o_extent.payload.address.eq(image),
                     self.o_extent.payload.length.eq(HEADER_WORDS - 1)]
        with m.FSM():
            with m.State("Wait for an image"):
                m.d.comb += [self.i.ready.eq(1), checks.eq(0)]
                m.d.sync += [image.eq(self.i.payload), checked.eq(0)]
                with m.If(self.i.valid):
                    m.d.sync += code.eq(Fault.NONE)
                    m.next = "Request the header"
            with m.State("Request the header"):
                m.d.comb += self.o_extent.valid.eq(1)
                with m.If(self.o_extent.ready):
                    m.next = "Read the header"
            with m.State("Read the header"), m.If(self.i_word.valid & self.i_word.payload.last):
                m.next = "Store the last word"
            with m.State("Store the last word"):
                m.next = "Find the end of a region"
            with m.State("Find the end of a region"):
                m.d.comb += [
                    product.i.valid.eq(code == Fault.NONE), product.i.payload.a.eq(read.data.count),
                    product.i.payload.b.eq(bytes_of[checked]), product.i.payload.addend.eq(read.data.offset)]
                m.d.sync += [count.eq(read.data.count), limit.eq(most[checked])]
                m.next = "Check a region"
                with m.If(code != Fault.NONE):
                    m.next = "Answer"
            with m.State("Check a region"):
                m.d.comb += product.o.ready.eq(1)
                wrong = (product.o.payload > size) | (count > limit) | past_memory
                same = (checked == RegionNumber.RESIDENCE) & (count != self.patches.count)
                alone = (checked == RegionNumber.CELL_GRID) & (count != 1)
                with m.If(product.o.valid):
                    with m.If(wrong | same | alone):
                        fail(Fault.REGION)
                    m.d.sync += checked.eq(checked + 1)
                    m.next = "Find the end of a region"
                    with m.If(checked == len(REGIONS) - 1):
                        m.next = "Answer"
            with m.State("Answer"):
                m.d.comb += [self.o.valid.eq(1), checks.eq(0)]
                with m.If(self.o.ready):
                    m.next = "Wait for an image"
        return m

    def _add_words(self, m, write, image, fail):
        """Words to the memory of regions; the size of the image, and whether it ends past memory."""
        # Registered: the data come through the memory of the reader.
        word, comes, number = Signal.like(self.i_word.payload, reset_less=True), Signal(), Signal(range(HEADER_WORDS))
        m.d.sync += [word.eq(self.i_word.payload), comes.eq(self.i_word.valid)]
        address_bits = len(image)
        offset, wide = Signal(address_bits, reset_less=True), Signal()
        size = Signal(64, reset_less=True)
        end, past_memory = Signal(address_bits + 1, reset_less=True), Signal()
        low, high, region = word.data[:32], word.data[32:], number[1:] - 1
        m.d.comb += [write.addr.eq(region), write.data.offset.eq(offset), write.data.count.eq(low),
                     write.en.eq(comes & number[0] & (number != 1)),
                     past_memory.eq(size[address_bits:].any() | (end > 1 << address_bits))]
        m.d.sync += end.eq(image + size[:address_bits])
        with m.If(comes):
            m.d.sync += number.eq(Mux(word.last, 0, number + 1))
            with m.If(word.error):
                fail(Fault.READ_REPLY)
            with m.Elif((number == 0) & ((low != MAGIC) | (high != VERSION))):
                fail(Fault.IMAGE)
            with m.Elif(number[0] & (number != 1) & (wide | (high != 0))):
                fail(Fault.REGION)
            with m.If(number == 1):
                m.d.sync += size.eq(word.data)
            with m.If(~number[0]):
                m.d.sync += [offset.eq(word.data),
                             wide.eq((word.data[len(offset):] != 0) | (word.data[:ALIGNMENT.bit_length() - 1] != 0))]
        for name in TABLES:
            table = getattr(self, name)
            with m.If(write.en & (region == RegionNumber[name.upper()].value)):
                m.d.sync += [table.address.eq(image + offset), table.count.eq(low)]
        return size, past_memory

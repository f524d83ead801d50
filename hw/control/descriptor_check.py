"""Descriptor check: the rules that a descriptor must keep, word by word."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.descriptor import ANY_CLUSTER, NEAR_ALIGNMENT, VERSION
from golden.engine.memory_map import ALIGNMENT
from hw.control.job_formats import DESCRIPTOR_WORDS, WORD_BITS, Bundle, JobFormats, Kind, byte_of, elements
from hw.memsys.load.serial_product import SerialProduct
from hw.registers.error_code import ErrorCode

__all__ = ["DescriptorCheck"]


class DescriptorCheck(wiring.Component):
    """Compares the words of a descriptor with the rules of `golden.engine.jobs.descriptor.RULES`.

    The refusal is that of the first field in the order of the bytes that breaks a rule. An address with more bits than
    those of memory breaks the rule of its alignment too.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``index``, ``data``
        Words of descriptors, all of them in their order. Always ready; the first one begins another descriptor.
    refusal : Out(JobFormats.refusal)
        Why the descriptor is refused, and the first byte of the field; code 0: it is not.
    known : Out(1)
        The refusal is that of all words.

    Timing
    ------
    Latency: ``1`` cycle from a word to its refusal; from the fifth word to that of a section with too many tiles
    ``4 + bits(tiles_down)``. ``known`` is 0 until both have passed.

    Golden counterpart: `golden.engine.jobs.descriptor.check_descriptor`.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, self._formats = config, JobFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"index": range(DESCRIPTOR_WORDS), "data": WORD_BITS}),
                                     always_ready=True)),
            "refusal": Out(self._formats.refusal), "known": Out(1)})

    def elaborate(self, platform):
        m = Module()
        index, data = self.i.payload.index, self.i.payload.data
        icu, ctu, clusters = self._config.icu, self._config.ctu, self._config.noc.clusters
        width, side = self._config.memory.address_bits, 1 << self._config.icu.side_bits

        def field(name):
            (word, bits), = elements(name)
            return word, data[bits]

        def misaligned(address, multiple):
            return (address[:multiple.bit_length() - 1] != 0) | address[width:].any()

        def is_wrong_bundle(value):
            wrong = (value > (Bundle.SHADOW if icu.shadow_bits else Bundle.SCREEN)) | (
                has_rays & (value != Bundle.SHADOW))
            return wrong | (has_results & (value == Bundle.SHADOW)) if icu.shadow_bits else wrong

        is_section, is_kind, has_rays = (Signal(name=name) for name in ("is_section", "is_kind", "has_rays"))
        has_results = Signal()
        is_load = field("kind")[1] == Kind.LOAD
        first, end = ([Signal(16, name=f"{bound}_{axis}") for axis in ("column", "row")] for bound in ("first", "end"))
        # By field: its word, and whether it breaks its rule; only in descriptors of sections or in all.
        rules = {}
        for name, is_wrong, everywhere in (
                ("version", lambda value: value != VERSION, True), ("kind", lambda value: value > Kind.LOAD, True),
                ("hit_format", lambda value: ~value.matches(*self._formats.hit_formats), False),
                ("sums", lambda value: value > self._formats.sums, False),
                ("context", lambda value: value != 0, True),
                ("cluster", lambda value: ((value >= clusters) | (is_load & (value != 0))) & (value != ANY_CLUSTER),
                 True),
                ("hits", lambda value: misaligned(value, ALIGNMENT), True),
                ("sums_address", lambda value: misaligned(value, ALIGNMENT), False),
                ("near_cells", lambda value: misaligned(value, NEAR_ALIGNMENT), False),
                ("near_count", lambda value: value > 1 << ctu.near_cell_bits, False),
                ("last_shell", lambda value: (value == 0) | (value >> ctu.shell_bits != 0), False),
                ("ray_count", lambda value: value > icu.listed_rays, True),
                ("reserved", lambda value: value != 0, True),
                ("bundle", is_wrong_bundle, False),
                ("columns", lambda value: value > side, False), ("rows", lambda value: value > side, False)):
            word, value = field(name)
            rules[name] = word, is_wrong(value), everywhere
        broken = {name: Signal(name=f"breaks_{name}") for name in rules}
        section_word, frustum_word = field("first_column")[0], field("columns")[0]
        outside, too_large = Signal(), Signal()
        with m.If(self.i.valid):
            with m.If(index == 0):
                kind = field("kind")[1]
                m.d.sync += [is_section.eq(kind == Kind.FRUSTUM), is_kind.eq(kind <= Kind.LOAD), outside.eq(0)]
            for name, (word, is_wrong, _) in rules.items():
                with m.If(index == word):
                    m.d.sync += broken[name].eq(is_wrong)
                with m.Elif(index == 0):
                    m.d.sync += broken[name].eq(0)
            if icu.shadow_bits:
                (count_word, count), (word, hit_format), (_, sums) = map(field, ("ray_count", "hit_format", "sums"))
                with m.If(index == count_word):
                    m.d.sync += has_rays.eq(count != 0)
                with m.If(index == word):
                    m.d.sync += has_results.eq((hit_format != 0) | (sums != 0))
            with m.If(index == section_word):
                for bound, signals in ("first", first), ("end", end):
                    m.d.sync += [signal.eq(field(f"{bound}_{axis}")[1])
                                 for axis, signal in zip(("column", "row"), signals, strict=True)]
            with m.If(index == frustum_word):
                m.d.sync += outside.eq(
                    (first[0] >= end[0]) | (first[1] >= end[1]) | (end[0] > field("columns")[1])
                    | (end[1] > field("rows")[1]) | (end[0] > side) | (end[1] > side))

        # Tiles of the section, while the other words arrive.
        bits = icu.side_bits + 1 - icu.tile_bits
        m.submodules.tiles = tiles = SerialProduct(a=bits, b=bits)
        across, down = (Signal(bits, name=name) for name in ("across", "down"))
        for count, low, high in zip((across, down), first, end, strict=True):
            m.d.sync += count.eq(((high - low)[:icu.side_bits + 1] + (1 << icu.tile_bits) - 1) >> icu.tile_bits)
        steps, multiplied = Signal(2), Signal()
        m.d.sync += steps.eq((steps << 1) | (self.i.valid & (index == section_word)))
        m.d.comb += [tiles.i.valid.eq(steps[1]), tiles.i.payload.a.eq(across), tiles.i.payload.b.eq(down),
                     tiles.o.ready.eq(1)]
        with m.If(tiles.o.valid):
            m.d.sync += [too_large.eq(tiles.o.payload > icu.rays >> 2 * icu.tile_bits), multiplied.eq(1)]
        complete = Signal()
        with m.If(self.i.valid):
            m.d.sync += complete.eq(index == DESCRIPTOR_WORDS - 1)
            with m.If(index == 0):
                m.d.sync += multiplied.eq(0)
        m.d.comb += self.known.eq(complete & multiplied)

        # The first field decides; of an unknown kind only the first two do.
        wrongs = [(byte_of(name), broken[name] & (everywhere & is_kind | is_section)
                   if name not in ("version", "kind") else broken[name], ErrorCode.DESCRIPTOR)
                  for name, (_, _, everywhere) in rules.items()]
        wrongs.append((byte_of("first_column"), (outside | too_large) & is_section, ErrorCode.SECTION))
        for byte, is_wrong, code in sorted(wrongs, key=lambda one: -one[0]):
            with m.If(is_wrong):
                m.d.comb += [self.refusal.code.eq(code), self.refusal.number.eq(byte)]
        return m

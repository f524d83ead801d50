"""Record extent: the words of some records of a region."""

from amaranth.hdl import Array, Cat, Const
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.pipeline import Pipeline
from hw.memsys.load.image_layout import COUNT_BITS, RECORD_BYTES, RECORD_WORDS, WORD_BYTES, RegionNumber
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["RecordExtent"]

# Regions of which less than all records are read; their records are powers of two of bytes.
PARTIAL = (RegionNumber.CLUSTERS, RegionNumber.SUBSHELLS, RegionNumber.RESIDENTS)


class RecordExtent(wiring.Component):
    """``address = image + offset + bytes first``, ``length = words records - 1``.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``image``, ``offset``, ``region``, ``first``, ``records``
        The region begins at ``image + offset``. ``first`` is 0 except of clusters, subshells and residents; at least
        one record.
    o : Out, stream of `MemoryFormats.read_extent`
        For `WordReader`.

    Timing
    ------
    Latency: ``3`` cycles. One extent per cycle; stalls while the extent at the end waits.

    Golden counterpart: `golden.engine.memory_map.layout.REGIONS`.
    """

    def __init__(self, *, config: Config):
        address = config.memory.address_bits
        extent = MemoryFormats(config).read_extent
        super().__init__({
            "i": In(stream.Signature(StructLayout({"image": address, "offset": address, "region": RegionNumber,
                                                   "first": COUNT_BITS, "records": COUNT_BITS}))),
            "o": Out(stream.Signature(extent))})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        image, offset, region, first, records = (pipeline.input(self.i.payload[name]) for name in (
            "image", "offset", "region", "first", "records"))
        base = pipeline.register(lambda image, offset: image + offset, image, offset)
        after_first = pipeline.register(lambda records: (records - 1)[:COUNT_BITS], records)
        ahead = pipeline.register(lambda region, first: _choose(region, [
            first << size.bit_length() - 1 if RegionNumber(k) in PARTIAL else Const(0)
            for k, size in enumerate(RECORD_BYTES)]), region, first, registers=2)
        # Words of a record are one power of two or the sum of two.
        low, high = pipeline.register(lambda region, records, after_first: (
            _choose(region, [Cat(Const((1 << _low(words)) - 1, _low(words)), after_first) for words in RECORD_WORDS]),
            _choose(region, [records << words.bit_length() - 1 if words >> _low(words) + 1 else Const(0)
                             for words in RECORD_WORDS])), region, records, after_first)
        pipeline.output(self.o.payload.address, pipeline.register(lambda base, ahead: base + ahead, base, ahead))
        pipeline.output(self.o.payload.length, pipeline.register(lambda low, high: low + high, low, high))
        pipeline.output(self.o.payload.narrow, pipeline.register(lambda region: Array(
            Const(size < WORD_BYTES, 1) for size in RECORD_BYTES)[region], region))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()


def _low(words):
    """The index of the lowest 1."""
    return (words & -words).bit_length() - 1


def _choose(region, values):
    return Array(values)[region]

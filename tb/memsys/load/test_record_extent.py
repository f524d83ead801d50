from random import Random

from golden.engine.memory_map import REGIONS
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.load.record_extent import RecordExtent
from hw.memsys.port.memory_formats import LENGTH_BITS
from tb.lib.bench import Bench, Vectors

# Of these less than all records are read.
PARTIAL = (RegionNumber.CLUSTERS, RegionNumber.SUBSHELLS, RegionNumber.RESIDENTS)


class TestRecordExtent(Bench):
    component, variants = RecordExtent, ({},)

    def vectors(self, config):
        """Of each region one record, two, all that can be, and several; addresses that wrap."""
        draw, bits, items = Random(2), config.memory.address_bits, []
        for region in list(RegionNumber) * 3:
            most = min((1 << 32) - 1, (1 << LENGTH_BITS) // -(-REGIONS[region.value].dtype.itemsize // 8))
            items += [{"image": draw.getrandbits(bits), "offset": draw.getrandbits(bits), "region": region.value,
                       "first": draw.getrandbits(32) if region in PARTIAL else 0, "records": records}
                      for records in (1, 2, most, draw.randint(1, most))]
        return Vectors(inputs={"i": items}, expected={"o": [extent(item, 2 << bits) for item in items]})


def extent(item, addresses):
    """Bytes and words as numpy has them of the region's records."""
    size = REGIONS[item["region"]].dtype.itemsize
    return {"address": (item["image"] + item["offset"] + size * item["first"]) % addresses,
            "length": -(-size // 8) * item["records"] - 1, "narrow": int(size < 8)}

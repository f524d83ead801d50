import numpy as np

from golden.engine.config import PRESETS
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.position_search import PositionSearch
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Elastic
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
FORMATS = CtuFormats(CONFIG)
ENTRIES, SEARCHES = 120, 80
SPREAD = 900
# Of the bounds.
HIGHEST = (1 << FORMATS.position_bound.width - 1) - 1


def searches(random, positions):
    """Parts of the table and bounds: random ones, one entry, all of it; on positions, and beyond all of them."""
    for number in range(SEARCHES):
        first = int(random.integers(ENTRIES))
        count = 1 if number % 7 == 3 else int(random.integers(1, ENTRIES - first, endpoint=True))
        if number % 7 == 5:
            first, count = 0, ENTRIES
        low, end = (int(value) for value in random.integers(-2 * SPREAD, 2 * SPREAD, 2))
        if number % 3 == 1:
            low, end = int(positions[first]), int(positions[first + count - 1]) + number % 2
        yield {"first": first, "count": count, "low": low, "end": end}


def counted(found, search, part):
    """How many positions of a part are less than a bound; the least and the most bound with as many."""
    bounds, count = np.concatenate([[-HIGHEST - 2], part, [HIGHEST]]), int((part < search[found]).sum())
    return {"count": count, "least": int(bounds[count]) + 1, "most": int(bounds[count + 1])}


class TestPositionSearch(Bench):
    component, arguments = PositionSearch, {"formats": FORMATS, "address": FORMATS.grid_row_address}
    variants, splits = ({},), False

    def vectors(self, config):
        random = np.random.default_rng(1)
        positions = np.sort(random.integers(-SPREAD, SPREAD, ENTRIES))
        positions[ENTRIES // 2:ENTRIES // 2 + 9] = positions[ENTRIES // 2]
        given = list(searches(random, positions))
        parts = [positions[search["first"]:search["first"] + search["count"]] for search in given]
        return Vectors(
            first={"i_write": [{"address": address, "position": position}
                               for address, position in enumerate(positions.tolist())]},
            inputs={"i": given}, expected={"o": [{name: counted(name, search, part) for name in ("low", "end")}
                                                 for search, part in zip(given, parts, strict=True)]})

    def latency(self, component, config):
        """The longest one."""
        return documented_latency(PositionSearch, config, count=ENTRIES)

    def stages(self, component, config):
        return [Elastic((documented_latency(PositionSearch, config, count=search["count"])
                         for search in self.now.inputs["i"]), 1)]

from hw.formats import VERTICES
from hw.memsys.patches.patch_merge import PatchMerge
from tb.lib.bench import Bench
from tb.lib.grants import LongestWaiting

COUNT = 3


class TestPatchMerge(Bench):
    component, arguments, variants, span = PatchMerge, {"count": COUNT}, ({},), 300

    def model(self, config):
        """Whoever is granted has the output to the end of its patch; a source then loses a cycle to its next patch."""
        rule, chosen, index = LongestWaiting(), None, 0
        given = yield
        while True:
            offers = {k: item for k in range(COUNT) if (item := getattr(given, f"i__{k}")) is not None}
            vertex, requests = offers.get(chosen), [k for k in offers if k != chosen]
            moves, oldest = vertex is not None and given.o, rule.grant(requests, requests)
            ends = moves and index == VERTICES - 1
            outputs = {"o": vertex, "left": 1 << chosen if ends else 0,
                       **{f"i__{k}": k == chosen and given.o for k in range(COUNT)}}
            index = (index + moves) % VERTICES
            if chosen is None or ends:
                chosen = oldest
                if oldest is not None:
                    rule.accept(oldest)
            given = yield outputs

import pytest

from golden.engine.config import PRESETS
from hw.memsys.bus.local_bus import LocalBus
from tb.lib.bench import Bench
from tb.lib.grants import LongestWaiting

CLUSTERS = 3


class TestLocalBus(Bench):
    component, arguments, variants, changes = LocalBus, {"clusters": CLUSTERS}, ({},), {"noc.columns": 3}

    def model(self, config):
        """Each way an arbiter's register; behind that of requests a second one while the memory does not accept."""
        requests, replies, request, kept, beat = LongestWaiting(), LongestWaiting(), None, None, None
        given = yield
        while True:
            wants, answers = ([k for k in range(count) if getattr(given, f"{name}__{k}") is not None]
                              for name, count in (("i_request", CLUSTERS), ("i_reply", 2)))
            granted, answered = requests.grant(wants, wants), replies.grant(answers, answers)
            offered, advances = kept or request, request is None or kept is None
            outputs = {
                "o_request": offered, **{f"i_request__{k}": advances and k == granted for k in range(CLUSTERS)},
                **{f"i_reply__{k}": k == answered for k in range(2)},
                **{f"o_reply__{k}": beat if beat and beat["cluster"] == k else None for k in range(CLUSTERS)}}
            kept = offered if offered and not given.o_request else None
            if advances:
                request = None
                if wants:
                    requests.accept(granted)
                    request = {"source": granted, "item": getattr(given, f"i_request__{granted}")}
            beat = None
            if answers:
                replies.accept(answered)
                beat = getattr(given, f"i_reply__{answered}")
            given = yield outputs


def test_clusters_are_those_of_the_network():
    with pytest.raises(ValueError, match=r"^Clusters must be from 1 to 2, not 3$"):
        LocalBus(config=PRESETS["tiny"], clusters=3)

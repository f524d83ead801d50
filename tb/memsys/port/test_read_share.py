import pytest

from golden.engine.config import PRESETS
from hw.memsys.port.read_share import ReadShare
from tb.lib.bench import Bench
from tb.lib.grants import LongestWaiting

COUNT = 3


class TestReadShare(Bench):
    component, arguments, variants = ReadShare, {"count": COUNT}, ({},)

    def model(self, config):
        """Requests carry their reader through an arbiter's register; replies pass to it."""
        rule, request = LongestWaiting(), None
        given = yield
        while True:
            requests = [k for k in range(COUNT) if getattr(given, f"i_request__{k}") is not None]
            granted, advances = rule.grant(requests, requests), request is None or given.o_request
            reply = given.i_reply
            outputs = {
                "o_request": request, "i_reply": reply and getattr(given, f"o_reply__{reply['tag']}"),
                **{f"i_request__{k}": advances and k == granted for k in range(COUNT)},
                **{f"o_reply__{k}": reply | {"tag": 0} if reply and reply["tag"] == k else None for k in range(COUNT)}}
            if advances:
                request = None
                if requests:
                    rule.accept(granted)
                    request = getattr(given, f"i_request__{granted}") | {"tag": granted}
            given = yield outputs

    def items(self, name, shape, random):
        """Replies are a reader's."""
        for item in super().items(name, shape, random):
            yield item | {"tag": item["tag"] % COUNT}


def test_there_is_a_reader():
    with pytest.raises(ValueError, match=r"^Count must be at least 1, not 0$"):
        ReadShare(config=PRESETS["tiny"], count=0)

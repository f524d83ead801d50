import pytest

from hw.memsys.port.timeout import Timeout
from tb.lib.bench import Bench

BITS = 3


class TestTimeout(Bench):
    component, arguments, variants = Timeout, {"bits": BITS}, ({},)

    def model(self, config):
        """Whether 2^bits cycles in a row have waited without progress, and none since had any."""
        since = 0
        given = yield
        while True:
            outputs = {"expired": since >= 1 << BITS}
            since = since + 1 if given.waits and not given.moves else 0
            given = yield outputs

    def drive(self, given, random):
        """Waits of about the length that expires."""
        given.waits, given.moves = random.random() < 0.95, random.random() < 0.05


def test_bits_must_be_a_number_of_them():
    with pytest.raises(ValueError, match=r"^Bits must be at least 1, not 0$"):
        Timeout(bits=0)

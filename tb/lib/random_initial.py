"""Verilog whose registers and memories begin with random values, as those of a chip do."""

import random
import re

__all__ = ["with_random_initial_values"]

_REGISTER = re.compile(r"(?m)^(  reg (?:\[(\d+):0\] )?\S+ +)= \d+'(?:h[0-9a-f]+|d\d+);")
# A loop over words of a memory without initial values.
_LOOP = re.compile(r"(?m)^( +for \(k = .*\) \S.* = )(\d+)'h0;")


def with_random_initial_values(text: str, seed: int) -> str:
    """An export in which each register begins with a random value, and each memory that has no initial values.

    Parameters
    ----------
    text
        As `radiosity.flow.verilog.export.verilog_of` writes it.
    seed
        Of the values.
    """
    draw = random.Random(seed)

    def register(found):
        bits = int(found[2] or 0) + 1
        return f"{found[1]}= {bits}'h{draw.getrandbits(bits):x};"

    def loop(found):
        bits = int(found[2])
        differs = f"{{{-(-bits // 32)}{{k * 32'h{draw.getrandbits(32) | 1:x}}}}}"
        return f"{found[1]}{bits}'h{draw.getrandbits(bits):x} ^ {differs};"

    return _LOOP.sub(loop, _REGISTER.sub(register, text))

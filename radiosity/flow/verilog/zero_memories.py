"""The only module that replaces a private method of Amaranth: memories of zeros are converted without initial values.

`amaranth.back.rtlil` writes the initial value of a memory as one constant, of which each bit is a Python object. A
cluster's memories have tens of millions of bits, nearly all of them zeros: most of the time and memory of a conversion
would go there. Amaranth has no public way to leave initial values out. So the method is replaced while a block runs, in
the versions for which the tests have run; in any other version nothing is replaced, and conversion is slower but
equivalent.
"""

import importlib.metadata
import inspect
from collections.abc import Iterator
from contextlib import contextmanager

from amaranth.back import rtlil

__all__ = ["is_supported", "omit_zeros"]

# Versions whose converter the tests have compared with and without the replacement.
TESTED = "0.5."


def is_supported() -> bool:
    """Whether this version of Amaranth has the method that the tests know."""
    method = getattr(getattr(rtlil, "ModuleEmitter", None), "emit_memory", None)
    return (importlib.metadata.version("amaranth").startswith(TESTED) and method is not None
            and list(inspect.signature(method).parameters) == ["self", "cell_idx", "cell"])


@contextmanager
def omit_zeros() -> Iterator[list]:
    """Conversions inside the block leave out the initial values of memories of zeros, which are then undefined; the
    block is given a list of these memories, which grows with them.
    """
    omitted = []
    if not is_supported():
        yield omitted
        return
    original = rtlil.ModuleEmitter.emit_memory

    def emit_memory(emitter, cell_idx, cell):
        if any(cell.init):
            original(emitter, cell_idx, cell)
        else:
            omitted.append(cell)

    rtlil.ModuleEmitter.emit_memory = emit_memory
    try:
        yield omitted
    finally:
        rtlil.ModuleEmitter.emit_memory = original

"""Where an exported core crosses between clocks."""

import re
from dataclasses import dataclass

__all__ = ["Crossing", "crossings", "with_synchronisers"]

# Of Amaranth's asynchronous queue: a counter in Gray code, and the synchroniser in the other domain that samples it.
_COUNTERS = {"produce_w_gry": "produce_cdc", "consume_r_gry": "consume_cdc"}
# Registers of a synchroniser, in order.
_STAGE = re.compile(r"(?m)^(  reg (?:\[\d+:0\] )?stage\d+ = )")


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """A counter whose bits must arrive together in another clock domain.

    Parameters
    ----------
    path
        The instances around it, from the top on.
    source, sink
        The register, and that of the synchroniser's instance in the same module, joined by ``/``.
    """

    path: tuple[str, ...]
    source: str
    sink: str


def crossings(text: str, top: str) -> list[Crossing]:
    """The counters in the Verilog of a core, in the order of their paths."""
    modules = {name.strip(): body for name, body in re.findall(r"(?ms)^module (\\\S+ |\w+) ?\((.*?)^endmodule$", text)}
    found = []

    def visit(module, path):
        body = modules.get(module, "")
        for counter, instance in _COUNTERS.items():
            if re.search(rf"(?m)^  reg \[\d+:0\] {counter} = ", body):
                found.append(Crossing(path=path, source=counter, sink=f"{instance}/stage0"))
        for part, instance in re.findall(r"(?m)^  (\\\S+|\w+)  (\\\S+|\w+) \($", body):
            visit(part, (*path, instance.removeprefix("\\")))

    visit(top, ())
    return sorted(found, key=lambda one: (one.path, one.source))


def with_synchronisers(text: str) -> str:
    """The text with the attribute ``ASYNC_REG`` at registers of synchronisers: tools keep them, side by side."""
    return _STAGE.sub(r'  (* ASYNC_REG = "TRUE" *)\n\1', text)

"""Which bits of ports and registers a simulation toggles, in both directions."""

import inspect
from pathlib import Path

from amaranth.hdl import Format, Fragment, Print, Signal, Value
from amaranth.hdl._ast import SignalDict, Switch
from amaranth.lib.wiring import Component

__all__ = ["MARK", "add_toggles", "toggles"]

# Begins a line that a simulation prints; a signal, its bits that have risen, and those that have fallen follow.
MARK = "@toggles "


def add_toggles(fragment: Fragment, folder: Path, known: set[str]) -> None:
    """Make a fragment print the bits of its ports and registers that have toggled, whenever there is another one.
    States of an ``FSM`` are no bits: their arms are counted.

    A bit has toggled if it differs at two edges of the clock that follow each other.

    Parameters
    ----------
    folder
        Signals of components in files below it are watched.
    known
        Receives all bits with their directions, as `toggles` names them.
    """
    for signal, (name, domain) in _signals(fragment, folder).items():
        width = len(signal)
        before, begun, seen_up, seen_down = (Signal(size, name=f"toggle_{word}", reset_less=True) for word, size in (
            ("before", width), ("begun", 1), ("seen_up", width), ("seen_down", width)))
        up, down = Signal(width, name="toggle_up"), Signal(width, name="toggle_down")
        now, valid = signal.as_unsigned(), begun.replicate(width)
        # It becomes part of a statement that no module adds.
        text = Print(Format(MARK + name + " {:x} {:x}", up, down))
        text._MustUse__used = True
        fragment.add_statements("comb", [up.eq(seen_up | valid & now & ~before),
                                         down.eq(seen_down | valid & before & ~now)])
        fragment.add_statements(domain, [
            before.eq(now), begun.eq(1), seen_up.eq(up), seen_down.eq(down),
            Switch((up != seen_up) | (down != seen_down), [(1, [text], None)])])
        known.update(_bits(name, (1 << width) - 1, (1 << width) - 1))


def toggles(line: str) -> set[str]:
    """The bits of a printed line, each with ``+`` if it has risen and ``-`` if it has fallen."""
    name, up, down = line.split()
    return _bits(name, int(up, 16), int(down, 16))


def _bits(name, up, down):
    return {f"{name}[{k}]{sign}" for sign, bits in (("+", up), ("-", down))
            for k in range(bits.bit_length()) if bits >> k & 1}


def _signals(fragment, folder):
    """The ports of a fragment's component and its registers: file (line) and name, and the domain."""
    found = SignalDict()
    clocked = [domain for domain in fragment.statements if domain != "comb"]
    for origin in fragment.origins or ():
        path = Path(inspect.getsourcefile(type(origin)))
        if isinstance(origin, Component) and path.is_relative_to(folder):
            for keys, _, value in origin.signature.flatten(origin):
                signal = Value.cast(value)
                if isinstance(signal, Signal) and len(signal):
                    found[signal] = (f"{path.relative_to(folder.parent)}:{'.'.join(map(str, keys))}",
                                     clocked[0] if clocked else "sync")
    for domain in clocked:
        for signal in (signal for statement in fragment.statements[domain] for signal in statement._lhs_signals()):
            if signal not in found and signal.src_loc is not None and Path(signal.src_loc[0]).is_relative_to(folder):
                path, line = signal.src_loc
                found[signal] = f"{Path(path).relative_to(folder.parent)}:{line}:{signal.name}", domain
    return found

"""What a viewer shows of a testbench's waveforms: modules and streams as groups, fields of structs, names of states."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

from amaranth.hdl import Fragment
from vcd.gtkw import GTKWSave, make_translation_filter

__all__ = ["named_states", "write_bench_view"]

_MODULE = re.compile(r"module (\S+)\s?\(")
_INSTANCE = re.compile(r"  (\S+)\s+(\S+)\s+\($")
_DECLARED = re.compile(r"  (?:reg|wire)(?: signed)? (?:\[(\d+):0\] )?(\S+)")
_NAMED = re.compile(r"  \(\* enum_value_([01]+) = \"([^\"]*)\" \*\)$")


@contextmanager
def named_states() -> Iterator[None]:
    """A context in which what is exported names the states of an ``FSM``, as it does values of enumerations."""
    original = Fragment.prepare

    def prepare(self, *arguments, **given):
        _name_states(self)
        return original(self, *arguments, **given)

    with mock.patch.object(Fragment, "prepare", prepare):
        yield


def _name_states(fragment):
    for inner, *_ in fragment.subfragments:
        _name_states(inner)
    for domain, statements in fragment.statements.items():
        for signal in (signal for one in statements if domain != "comb" for signal in one._lhs_signals()):
            # Amaranth gives states a function from their number to "NAME/number", which raises beyond the last one.
            for number in range(1 << len(signal) if callable(signal.decoder) and len(signal) < 8 else 0):
                try:
                    name = signal.decoder(number).rpartition("/")[0]
                except KeyError:
                    break
                signal.attrs[f"enum_value_{number:0{len(signal)}b}"] = name


def write_bench_view(text: str, waves: Path) -> Path:
    """Write a save file of GTKWave beside a testbench's waveforms, and return it.

    A group for each module below ``top``, the latter open, holds a group for each stream: ``valid``, ``ready`` and the
    payload with its fields; then registers and named wires. Enumerations and states show their names.

    Parameters
    ----------
    text
        The Verilog that was simulated.
    waves
        The file of waveforms; the view's has its name, and those of the names of values lie beside it.
    """
    view, modules = waves.with_suffix(".gtkw"), _modules(text)
    with view.open("w") as file:
        save = GTKWSave(file)
        save.dumpfile(waves.name, abspath=False)
        for path, module in _instances(modules, ("top",), "top"):
            signals, names, _ = modules[module]
            with save.group(".".join(path), closed=len(path) > 1):
                for stream, members in _streams(signals):
                    if stream:
                        save.begin_group(stream)
                    for name in members:
                        save.trace(".".join([*path, name]) + _bits(signals[name]), translate_filter_file=_filter(
                            waves.parent, names.get(name, {}), signals[name]))
                    if stream:
                        save.end_group(stream)
    return view


def _modules(text):
    """By name: the bits of its signals, names of their values, and its instances' modules."""
    modules, names = {}, {}
    for line in text.splitlines():
        if found := _MODULE.match(line):
            signals, values, instances = modules[found[1].lstrip("\\")] = {}, {}, {}
        elif found := _NAMED.match(line):
            names[int(found[1], 2)] = found[2]
            continue
        elif found := _DECLARED.match(line):
            # No memories, and nothing that has no name in the source.
            if "$" not in found[2] and "[" not in line[found.end():]:
                name = found[2].lstrip("\\").rstrip(";")
                signals[name], values[name] = int(found[1] or 0) + 1, names
        elif (found := _INSTANCE.match(line)) and "$" not in found[2]:
            instances[found[2].lstrip("\\")] = found[1].lstrip("\\")
        # Attributes belong to the next line.
        names = {}
    return modules


def _instances(modules, path, name):
    """Paths and modules of all instances, each before those in it."""
    yield path, name
    for instance, module in modules[name][2].items():
        if module in modules:
            yield from _instances(modules, (*path, instance), module)


def _streams(signals):
    """Pairs of a stream and its signals, then what belongs to none."""
    streams, rest = {}, []
    for name in signals:
        stream, found, _ = name.partition("__payload")
        if not found:
            stream = re.sub("__(valid|ready)$", "", name)
        if stream != name and f"{stream}__valid" in signals:
            streams.setdefault(stream, []).append(name)
        else:
            rest.append(name)
    order = ("__valid", "__ready", "__payload")
    for stream, members in streams.items():
        yield stream, sorted(members, key=lambda name: next(k for k, end in enumerate(order) if end in name))
    yield "", rest


def _bits(width):
    return f"[{width - 1}:0]" if width > 1 else ""


def _filter(folder, names, width):
    """The file with the names of a signal's values, or None."""
    if not names:
        return None
    text = make_translation_filter(sorted(names.items()), datafmt="hex", size=width)
    path = folder / ("-".join(names.values())[:80] + f".{width}.txt")
    path.write_text(text + "\n")
    return path.name

"""Verilog whose waveforms have the signals that a reader looks for."""

import re

__all__ = ["traced_verilog"]

_DECLARATION = re.compile(r" *(?:reg|wire)(?: signed)?(?: \[[^\]]*\])? (?P<name>\S+) *(?P<array>\[.*)?")
_OFF, _ON = "  /*verilator tracing_off*/\n", "  /*verilator tracing_on*/\n"
_PORT = re.compile(r" *(?:input|output)(?: signed)?(?: \[[^\]]*\])? (\S+) *;")


def traced_verilog(text: str) -> str:
    """The text with waveforms for the ports and the named registers of its modules alone.

    Left out are wires within modules, copies of submodules' ports, and the contents of memories: most of a machine's
    signals, and nearly all of the time that it takes to compile and to write them.
    """
    lines, ports, is_off = [], set(), False
    for line in text.splitlines(keepends=True):
        if line.startswith("module "):
            ports = set()
        elif port := _PORT.match(line):
            ports.add(port[1])
        declaration = _DECLARATION.match(line)
        hidden = declaration is not None and not _is_shown(declaration, line, ports)
        if hidden != is_off:
            lines.append(_OFF if hidden else _ON)
            is_off = hidden
        lines.append(line)
    return "".join(lines)


def _is_shown(declaration, line, ports):
    name = declaration["name"].rstrip(";")
    if name in ports:
        return True
    return "$" not in name and line.lstrip().startswith("reg ") and not (declaration["array"] or "").startswith("[")

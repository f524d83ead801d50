"""Block diagrams of components: DOT, and SVG that stands in a page."""

import json
import re
import subprocess
import sys
from collections.abc import Callable, Sequence

from tb.docs.structure import SELF, Structure

__all__ = ["dot", "draw"]

# Fill of a block by the folder of its class.
FILLS = {"icu": "#dce8f7", "ctu": "#e2f1dc", "memsys": "#fbe9d3", "noc": "#eee0f3", "control": "#f7dcdc",
         "registers": "#f7dcdc", "lib": "#f2f2f2"}
FILL = "#ffffff"
HEAD = """\
digraph {
graph [rankdir=LR, bgcolor=transparent, nodesep=0.25, ranksep=0.45];
node [shape=box, style=filled, fontname=Helvetica, fontsize=11, color="#555555", margin="0.12,0.06"];
edge [fontname=Helvetica, fontsize=9, color="#444444", fontcolor="#444444", arrowsize=0.7];
"""


def dot(structure: Structure, *, page_of: Callable[[type], str | None] = lambda cls: None) -> str:
    """A component's blocks and the streams between them; if there are none, dashed who gives another one anything.

    Blocks and ports that differ in their numbers only are drawn once. ``page_of`` gives the address of a class.
    """
    alike = {}
    for block in structure.blocks:
        alike.setdefault((_without_number(block.name), block.cls), []).append(block.name)
    names, lines = {}, []
    for (name, cls), blocks in alike.items():
        names |= dict.fromkeys(blocks, blocks[0])
        label = [cls.__name__] if name == cls.__name__.lower() else [name, cls.__name__]
        several = {"peripheries": 2} if len(blocks) > 1 else {}
        page = page_of(cls)
        lines.append(_quote(blocks[0]) + _attributes(
            label="\n".join([*label, *([f"{len(blocks)} of them"] if several else [])]),
            fillcolor=FILLS.get(cls.__module__.split(".")[1], FILL), **several,
            **({"href": page, "target": "_top"} if page else {})))

    def end(block, port, side):
        # An interface's two ends are one.
        return names[block] if block != SELF else f"{side} {_array(port)}"

    ports, streams, wires = {}, {}, {}
    for link in structure.links:
        if link.kind == "signal":
            if SELF not in (link.source, link.sink):
                wires.setdefault((names[link.source], names[link.sink]), None)
            continue
        source, sink = end(link.source, link.source_port, "from"), end(link.sink, link.sink_port, "to")
        ports |= {source: _array(link.source_port)} if link.source == SELF else {}
        ports |= {sink: _array(link.sink_port)} if link.sink == SELF else {}
        streams.setdefault((source, sink), {})[_label(link)] = None
    lines += [_quote(node) + _attributes(label=port, shape="plaintext", style="", fontsize=10)
              for node, port in ports.items()]
    # Without empty lines, on which the library fails now and then.
    lines += [f"{_quote(source)} -> {_quote(sink)}" + _attributes(label="\n".join(filter(None, labels)))
              for (source, sink), labels in streams.items()]
    if not any({source, sink} <= set(names.values()) for source, sink in streams):
        lines += [f"{_quote(source)} -> {_quote(sink)}" + _attributes(style="dashed", color="#888888")
                  for source, sink in wires if source != sink]
    return HEAD + "\n".join(lines) + "\n}\n"


def draw(graphs: Sequence[str]) -> list[str]:
    """SVG of each `dot`.

    Raises
    ------
    RuntimeError
        One of them cannot be drawn.
    """
    done = subprocess.run([sys.executable, "-m", "tb.docs.layout"], input=json.dumps(graphs), capture_output=True,
                          text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"layout of diagrams ended with {done.returncode}: {done.stderr}")
    # Without the preamble of a file of its own, and without what says when it was made.
    return [re.sub(r"<!--.*?-->\n?", "", drawn[drawn.index("<svg"):], flags=re.DOTALL)
            for drawn in json.loads(done.stdout)]


def _quote(text) -> str:
    return '"' + str(text).replace("\\", "\\\\").replace('"', r"\"").replace("\n", r"\n") + '"'


def _attributes(**values) -> str:
    return " [" + ", ".join(f"{name}={_quote(value)}" for name, value in values.items()) + "];"


def _label(link) -> str:
    """What a stream is called: by its port's name where that says something."""
    if SELF in (link.source, link.sink):
        # The end itself is named.
        inner = link.sink_port if link.source == SELF else link.source_port
        outer = link.source_port if link.source == SELF else link.sink_port
        return "" if _plain(inner) == _plain(outer) else _plain(inner)
    names = dict.fromkeys(name for name in map(_plain, (link.source_port, link.sink_port)) if name)
    return " - ".join(names)


def _plain(port) -> str:
    """A port's name without its direction and numbers."""
    return re.sub(r"^(i|o)(_|$)", "", _array(port))


def _array(port) -> str:
    return re.sub(r"\[\d+\]", "", port)


def _without_number(name) -> str:
    return re.sub(r"_?\d+$", "", name)

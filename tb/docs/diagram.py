"""Block diagrams of components, as SVG."""

import re
from collections.abc import Callable

import pygraphviz

from tb.docs.structure import SELF, Structure

__all__ = ["draw", "graph"]

# Fill of a block by the folder of its class.
FILLS = {"icu": "#dce8f7", "ctu": "#e2f1dc", "memsys": "#fbe9d3", "noc": "#eee0f3", "control": "#f7dcdc",
         "registers": "#f7dcdc", "lib": "#f2f2f2"}
FILL = "#ffffff"


def graph(structure: Structure, *, page_of: Callable[[type], str | None] = lambda cls: None) -> pygraphviz.AGraph:
    """A component's blocks and the streams between them; if there are none, dashed who gives another one anything.

    Blocks and ports that differ in their numbers only are drawn once. ``page_of`` gives the address of a class.
    """
    drawn = pygraphviz.AGraph(directed=True, strict=False, rankdir="LR", bgcolor="transparent", nodesep="0.25",
                              ranksep="0.45", fontname="Helvetica")
    drawn.node_attr.update(shape="box", style="filled", fontname="Helvetica", fontsize="11", color="#555555",
                           margin="0.12,0.06")
    drawn.edge_attr.update(fontname="Helvetica", fontsize="9", color="#444444", fontcolor="#444444", arrowsize="0.7")
    alike = {}
    for block in structure.blocks:
        alike.setdefault((_without_number(block.name), block.cls), []).append(block.name)
    names = {}
    for (name, cls), blocks in alike.items():
        names |= dict.fromkeys(blocks, blocks[0])
        label = f"{name}\n{cls.__name__}" if name != cls.__name__.lower() else cls.__name__
        if len(blocks) > 1:
            label += f"\n{len(blocks)} of them"
        page = page_of(cls)
        drawn.add_node(blocks[0], label=label, fillcolor=FILLS.get(cls.__module__.split(".")[1], FILL),
                       peripheries=1 + (len(blocks) > 1), **({"href": page, "target": "_top"} if page else {}))

    def end(block, port, side):
        if block != SELF:
            return names[block]
        # An interface's two ends are one.
        node = f"{side} {_array(port)}"
        drawn.add_node(node, label=_array(port), shape="plaintext", style="", fontsize="10", fillcolor="transparent")
        return node

    streams, wires = {}, {}
    for link in structure.links:
        if link.kind == "signal":
            if SELF not in (link.source, link.sink):
                wires.setdefault((names[link.source], names[link.sink]), None)
        else:
            ends = end(link.source, link.source_port, "from"), end(link.sink, link.sink_port, "to")
            streams.setdefault(ends, {})[_label(link)] = None
    for (source, sink), labels in streams.items():
        drawn.add_edge(source, sink, label="\n".join(labels))
    if not any({source, sink} <= set(names.values()) for source, sink in streams):
        for source, sink in wires:
            if source != sink:
                drawn.add_edge(source, sink, style="dashed", color="#888888")
    return drawn


def draw(structure: Structure, **arguments) -> str:
    """`graph` as SVG that stands in a page."""
    text = graph(structure, **arguments).draw(format="svg", prog="dot").decode()
    # Without the preamble of a file of its own, and without what says when it was made.
    return re.sub(r"<!--.*?-->\n?", "", text[text.index("<svg"):], flags=re.DOTALL)


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

import re

from hw.lib.fork import Fork
from hw.lib.queue import Queue
from tb.docs.diagram import dot, draw
from tb.docs.structure import SELF, Block, Link, Structure

TWO = Structure(cls=Queue, latency=None, ports=(), blocks=(Block("first", Queue), Block("lane_0", Fork),
                                                           Block("lane_1", Fork)), stores=(), links=(
    Link(SELF, "i_word", "first", "i", "stream"), Link("first", "o", "lane_0", "i_item", "stream"),
    Link("first", "o", "lane_1", "i_item", "stream"), Link("lane_0", "level", "first", "limit", "signal"),
    Link("first", "o", "lane_0", "i", "stream"), Link("first", "o_rest", "lane_1", "i", "stream")))


def edges(text):
    return re.findall(r'^"(.*?)" -> "(.*?)" \[(.*)\];$', text, re.MULTILINE)


def test_blocks_of_a_kind_are_one_and_streams_have_names():
    text = dot(TWO, page_of=lambda cls: f"{cls.__name__}.html")
    assert [edge[:2] for edge in edges(text)] == [("from i_word", "first"), ("first", "lane_0")]
    # Two streams with names and one without.
    assert r'label="item\nrest"' in edges(text)[1][2]
    assert r'label="lane\nFork\n2 of them"' in text
    assert 'href="Fork.html"' in text


def test_wires_are_drawn_where_there_are_no_streams():
    alone = Structure(cls=Queue, latency=None, ports=(), blocks=TWO.blocks, stores=(), links=TWO.links[3:4])
    ((source, sink, attributes),) = edges(dot(alone))
    assert (source, sink) == ("lane_0", "first")
    assert "dashed" in attributes


def test_each_graph_has_its_drawing_again_and_again():
    linked = dot(TWO, page_of=lambda cls: f"{cls.__name__}.html")
    first, other, second = draw([linked, dot(TWO), linked])
    assert first.startswith("<svg")
    assert first.rstrip().endswith("</svg>")
    assert all(word in first for word in ("i_word", "item", "2 of them", "Fork.html"))
    assert first == second != other

"""From DOT to SVG: ``python -m tb.docs.layout`` reads a JSON list of graphs and writes one of drawings.

A process for each graph, as the library now and then writes where it must not when one draws many; the processes are
copies of one that has imported it.
"""

import json
import sys
from multiprocessing import get_context

import pygraphviz


def layout(graph: str) -> str:
    """The drawing of a graph."""
    return pygraphviz.AGraph(string=graph).draw(format="svg", prog="dot").decode()


if __name__ == "__main__":
    with get_context("fork").Pool(1, maxtasksperchild=1) as pool:
        json.dump(pool.map(layout, json.load(sys.stdin), chunksize=1), sys.stdout)

"""From DOT to SVG, standard input to output: ``python -m tb.docs.layout``.

A process for each graph, as the library now and then writes where it must not when one draws many.
"""

import sys

import pygraphviz

if __name__ == "__main__":
    sys.stdout.buffer.write(pygraphviz.AGraph(string=sys.stdin.read()).draw(format="svg", prog="dot"))

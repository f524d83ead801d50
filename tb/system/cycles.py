"""Cycles of a fixed set of frusta: ``python -m tb.system.cycles`` writes tb/system/cycles.json anew.

`tb/system/test_cycles.py` fails where the machine takes more or fewer, so that each change of its speed is seen.
"""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import click

from hw.host import Host
from hw.simulator.simulated_port import SimulatedPort, complete
from tb.lib.configurations import config_of
from tb.system.scenes import frusta
from tb.system.small_machine import SMALL

__all__ = ["BASELINE", "FRUSTA", "cycles_of"]

BASELINE = Path(__file__).with_name("cycles.json")
CONFIG = config_of(SMALL | {"noc.columns": 1})
_CORNELL = partial(frusta, "cornell", CONFIG, cell=0.5)
# By name: what makes frusta of one phase, and main memory.
FRUSTA: dict[str, tuple[Callable, dict]] = {
    "near memory": (partial(_CORNELL, points=(5, 1, 2)), {"latency": 1}),
    "chance": (partial(_CORNELL, points=(9,)), {"latency": 5, "spread": 30, "shuffles": True}),
    "small cells": (partial(frusta, "cornell", CONFIG, cell=0.2, points=(5, 1)), {"latency": 10}),
    "many rays": (partial(_CORNELL, points=(5,), rays=(64, 16)), {"latency": 10}),
    "screen": (partial(_CORNELL, pixels=(30, 20)), {"latency": 10}),
}


def cycles_of(name: str) -> list[int]:
    """Cycles of each cast of `FRUSTA`; the first one also loads scene and phase, which are not counted.

    Raises
    ------
    AssertionError
        Hits are not golden's.
    """
    make, memory = FRUSTA[name]
    given = make()
    found = []
    with SimulatedPort(CONFIG, size=max(len(one.image.to_bytes()) for one in given), **memory) as port:
        host = Host(port, CONFIG)
        for number, frustum in enumerate(given):
            complete(host.load(frustum.image, **({"lives": ("rays", "frustum")} if number else {})))
            found.append(complete(host.cast()))
            image = complete(host.results(total=frustum.total))
            assert image["hits"].tobytes() == frustum.written["hits"].tobytes(), name
    return found


@click.command()
def main() -> None:
    """Write the baseline."""
    BASELINE.write_text(json.dumps({name: cycles_of(name) for name in FRUSTA}, indent=1) + "\n")
    click.echo(f"wrote {BASELINE}")


if __name__ == "__main__":
    main()

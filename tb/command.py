"""Commands, run as a user would."""

import subprocess
import sys
from pathlib import Path

__all__ = ["golden", "machine"]


def golden(folder: Path, *arguments: str) -> str:
    """Run ``python -m golden`` in a folder, show it, and give the command's text; what fails ends the program."""
    return _run(folder, "golden", arguments)


def machine(folder: Path, *arguments: str) -> str:
    """Run ``python -m tb`` likewise."""
    return _run(folder, "tb", arguments)


def _run(folder, module, arguments):
    line = " ".join((f"python -m {module}", *arguments))
    sys.stdout.write(f"\n$ {line}\n")
    sys.stdout.flush()
    done = subprocess.run([sys.executable, "-m", module, *arguments], cwd=folder, check=False)
    if done.returncode:
        raise SystemExit(done.returncode)
    return line

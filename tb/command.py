"""Golden commands, run as a user would."""

import subprocess
import sys
from pathlib import Path

__all__ = ["golden"]


def golden(folder: Path, *arguments: str) -> str:
    """Run ``python -m golden`` in a folder, show it, and give the command's text; what fails ends the program."""
    line = " ".join(("python -m golden", *arguments))
    sys.stdout.write(f"\n$ {line}\n")
    sys.stdout.flush()
    done = subprocess.run([sys.executable, "-m", "golden", *arguments], cwd=folder, check=False)
    if done.returncode:
        raise SystemExit(done.returncode)
    return line

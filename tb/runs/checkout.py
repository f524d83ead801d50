"""A checkout of a project of its own, for tests of runs."""

import subprocess
from pathlib import Path

__all__ = ["checkout"]


def checkout(folder: Path, files: dict[str, str]) -> Path:
    """A new repository with one commit of some files.

    Parameters
    ----------
    folder
        Becomes the repository; it must not exist.
    files
        Texts by path.
    """
    for name, text in {".gitignore": "out/\nbuild/\n__pycache__/\n.pytest_cache/\n", **files}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    for command in (["init", "-q"], ["config", "user.name", "a"], ["config", "user.email", "a@b.c"], ["add", "-A"],
                    ["commit", "-q", "-m", "Begin"]):
        subprocess.run(["git", *command], cwd=folder, check=True)
    return folder

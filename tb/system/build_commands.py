"""What the commands of a build write, for tests without the tools."""

from pathlib import Path

__all__ = ["write_made"]


def write_made(words: list[str], folder: Path) -> None:
    """Write the files that a command of Verilator, make or g++ is to make, each with its name.

    Parameters
    ----------
    words, folder
        The command, and the folder in which it runs.
    """
    if "-C" in words:
        folder /= words[words.index("-C") + 1]
    made = [word for word in words if word.endswith((".a", ".o"))]
    if "-o" in words:
        made = [words[words.index("-o") + 1]]
    if "--lib-create" in words:
        made = [f"{words[words.index('--Mdir') + 1]}/{words[words.index('--lib-create') + 1]}.sv"]
    for name in made:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(name)

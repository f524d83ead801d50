"""Files of an example that are made from templates here."""

from collections.abc import Mapping
from pathlib import Path

__all__ = ["example_files"]

_FOLDER = Path(__file__).parent


def example_files(kind: str, words: Mapping[str, str]) -> dict[str, str]:
    """The benches in Verilog and cocotb and the Makefile of an example, by their paths in the folder of the core.

    Parameters
    ----------
    kind
        ``link`` or ``stream``.
    words
        What stands in the place of each ``@WORD@``.
    """
    files = {"example/bench.v": f"{kind}_bench.v.in", "example/test_bench.py": f"{kind}_test.py.in",
             "example/Makefile": "Makefile.in"}
    return {path: _filled((_FOLDER / name).read_text(), words) for path, name in files.items()}


def _filled(text, words):
    for word, value in words.items():
        text = text.replace(f"@{word}@", value)
    return text

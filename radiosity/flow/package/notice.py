"""The licence in the files of an exported core."""

import importlib.metadata
import re
from pathlib import PurePosixPath

from golden.base.package_version import DISTRIBUTION

__all__ = ["COPYRIGHT", "LICENCE", "LICENSE", "with_notice"]

_PACKAGE = importlib.metadata.distribution(DISTRIBUTION)
# The licence by its name for machines, and its text, whose condition is that copies retain it.
LICENCE = _PACKAGE.metadata["License-Expression"]
LICENSE = _PACKAGE.read_text("licenses/LICENSE")
COPYRIGHT = re.search(r"Copyright .*", LICENSE)[0]
# By the end of a file's name: how a line becomes a comment.
_COMMENTS = {
    **dict.fromkeys((".sv", ".v", ".vlt", ".f", ".rdl", ".cpp", ".hex"), "// {}\n"),
    **dict.fromkeys((".c", ".h"), "/* {} */\n"),
    **dict.fromkeys((".sdc", ".xdc", ".lpf", ".py", "Makefile"), "# {}\n"), ".vhd": "-- {}\n"}


def with_notice(path: str, content: str) -> str:
    """The content of a file with the copyright and the name of its licence, as a comment in the file's language.

    A manifest has both as values, and the data of a job, which are the user's, have neither.
    """
    line = f"{COPYRIGHT}. SPDX-License-Identifier: {LICENCE}"
    name = PurePosixPath(path)
    if path == "LICENSE" or name.parent.name == "job" or name.suffix == ".json":
        return content
    if name.suffix == ".md":
        return f"{content}\n{COPYRIGHT}. The licence is {LICENCE}: `LICENSE` has its text.\n"
    if name.suffix == ".core":
        # Its first line names the format.
        first, rest = content.split("\n", 1)
        return f"{first}\n# {line}\n{rest}"
    return _COMMENTS[name.suffix or name.name].format(line) + content

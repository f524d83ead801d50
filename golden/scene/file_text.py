"""Text of files: encodings, ends of lines, numbers and names as programs write them."""

import math
import re
from os.path import exists, isdir, isfile
from pathlib import Path

from golden.base.input_warnings import warn

__all__ = ["file_of", "forms_of", "is_number", "lines_of", "number", "numbers", "unquoted"]

# What C libraries write for values that are not finite: nan(ind), -nan, 1.#QNAN0, -1.#IND00, 1.#INF.
_NOT_FINITE = re.compile(r"[+-]?(nan(\(\w*\))?|inf|1\.#(qnan|snan|ind|inf)\d*)", re.IGNORECASE)
_QUOTED = re.compile(r"""(["'])(.*?)\1(?:\s+#.*)?""")


def lines_of(data: bytes) -> list[str]:
    """The lines of a text in UTF-8, UTF-16 or, line by line where they are not UTF-8, in Latin-1.

    Names that differ in the file differ in the text too. Lines end in LF, CR or both; a mark of DOS for the end of the
    text, Ctrl-Z, is left out.
    """
    text = _decoded(data).replace("\r\n", "\n").replace("\r", "\n")
    return text.rstrip("\x1a\0").removesuffix("\n").split("\n") if text else []


def _decoded(data):
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    start = data[:64]
    for zeros, encoding in ((start[1::2], "utf-16-le"), (start[::2], "utf-16-be")):
        if zeros and not any(zeros):
            return data.decode(encoding, errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return "".join(map(_line, re.split(rb"(?<=[\r\n])", data.removeprefix(b"\xef\xbb\xbf"))))


def _line(data):
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def number(word: str) -> float:
    """The number that a word is; NaN for what C libraries write for values that are not finite.

    Raises
    ------
    ValueError
        It is none. Python's own digit separators are none.
    """
    if "_" not in word:
        try:
            return float(word)
        except ValueError:
            if _NOT_FINITE.fullmatch(word):
                return math.nan
    raise ValueError(f"{word!r} is not a number")


def is_number(word: str) -> bool:
    """Whether a word is a `number`."""
    try:
        number(word)
    except ValueError:
        return False
    return True


def numbers(words: list[str]) -> list[float]:
    """The numbers that words are; see `number`."""
    try:
        values = list(map(float, words))
    except ValueError:
        return list(map(number, words))
    return values if "_" not in "".join(words) else list(map(number, words))


def unquoted(name: str) -> str:
    """A name without the quotes around it, and without a comment behind these."""
    found = _QUOTED.fullmatch(name)
    return found[2] if found else name


def forms_of(name: str) -> list[str]:
    """What a name at the end of a line may be: as it stands, or before a comment, each also without quotes.

    The longest ones come first: a name may hold blanks and ``#``.
    """
    cuts = [found.start() for found in re.finditer(r"\s#", name)]
    parts = [name, *(name[:cut].rstrip() for cut in [*cuts[-1:], *cuts[:1]])]
    return list(dict.fromkeys(form for part in parts for form in (part, unquoted(part))))


def file_of(folder: Path, names: list[str]) -> tuple[Path, str] | None:
    """The first of the names that is a file's, with its path, or None; a backslash separates folders too.

    Exporters write paths of their own computers: where none of these files exists, one of the same name in ``folder``
    counts, with a warning.

    Warns
    -----
    InputWarning
        The file is in another folder than the one that is named.
    """
    slashed = {name: name.replace("\\", "/") for name in names}
    for name in slashed:
        # Path.is_file raises errors for names that the system refuses.
        if name and exists(path := folder / slashed[name]) and not isdir(path):
            return path, name
    for name in slashed:
        own = slashed[name].rpartition("/")[2]
        if own not in ("", slashed[name]) and isfile(path := folder / own):
            warn(f"there is no file {name!r}: {own!r} is taken for it")
            return path, name
    return None

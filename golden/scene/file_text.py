"""Text of files: encodings, ends of lines and numbers as programs write them."""

import math
import re

__all__ = ["lines_of", "number", "numbers", "unquoted"]

# What C libraries write for values that are not finite: nan(ind), -nan, 1.#QNAN0, -1.#IND00, 1.#INF.
_NOT_FINITE = re.compile(r"[+-]?(nan(\(\w*\))?|inf|1\.#(qnan|snan|ind|inf)\d*)", re.IGNORECASE)


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


def numbers(words: list[str]) -> list[float]:
    """The numbers that words are; see `number`."""
    try:
        values = list(map(float, words))
    except ValueError:
        return list(map(number, words))
    return values if "_" not in "".join(words) else list(map(number, words))


def unquoted(name: str) -> str:
    """A name without the quotes around it."""
    return name[1:-1] if len(name) > 1 and name[0] == name[-1] and name[0] in "\"'" else name

"""The project's prose, and the phrases of tb/docs/words.md that it avoids."""

import io
import re
import sys
import tokenize
from functools import cache
from pathlib import Path

__all__ = ["ROOT", "as_words", "forbidden_phrases", "markdown_files", "occurrences", "prose_of", "prose_of_markdown",
           "prose_of_python", "replacements", "words_of_names"]

ROOT = Path(__file__).parents[2]
WORDS = Path(__file__).parent / "words.md"

_SECTION = "## Words that we do not use"
_TEXT_TOKENS = {tokenize.COMMENT, tokenize.STRING} | {
    getattr(tokenize, name) for name in ("FSTRING_MIDDLE",) if hasattr(tokenize, name)}


def replacements() -> dict[str, str]:
    """The unmistakable phrases of its table, each with what stands for it."""
    rows = re.findall(r"^\| (.+?) \| (.+?) \|$", WORDS.read_text().partition(_SECTION)[2], re.MULTILINE)
    return {phrase: right for left, right in rows for phrase in re.findall(r"`([^`]+)`", left)}


def forbidden_phrases() -> re.Pattern:
    """Matches any of these phrases: as whole words, in any case, across the ends of lines."""
    phrases = [r"\s+".join(map(re.escape, phrase.split())) for phrase in sorted(replacements(), key=len, reverse=True)]
    return re.compile(rf"(?<![\w-])(?:{'|'.join(phrases)})(?![\w-])", re.IGNORECASE)


@cache
def _words_of_phrases():
    return [set(re.findall(r"\w+", phrase.lower())) for phrase in replacements()]


def _may_have_phrase(text):
    """Whether a text has all words of a phrase."""
    words = set(re.findall(r"\w+", text.lower()))
    return any(phrase <= words for phrase in _words_of_phrases())


def prose_of_python(text: str) -> list[tuple[int, str]]:
    """Comments and strings with the number of their first line; the comments of consecutive lines are one."""
    found = []
    last_comment = None
    for kind, line, string in _tokens(text):
        if kind == tokenize.COMMENT:
            words = string.lstrip("#").strip()
            if last_comment == line - 1:
                found[-1] = (found[-1][0], f"{found[-1][1]}\n{words}")
            else:
                found.append((line, words))
            last_comment = line
        elif kind in _TEXT_TOKENS:
            found.append((line, string))
    return found


def as_words(name: str) -> str:
    """A name's words."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_+", " ", name).strip()


def words_of_names(text: str) -> list[tuple[int, str]]:
    """The names in Python code, as words, each with its line."""
    return [(line, as_words(string))
            for kind, line, string in _tokens(text) if kind == tokenize.NAME]


@cache
def _tokens(text):
    """Names, strings and comments: kind, line and text."""
    kinds = {tokenize.NAME, tokenize.COMMENT, *_TEXT_TOKENS}
    return [(token.type, token.start[0], sys.intern(token.string))
            for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type in kinds]


def prose_of_markdown(text: str, *, spans: bool = False) -> str:
    """A page without code blocks, links' targets and HTML, with or without code spans; as many lines as before."""
    def blank(match):
        return "\n" * match[0].count("\n")

    text = re.sub(r"^( *)(`{3,}|~{3,})[^\n]*\n.*?^\1\2[^\n]*$", blank, text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<!--.*?-->", blank, text, flags=re.DOTALL)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"<[^>\n]+>", "", text)
    return text.replace("`", "") if spans else re.sub(r"`[^`\n]*`", "", text)


def prose_of(path: Path) -> list[tuple[int, str]]:
    """What a file says to its reader, in parts with their first lines."""
    text = path.read_text()
    if path.suffix == ".py":
        return prose_of_python(text)
    return [(1, prose_of_markdown(text) if path.suffix == ".md" else text)]


def markdown_files() -> list[Path]:
    """The pages of the documentation."""
    return [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]


def occurrences(path: Path, pattern: re.Pattern) -> list[str]:
    """Where a file has a phrase: ``path:line: phrase``."""
    # Tokens take far longer than a search for what comments and strings can have, and that longer than one for words.
    if path.suffix == ".py" and not (_may_have_phrase(text := path.read_text()) and pattern.search(
            re.sub(r"\n[ ]*#+[ ]*", "\n", text))):
        return []
    return [f"{path.relative_to(ROOT)}:{line + part.count(chr(10), 0, match.start())}: {' '.join(match[0].split())}"
            for line, part in prose_of(path) for match in pattern.finditer(part)]

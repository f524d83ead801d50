"""Assertions that cannot fail, and tests without any, found in texts."""

import re
from collections.abc import Iterator, Mapping

from tb.sources.source_texts import functions, imports

__all__ = ["Assertions", "idle_assertions"]

# What ruff does not see: it knows assertions of tuples, and terms that decide alone.
_TRUE = (r"True\b", r"[1-9]\d*$", r"not False\b", r"lambda\b", r"f?['\"][^'\"]*['\"]$", r"\([^()]* for [^()]*\)$",
         r"len\(.*\) (?:>= 0|> -1)$")
_IDLE = {
    "is always true": re.compile(rf"(?m)^ *assert (?:{'|'.join(_TRUE)})"),
    # Without a term before it or behind it, and not as a string.
    "compares a thing with itself": re.compile(
        r"(?<![\w.)\]+*/%&|^-])(?<![+*/%&|^-] )(?<!\"\()(\(?[A-Za-z_][\w.\[\] -]*?\)?) (?:[=!<>]=|[<>]|is) \1"
        r"(?![\w.(\[])(?!\)? ?(?:[-+*/@%&|^]|<<|>>))"),
    "ignores an exception": re.compile(r"except[^\n]*:\n *(?:pass|\.\.\.)(?! *#)\n"),
}
# By these a function can fail.
_FAILS = re.compile(r"(?m)^ *assert\b|\b(?:fail|raises|warns|assert_\w+)\(|\braise AssertionError\b")
_WORDS = re.compile(r"(\.?)\b([A-Za-z_]\w*)")


def _code(text):
    """A text without docstrings and comments, with as many lines."""
    return re.sub(r'(?s:""".*?""")|(?<=\s)#[^\n]*', lambda match: "\n" * match[0].count("\n"), text)


def idle_assertions(text: str) -> Iterator[tuple[int, str]]:
    """Lines of a text with what can neither fail nor show a fault, and why."""
    code = _code(text) + "\n"
    for why, pattern in _IDLE.items():
        yield from ((code.count("\n", 0, match.start()) + 1, why) for match in pattern.finditer(code))
    for name, line, body in functions(code):
        # Functions in a function that nothing names.
        for inner, begin, _ in functions("\n".join(body.splitlines()[1:])):
            is_decorated = body.splitlines()[begin - 1].lstrip().startswith("@")
            if "." not in inner and not is_decorated and len(re.findall(rf"\b{inner}\b", body)) == 1:
                yield line + begin, f"{inner} is never called in {name}"


class Assertions:
    """Which functions of some files can fail by an assertion, of their own or of a function that they call.

    A name stands for the function of that name in its file, or in the file that it is imported from; an attribute for
    all functions of that name in these files. A class stands for its constructor.

    Parameters
    ----------
    texts
        By path from the root.
    """

    def __init__(self, texts: Mapping[str, str]):
        self._texts = {path: _code(text) for path, text in texts.items()}
        # By file and name: (line, body, whether it is decorated as a coroutine that tests).
        self._functions: dict[str, dict[str, list[tuple[int, str]]]] = {path: {} for path in texts}
        self._imports: dict[str, dict[str, str]] = {}
        errors = "|".join(re.findall(r"(?m)^class (\w+)\(AssertionError\)", "\n".join(self._texts.values())))
        fails = re.compile(rf"{_FAILS.pattern}|\braise (?:{errors})\b") if errors else _FAILS
        for path, text in self._texts.items():
            for name, line, body in functions(text):
                *outer, last = name.split(".")
                known = outer[-1] if outer and last in ("__init__", "__post_init__") else last
                self._functions[path].setdefault(known, []).append((line, body))
            self._imports[path] = {name: file for module, name in imports(text) for file in self._files(module, name)}
        self._asserting = {(path, line) for path, found in self._functions.items() for bodies in found.values()
                           for line, body in bodies if fails.search(body)}
        self._words = {(path, line): set(_WORDS.findall(body)) for path, found in self._functions.items()
                       for bodies in found.values() for line, body in bodies if (path, line) not in self._asserting}
        self._close()

    def _files(self, module, name):
        """The file that a name comes from."""
        base = module.replace(".", "/")
        return [path for path in (f"{base}/{name}.py", f"{base}.py", f"{base}/__init__.py") if path in self._texts][:1]

    def _close(self):
        """Whoever calls a function that asserts, asserts."""
        grows = True
        while grows:
            found = {where for where in self._words if where not in self._asserting and self._calls(*where)}
            self._asserting |= found
            grows = bool(found)

    def _calls(self, path, line):
        """Whether a function names one that asserts."""
        known = self._imports[path]
        for dot, word in self._words[path, line]:
            for file in {path, *known.values()} if dot else {path, known.get(word)} - {None}:
                if any((file, at) in self._asserting for at, _ in self._functions[file].get(word, ())
                       if (file, at) != (path, line)):
                    return True
        return False

    def without(self, path: str) -> Iterator[tuple[int, str]]:
        """Lines and names of the tests of a file that assert nothing."""
        lines = self._texts[path].splitlines()
        for name, found in self._functions[path].items():
            for line, _ in found:
                is_coroutine = lines[line - 2].startswith("@cocotb.test") if line > 1 else False
                if (name.startswith("test_") or is_coroutine) and (path, line) not in self._asserting:
                    yield line, f"{name} asserts nothing"

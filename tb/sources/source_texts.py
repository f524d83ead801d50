"""The project's files, and what is in them."""

import functools
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

__all__ = ["ROOT", "components", "functions", "imports", "loaded_files", "source_texts"]

ROOT = Path(__file__).parents[2]


@functools.cache
def source_texts(folder: str) -> dict[str, str]:
    """The texts of all Python files below a folder, by path from the root."""
    return {path.relative_to(ROOT).as_posix(): path.read_text() for path in sorted((ROOT / folder).rglob("*.py"))}


def imports(text: str) -> Iterator[tuple[str, str]]:
    """Modules that a text imports anywhere, each with the imported name, or "" for the module itself."""
    for module, many, one, modules in re.findall(
            r"(?m)^[ \t]*(?:from (\S+) import (?:\(([^)]*)\)|([^\n(]+))|import ([^\n]+))$", text):
        names = re.sub(r"#.*", "", many or one or modules).split(",")
        names = [name.split(" as ")[0].strip() for name in names if name.strip()]
        yield from ((module, name) if module else (name, "") for name in names)


def loaded_files(*modules: str) -> set[str]:
    """The project's files that these modules load when they are imported, by path from the root, without packages'
    own files (``__init__.py``).
    """
    # What Python itself has loaded before is not theirs: a run may be watched.
    text = (f"import sys\nbefore = {{*sys.modules}}\nimport {', '.join(modules)}\n"
            "for name in {*sys.modules} - before: print(getattr(sys.modules[name], '__file__', None))")
    paths = subprocess.run([sys.executable, "-c", text], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return {Path(path).relative_to(ROOT).as_posix() for path in paths.splitlines()
            if path.endswith(".py") and not path.endswith("__init__.py")
            and Path(path).is_relative_to(ROOT) and not Path(path).is_relative_to(sys.prefix)}


def functions(text: str) -> Iterator[tuple[str, int, str]]:
    """Of the functions of a text, by indentation: their qualified names, first lines and texts."""
    within: list[tuple[int, str, int]] = []
    lines, last = text.splitlines(), 0

    def closed(indent):
        while within and within[-1][0] >= indent:
            _, _, begin = within[-1]
            if begin:
                yield ".".join(name for _, name, _ in within), begin, "\n".join(lines[begin - 1:last])
            within.pop()

    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        found = re.match(r"( *)(?:async )?(def|class) (\w+)", line)
        # A bracket at the margin continues what is open.
        if line.lstrip()[0] not in ")]},\"'#":
            yield from closed(len(line) - len(line.lstrip()))
        if found:
            within.append((len(found[1]), found[3], number if found[2] == "def" else 0))
        last = number
    yield from closed(0)


def components() -> dict[str, list[str]]:
    """Files that define components, with these; the simulated machine is no hardware."""
    found = {path: re.findall(r"(?m)^class (\w+)\((?:.*[ ,])?(?:wiring\.)?Component\b", text)
             for folder in ("hw", "radiosity/flow/synthesis") for path, text in source_texts(folder).items()}
    return {path: names for path, names in found.items() if names}

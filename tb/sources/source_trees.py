"""Syntax trees of the project's files."""

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

__all__ = ["ROOT", "functions", "imports", "source_trees"]

ROOT = Path(__file__).parents[2]


@functools.cache
def source_trees(folder: str) -> dict[str, ast.Module]:
    """The trees of all Python files below a folder, by path from the root."""
    return {path.relative_to(ROOT).as_posix(): ast.parse(path.read_text())
            for path in sorted((ROOT / folder).rglob("*.py"))}


def imports(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Modules that a tree imports anywhere, each with the imported name, or "" for the module itself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from ((node.module, alias.name) for alias in node.names)


def functions(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Qualified names of the functions of a tree, and how many lines each has."""

    def walk(node, path):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                inner = [*path, child.name]
                if not isinstance(child, ast.ClassDef):
                    yield ".".join(inner), child.end_lineno - child.lineno + 1
                yield from walk(child, inner)
            else:
                yield from walk(child, path)

    yield from walk(tree, [])

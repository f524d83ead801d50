"""A file of the sources: its text, and what each place of it lies in."""

import ast
from collections.abc import Iterator
from functools import cached_property
from itertools import accumulate

__all__ = ["FUNCTIONS", "Source"]

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
# What is no behaviour, or belongs to a message.
_APART = (ast.JoinedStr, ast.Raise, ast.Assert, ast.Import, ast.ImportFrom)
_DATA = (ast.Constant, ast.Tuple, ast.List, ast.UnaryOp)


class Source:
    """A Python file with positions in bytes, as `ast` has them.

    Parameters
    ----------
    path
        From the root of the project.
    text
        Its contents.
    """

    def __init__(self, path: str, text: str):
        self.path, self.text = path, text
        self.tree = ast.parse(text)
        self.data = text.encode()
        self._lines = [0, *accumulate(len(line) for line in self.data.splitlines(keepends=True))]
        self.parent = {child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)}

    def span(self, node: ast.AST) -> tuple[int, int]:
        """First byte of a node, and the byte behind its last one."""
        return (self._lines[node.lineno - 1] + node.col_offset,
                self._lines[node.end_lineno - 1] + node.end_col_offset)

    def of(self, node: ast.AST) -> str:
        """The text of a node."""
        begin, end = self.span(node)
        return self.data[begin:end].decode()

    def around(self, node: ast.AST) -> Iterator[ast.AST]:
        """What a node lies in, from the inside."""
        while node in self.parent:
            node = self.parent[node]
            yield node

    def function(self, node: ast.AST) -> ast.AST | None:
        """The innermost function with a name whose body a node lies in."""
        inner = node
        for outer in self.around(node):
            if isinstance(outer, FUNCTIONS) and not isinstance(inner, ast.arguments):
                return outer
            inner = outer
        return None

    def class_of(self, node: ast.AST) -> ast.AST | None:
        """The innermost class that a node lies in."""
        return next((one for one in self.around(node) if isinstance(one, ast.ClassDef)), None)

    @cached_property
    def places(self) -> list[ast.AST]:
        """Nodes that change what the program does: no annotations, decorators, messages, imports and docstrings."""
        found = []

        def walk(node):
            if isinstance(node, _APART) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
                return
            found.append(node)
            for name, value in ast.iter_fields(node):
                if name in ("annotation", "returns", "decorator_list", "bases"):
                    continue
                # A table of many numbers is data, and no rule.
                if isinstance(value, list) and len(value) > 8 and all(isinstance(one, _DATA) for one in value):
                    continue
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST):
                        walk(child)

        for node in self.tree.body:
            is_listing = isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
            if not is_listing:
                walk(node)
        return found

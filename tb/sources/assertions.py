"""Assertions that cannot fail, and tests without any, found in syntax trees."""

import ast
from collections.abc import Iterator, Mapping
from itertools import pairwise

__all__ = ["Assertions", "idle_assertions"]

_FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef
# Of an expression: its value is always true.
_DISPLAYS = ast.GeneratorExp | ast.Lambda
# Functions of others by whose exception a test fails.
_RAISING = {"fail", "raises", "warns"}


def idle_assertions(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Lines of a tree with what can neither fail nor show a fault, and why."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assert) and _is_true(node.test):
            yield node.lineno, "is always true"
        elif isinstance(node, ast.Compare) and _compares_itself(node):
            yield node.lineno, "compares a thing with itself"
        elif isinstance(node, ast.ExceptHandler) and all(isinstance(one, ast.Pass) or _is_constant(one)
                                                         for one in node.body):
            yield node.lineno, "ignores an exception"
        elif isinstance(node, _FUNCTIONS):
            yield from _unused(node)


def _is_constant(statement):
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _is_true(test):
    """Whether an expression is true whatever its names are."""
    if isinstance(test, ast.Constant):
        return bool(test.value)
    if isinstance(test, ast.Tuple | ast.List | ast.Set):
        return any(not isinstance(one, ast.Starred) for one in test.elts)
    if isinstance(test, ast.Dict | ast.JoinedStr):
        return bool(test.keys if isinstance(test, ast.Dict) else test.values)
    if isinstance(test, ast.BoolOp):
        return (any if isinstance(test.op, ast.Or) else all)(map(_is_true, test.values))
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        return isinstance(test.operand, ast.Constant) and not test.operand.value
    if isinstance(test, ast.Compare):
        constants = all(isinstance(one, ast.Constant) for one in (test.left, *test.comparators))
        return constants or _is_length_of_anything(test)
    return isinstance(test, _DISPLAYS)


def _is_length_of_anything(test):
    """``len(x) >= 0``."""
    return (isinstance(test.left, ast.Call) and ast.unparse(test.left.func) == "len"
            and any(isinstance(op, kind) and ast.unparse(one) == limit
                    for op, one in zip(test.ops, test.comparators, strict=True)
                    for kind, limit in ((ast.GtE, "0"), (ast.Gt, "-1"))))


def _compares_itself(node):
    """Whether two neighbours of a comparison are the same expression; calls may have different results."""
    return any(type(one) is type(other) and ast.dump(one) == ast.dump(other) and not any(
        isinstance(part, ast.Call | ast.Await | ast.NamedExpr) for part in ast.walk(one))
               for one, other in pairwise((node.left, *node.comparators)) if not isinstance(one, ast.Constant))


def _unused(function):
    """Functions in a function that nothing names."""
    inner = [node for node in function.body if isinstance(node, _FUNCTIONS) and not node.decorator_list]
    if inner:
        names = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
        yield from ((node.lineno, f"{node.name} is never called") for node in inner if node.name not in names)


class Assertions:
    """Which functions of some files can fail by an assertion, of their own or of a function that they call.

    A name stands for the function of that name in its file, or in the file that it is imported from; an attribute for
    all functions of that name in these files.

    Parameters
    ----------
    trees
        By path from the root.
    """

    def __init__(self, trees: Mapping[str, ast.Module]):
        self._trees = trees
        self._functions: dict[str, dict[str, list]] = {}
        self._imports: dict[str, dict[str, str]] = {}
        for path, tree in trees.items():
            found = self._functions[path] = {}
            for node in ast.walk(tree):
                if isinstance(node, _FUNCTIONS):
                    found.setdefault(node.name, []).append(node)
                elif isinstance(node, ast.ClassDef):
                    # A class asserts in its constructor, or stands for its methods.
                    found.setdefault(node.name, []).extend(one for one in node.body if isinstance(one, _FUNCTIONS)
                                                           and one.name in ("__init__", "__post_init__"))
            self._imports[path] = {alias.asname or alias.name: file for node in ast.walk(tree)
                                   if isinstance(node, ast.ImportFrom) and node.module for alias in node.names
                                   for file in self._files(node.module, alias.name)}
        errors = {"AssertionError"} | {
            node.name for tree in trees.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)
            and "AssertionError" in map(ast.unparse, node.bases)}
        self._asserting = {id(node) for path in trees for nodes in self._functions[path].values() for node in nodes
                           if _asserts(node, errors)}
        # By function: the names and the attributes in it.
        self._words = {id(node): _words(node) for path in trees for nodes in self._functions[path].values()
                       for node in nodes if id(node) not in self._asserting}
        self._close()

    def _files(self, module, name):
        """The file that a name comes from."""
        base = module.replace(".", "/")
        return [path for path in (f"{base}/{name}.py", f"{base}.py", f"{base}/__init__.py") if path in self._trees][:1]

    def _close(self):
        """Whoever calls a function that asserts, asserts."""
        grows = True
        while grows:
            before = len(self._asserting)
            for path in self._trees:
                for nodes in self._functions[path].values():
                    self._asserting |= {id(node) for node in nodes if id(node) not in self._asserting
                                        and self._calls(path, node)}
            grows = len(self._asserting) > before

    def _calls(self, path, function):
        """Whether a function names one that asserts."""
        names, attributes = self._words[id(function)]
        imports, anywhere = self._imports[path], [path, *self._imports[path].values()]
        words = [*((name, [path, imports.get(name)]) for name in names), *((name, anywhere) for name in attributes)]
        return any(id(one) in self._asserting and one is not function for name, files in words
                   for file in files if file for one in self._functions[file].get(name, ()))

    def without(self, path: str) -> Iterator[tuple[int, str]]:
        """Lines and names of the tests of a file that assert nothing."""
        for name, nodes in self._functions[path].items():
            for node in nodes:
                if (name.startswith("test_") or _is_coroutine_test(node)) and id(node) not in self._asserting:
                    yield node.lineno, f"{name} asserts nothing"


def _words(function):
    """All names and all attributes in a function."""
    nodes = list(ast.walk(function))
    return ({node.id for node in nodes if isinstance(node, ast.Name)},
            {node.attr for node in nodes if isinstance(node, ast.Attribute)})


def _is_coroutine_test(node):
    return any(ast.unparse(one).startswith("cocotb.test") for one in node.decorator_list)


def _asserts(function, errors):
    """Whether a function can fail by itself."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assert):
            return True
        if isinstance(node, ast.Raise) and node.exc is not None and ast.unparse(node.exc).partition("(")[0] in errors:
            return True
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in _RAISING or name.startswith("assert_"):
                return True
    return False

"""Private attributes of the hardware: none is kept that nothing reads."""

import ast
import re

import pytest

from tb.sources.source_texts import ROOT

HARDWARE = sorted((ROOT / "hw").rglob("*.py"))


def unread(tree, others):
    """Private attributes that a class of a module assigns to itself, which neither the module reads nor one that
    inherits from the class.

    Parameters
    ----------
    others
        The texts of other modules.
    """
    read = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load)}
    for one in tree.body:
        if isinstance(one, ast.ClassDef):
            users = [text for text in others if re.search(rf"class \w+\([^)]*\b{one.name}\b", text)]
            for node in ast.walk(one):
                if (isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
                        and isinstance(node.value, ast.Name) and node.value.id == "self" and node.attr.startswith("_")
                        and node.attr not in read and not any(f".{node.attr}" in text for text in users)):
                    yield f"{one.name}.{node.attr}"


def test_every_private_attribute_of_the_hardware_is_read():
    texts = {path: path.read_text() for folder in ("hw", "tb") for path in (ROOT / folder).rglob("*.py")}
    assert not [name for path in HARDWARE for name in unread(
        ast.parse(texts[path]), [text for other, text in texts.items() if other != path])]


@pytest.mark.parametrize(("text", "other", "found"), [
    ("class A:\n def f(self):\n  self._b = 1", "", ["A._b"]),
    ("class A:\n def f(self):\n  self._b, c = 1, 2", "", ["A._b"]),
    ("class A:\n def f(self):\n  self._b = 1\n  return self._b", "", []),
    ("class A:\n def f(self):\n  self._b = 1", "class C(A):\n x = self._b", [])])
def test_an_attribute_that_nothing_reads_is_found(text, other, found):
    assert [*unread(ast.parse(text), [other])] == found

"""What benches of the hardware compare without order or repetition, and why."""

import ast

import pytest

from tb.sources.source_texts import source_texts

FOLDERS = ("axi", "board", "control", "ctu", "formal", "icu", "lib", "memsys", "noc", "registers", "system")
# Calls that lose the order of what they are given, and some its repetitions.
UNORDERED = {"sorted", "set", "frozenset", "Counter", "sort", "unique"}


def unordered(text: str) -> list[int]:
    """Lines of assertions that compare without order and state no reason, as a message or as a comment above.

    That a list equals itself sorted claims an order, and a set of one element that all are equal; what is compared
    with literals is a list of cases.
    """
    lines, wrong = text.splitlines(), []
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.Assert) or node.msg or lines[node.lineno - 2].lstrip().startswith("#"):
            continue
        for compared in ast.walk(node.test):
            if isinstance(compared, ast.Compare) and not isinstance(compared.ops[0], ast.In | ast.NotIn):
                sides = [compared.left, *compared.comparators]
                if any(map(_is_unordered, sides)) and not any(map(_is_plain, sides)) and not _claims_order(sides):
                    wrong.append(node.lineno)
    return wrong


def _name(call):
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def _is_unordered(side):
    return isinstance(side, ast.Call) and _name(side) in UNORDERED and bool(side.args)


def _is_plain(side):
    """Whether it is a literal, or a set of one element."""
    if isinstance(side, ast.Set) and len(side.elts) == 1:
        return True
    try:
        ast.literal_eval(side)
    except ValueError:
        return False
    return True


def _claims_order(sides):
    return any(_is_unordered(one) and ast.dump(one.args[0]) == ast.dump(other) for one in sides for other in sides)


@pytest.mark.parametrize("folder", FOLDERS)
def test_benches_say_why_they_compare_without_order(folder):
    wrong = [f"{path}:{line}" for path, text in source_texts(f"tb/{folder}").items() for line in unordered(text)]
    assert not wrong, "what is sorted, counted or a set in an assertion needs a reason beside it"


@pytest.mark.parametrize(("line", "is_wrong"), [
    ("assert sorted(a) == sorted(b)", True), ("assert Counter(a) == b", True), ("assert set(a) <= set(b)", True),
    ("assert c and sorted(a) == b", True), ("assert sorted(a) == b, 'any order'", False), ("assert a == b", False),
    ("# In any order.\nassert sorted(a) == b", False), ("assert a == sorted(a)", False),
    ("assert set(a) == {b}", False), ("assert sorted(a) == [1, 2]", False), ("assert a in sorted(b)", False)])
def test_the_rule_is_this(line, is_wrong):
    assert bool(unordered(f"\n{line}")) == is_wrong

"""Counters of the hardware that step in both directions: each claims that it never wraps."""

import ast

import pytest

from tb.sources.source_texts import source_texts


def unclaimed(text):
    """What a text assigns ``x.eq(x + ups - downs)`` without ``claim_steps(m, x, ...)``."""
    counted, claimed = set(), set()
    for node in ast.walk(ast.parse(text)):
        if not (isinstance(node, ast.Call) and node.args):
            continue
        if isinstance(node.func, ast.Name) and node.func.id == "claim_steps":
            claimed.add(ast.unparse(node.args[1]))
        elif isinstance(node.func, ast.Attribute) and node.func.attr == "eq":
            operand, steps = node.args[0], set()
            while isinstance(operand, ast.BinOp) and isinstance(operand.op, ast.Add | ast.Sub):
                steps.add(type(operand.op))
                operand = operand.left
            if len(steps) == 2 and ast.unparse(operand) == ast.unparse(node.func.value):
                counted.add(ast.unparse(operand))
    return sorted(counted - claimed)


def test_every_counter_of_the_hardware_claims_that_it_never_wraps():
    assert not {path: names for path, text in source_texts("hw").items() if (names := unclaimed(text))}


@pytest.mark.parametrize(("text", "names"), [
    ("a.eq(a + b - c)", ["a"]), ("s.a.eq(s.a + b + d - c)\nclaim_steps(m, a, up=b)", ["s.a"]),
    ("a.eq(a + b - c)\nclaim_steps(m, a, up=b)", []), ("a.eq(a - 1)", []), ("a.eq(b + c - d)", [])])
def test_a_counter_without_its_claim_is_found(text, names):
    assert unclaimed(text) == names

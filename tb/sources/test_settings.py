"""Every test that Hypothesis gives examples draws them from a nightly's seed."""

import ast
import re

from tb.sources.source_texts import source_texts

SHARED = "tb/lib/schedules.py"


def own_settings(tree):
    """Lines of settings that are not made from the shared ones, or that choose themselves what is drawn."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("settings", "hypothesis.settings"):
            shared = node.args and ast.unparse(node.args[0]) == "SETTINGS"
            if not shared or {"derandomize", "database"} & {word.arg for word in node.keywords}:
                yield node.lineno


def without_settings(tree):
    """Lines of functions that Hypothesis gives examples by its own settings, which draw anew in every run."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            decorators = [one.func if isinstance(one, ast.Call) else one for one in node.decorator_list]
            names = [one.id for one in decorators if isinstance(one, ast.Name)]
            if "given" in names and not any(name == "settings" or name.isupper() for name in names):
                yield node.lineno


def test_settings_are_the_shared_ones():
    wrong = [f"{path}:{line}" for path, text in source_texts("tb").items()
             if path != SHARED and re.search(r"\bsettings\(|@given\b", text)
             for line in (*own_settings(ast.parse(text)), *without_settings(ast.parse(text)))]
    assert not wrong


def test_the_check_sees_settings():
    tree = ast.parse("\n".join((
        "settings(max_examples=3)", "settings(SETTINGS, derandomize=True)", "settings(SETTINGS, max_examples=3)")))
    assert list(own_settings(tree)) == [1, 2]


def test_the_check_sees_tests_without_settings():
    tree = ast.parse("\n".join((
        "@given(a)", "def f(a):", "    pass", "@SETTINGS", "@given(a)", "def g(a):", "    pass",
        "@settings(SETTINGS, max_examples=3)", "@given(a)", "def h(a):", "    pass")))
    assert list(without_settings(tree)) == [2]

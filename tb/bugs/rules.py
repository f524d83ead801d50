"""Rules by which bugs are made: each replaces the text of a node, or of neighbouring ones."""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from tb.bugs.source import Source

__all__ = ["Change", "changes"]

# By class of an operator its text, and the text that replaces it.
_BINARY = {ast.Add: "+-", ast.Sub: "-+", ast.Mult: "*+", ast.BitAnd: "&|", ast.BitOr: "|&",
           ast.LShift: ("<<", ">>"), ast.RShift: (">>", "<<")}
_COMPARED = {ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">"),
             ast.Eq: ("==", "!="), ast.NotEq: ("!=", "==")}
_BOOLEAN = {ast.And: ("and", "or"), ast.Or: ("or", "and")}
_OPPOSITES = [("min", "max"), ("any", "all"), ("minimum", "maximum"), ("floor", "ceil"), ("argmin", "argmax")]
_OPPOSITE = {**dict(_OPPOSITES), **{right: left for left, right in _OPPOSITES}}
_SIDES = {"left": "right", "right": "left"}
_OPERATORS = (ast.BinOp, ast.UnaryOp, ast.Compare, ast.BoolOp)
_PLAIN = (ast.Name, ast.Attribute, ast.Subscript)
_WIDTHS = {"Signal", "unsigned", "signed", "In", "Out"}
# Their attributes are of no kind in common; outputs of a component in place of inputs are combinational loops.
_NO_RECORDS = ("self", "np", "math", "m", "ast", "wiring", "stream")
_CHECKED = (ast.Raise, ast.Continue, ast.Break, ast.Return)


@dataclass(frozen=True, kw_only=True)
class Change:
    """A text that replaces another one.

    Parameters
    ----------
    rule
        By which.
    node
        Of the old text, or the first one of it.
    begin, end
        Where the old text is.
    new
        The new one.
    kind
        "expression", "statement" (the new text is ``pass``), "order" (of two statements), "element" of a list that is
        gone, or "part": none of these.
    """

    rule: str
    node: ast.AST
    begin: int
    end: int
    new: str
    kind: str = "expression"


def changes(source: Source) -> list[Change]:
    """All bugs that the rules make of a file, alone."""
    found = []
    for node in source.places:
        for rule in _RULES:
            for made in rule(source, node):
                new, kind, *at = (made, "expression") if isinstance(made, str) else made
                begin, end = at[0] if at else source.span(node)
                found.append(Change(rule=rule.__name__[1:], node=at[1] if at[1:] else node, begin=begin, end=end,
                                    new=new, kind=kind))
    return found


def _spliced(source, node, *parts):
    """A node's text with other texts at some spans of it; in parentheses where an operator is around it."""
    begin, end = source.span(node)
    text, at = "", begin
    for (left, right), new in sorted(parts):
        text += source.data[at:left].decode() + new
        at = right
    text += source.data[at:end].decode()
    is_operand = isinstance(node, _OPERATORS) and isinstance(source.parent[node], _OPERATORS)
    return f"({text})" if is_operand else text


def _between(source, node, left, right, old, new):
    """A node's text with another operator between two operands."""
    begin, end = source.span(left)[1], source.span(right)[0]
    gap = source.data[begin:end].decode()
    return _spliced(source, node, ((begin, end), gap.replace(old, new, 1)))


def _swapped(source, node, left, right):
    """A node's text with two of its parts exchanged."""
    return _spliced(source, node, (source.span(left), source.of(right)), (source.span(right), source.of(left)))


def _operators(source: Source, node) -> Iterator:
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        sides = node.left, node.right
        if not any(isinstance(one, ast.List | ast.JoinedStr) or _is_text(one) for one in sides):
            yield _between(source, node, *sides, *_BINARY[type(node.op)])
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.FloorDiv):
        outer = source.parent[node]
        if not (isinstance(outer, ast.UnaryOp) or isinstance(node.left, ast.UnaryOp)):
            yield f"(-(-({source.of(node.left)}) // ({source.of(node.right)})))"
    elif isinstance(node, ast.Compare):
        for op, (left, right) in zip(node.ops, pairwise((node.left, *node.comparators)), strict=True):
            if type(op) in _COMPARED and not _is_text(right):
                yield _between(source, node, left, right, *_COMPARED[type(op)])
    elif isinstance(node, ast.BoolOp):
        for left, right in pairwise(node.values):
            yield _between(source, node, left, right, *_BOOLEAN[type(node.op)])
    elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub) and not _domain(node):
        yield _between(source, node, node.target, node.value, *_BINARY[type(node.op)]), "part"
    elif isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in _OPPOSITE:
            end = source.span(node.func)[1]
            yield _spliced(source, node, ((end - len(name), end), _OPPOSITE[name]))
    elif _is_text(node) and node.value in _SIDES and isinstance(source.parent[node], ast.keyword):
        yield repr(_SIDES[node.value])


def _constants(source: Source, node) -> Iterator:
    if isinstance(node, ast.Constant) and type(node.value) is int:
        if isinstance(source.parent[node], ast.UnaryOp):
            return
        form = hex if source.of(node).startswith("0x") else str
        yield form(node.value + 1)
        if node.value > 0:
            yield form(node.value - 1)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant) \
            and type(node.operand.value) is int and not isinstance(source.parent[node], ast.BinOp):
        yield str(-node.operand.value - 1)
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield str(not node.value)


def _widths(source: Source, node) -> Iterator:
    is_hardware = source.path.startswith("hw/")
    if isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name == "bit_length":
            yield f"({source.of(node)} - 1)"
        elif (name == "range" and len(node.args) == 1 and not isinstance(node.args[0], ast.Constant | ast.Starred)) or (
                is_hardware and name in _WIDTHS and node.args and isinstance(node.args[0], _PLAIN + _OPERATORS)):
            yield _spliced(source, node, (source.span(node.args[0]), f"{_closed(source, node.args[0])} - 1"))
    elif isinstance(node, ast.Slice):
        for side, step in ((node.lower, "+ 1"), (node.upper, "- 1")):
            if side is not None and isinstance(side, _PLAIN + _OPERATORS[:1] + (ast.Call,)):
                yield _spliced(source, node, (source.span(side), f"{_closed(source, side)} {step}")), "part"


def _conditions(source: Source, node) -> Iterator:
    if isinstance(node, ast.BoolOp):
        for one in node.values:
            rest = [_closed(source, other) for other in node.values if other is not one]
            yield f"({f' {_BOOLEAN[type(node.op)][0]} '.join(rest)})"
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd | ast.BitOr) and source.path.startswith("hw/"):
        yield f"({source.of(node.left)})"
        yield f"({source.of(node.right)})"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.Invert):
        yield f"({source.of(node.operand)})"
    elif isinstance(node, ast.comprehension):
        for one in node.ifs:
            yield "True", "expression", source.span(one)
    elif isinstance(node, ast.If) and not node.orelse and isinstance(node.body[0], _CHECKED) and len(node.body) == 1:
        yield "False", "expression", source.span(node.test)
    elif isinstance(node, ast.Call) and ast.unparse(node.func) == "m.If" and not isinstance(node.args[0], ast.BinOp):
        yield "1", "expression", source.span(node.args[0])


def _swaps(source: Source, node) -> Iterator:
    if isinstance(node, ast.Call):
        values = [pairwise(node.args), pairwise(one.value for one in node.keywords if one.arg)]
        for left, right in (pair for pairs in values for pair in pairs):
            if isinstance(left, _PLAIN) and isinstance(right, _PLAIN) and source.of(left) != source.of(right) \
                    and not (isinstance(left, ast.Name) and left.id in ("m", "self")):
                yield _swapped(source, node, left, right)
        if getattr(node.func, "id", "") == "Mux" and len(node.args) == 3 \
                and not all(isinstance(one, _PLAIN) for one in node.args[1:]):
            yield _swapped(source, node, *node.args[1:])
    elif isinstance(node, ast.IfExp):
        yield _swapped(source, node, node.body, node.orelse)
    elif isinstance(node, ast.Tuple) and not isinstance(source.parent[node], ast.Subscript | ast.For):
        for left, right in pairwise(node.elts):
            if isinstance(left, _PLAIN) and isinstance(right, _PLAIN) and source.of(left) != source.of(right):
                kind = "expression" if isinstance(node.ctx, ast.Load) else "part"
                yield _swapped(source, node, left, right), kind
    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load) and not _is_called(source, node):
        function = source.function(node)
        base = source.of(node.value)
        names = sorted({one.attr for one in ast.walk(function or ast.Module(body=[], type_ignores=[]))
                        if isinstance(one, ast.Attribute) and isinstance(one.ctx, ast.Load)
                        and not _is_called(source, one) and source.of(one.value) == base} - {"d", "submodules"})
        if len(names) > 1 and node.attr in names and base not in _NO_RECORDS:
            end = source.span(node)[1]
            other = names[(names.index(node.attr) + 1) % len(names)]
            yield _spliced(source, node, ((end - len(node.attr.encode()), end), other))


def _order(source: Source, node) -> Iterator:
    body = getattr(node, "body", None)
    for first, second in pairwise(body) if isinstance(body, list) else ():
        if not all(isinstance(one, ast.Assign | ast.AugAssign | ast.Expr) for one in (first, second)):
            continue
        written = [_written(one) for one in (first, second)]
        # Not by positions: within an f-string they are others.
        reads = [{ast.unparse(part) for part in ast.walk(one) if isinstance(part, _PLAIN)} for one in (first, second)]
        depends = (written[0] & (reads[1] | written[1])) | (written[1] & reads[0])
        # What the first one binds at first, the second one cannot do without.
        if depends and not any(name in reads[1] and _is_first(source, first, name) for name in written[0]):
            begin, end = source.span(first)[0], source.span(second)[1]
            gap = source.data[source.span(first)[1]:source.span(second)[0]].decode()
            yield f"{source.of(second)}{gap}{source.of(first)}", "order", (begin, end)


def _state(source: Source, node) -> Iterator:
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Signal" and source.path.startswith("hw/"):
        given = {one.arg: one.value for one in node.keywords}
        end = source.span(node)[1] - 1
        comma = ", " if node.args or node.keywords else ""
        if "reset_less" not in given and _is_register(source, node):
            yield _spliced(source, node, ((end, end), f"{comma}reset_less=True"))
        if "init" not in given:
            yield _spliced(source, node, ((end, end), f"{comma}init=1"))
        elif source.of(given["init"]) != "0":
            yield _spliced(source, node, (source.span(given["init"]), "0"))


def _is_register(source, node):
    """Whether a new signal's name is assigned to in a clock's domain."""
    outer = source.parent[node]
    values = outer.elts if isinstance(outer, ast.Tuple) else [node]
    statement = source.parent[outer] if isinstance(outer, ast.Tuple) else outer
    if not isinstance(statement, ast.Assign) or source.function(node) is None:
        return False
    target = statement.targets[0]
    name = ast.unparse(target.elts[values.index(node)] if isinstance(target, ast.Tuple) else target)
    return any(name in _written(one) for one in ast.walk(source.function(node))
               if _domain(one) and one.target.attr == "sync")


def _dropped(source: Source, node) -> Iterator:
    if isinstance(node, ast.Continue | ast.Break):
        yield "pass", "part"
    elif isinstance(node, ast.AugAssign):
        values = node.value.elts if _domain(node) and isinstance(node.value, ast.List) else []
        if not values:
            yield "pass", "statement"
        for index, one in enumerate(values if len(values) > 1 else ()):
            begin, end = source.span(one)
            if index + 1 < len(values):
                end = source.span(values[index + 1])[0]
            else:
                begin = source.span(values[index - 1])[1]
            yield "", "element", (begin, end), one
    elif (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)) or (
            isinstance(node, ast.Assign) and source.function(node) is not None
            and not _is_first(source, node, source.of(node.targets[0]))):
        yield "pass", "statement"


_RULES = (_operators, _constants, _widths, _conditions, _swaps, _order, _state, _dropped)


def _is_text(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _closed(source, node):
    """The text of a node as an operand."""
    return f"({source.of(node)})" if isinstance(node, (*_OPERATORS, ast.IfExp, ast.Lambda)) else source.of(node)


def _is_called(source, node):
    outer = source.parent.get(node)
    return isinstance(outer, ast.Call) and outer.func is node


def _domain(node):
    """Whether a statement adds to a domain of a module."""
    return isinstance(node, ast.AugAssign) and re.match(r"m\.d\b", ast.unparse(node.target)) is not None


def _written(statement):
    """Texts of what a statement assigns to, or changes by a method."""
    if isinstance(statement, ast.Assign):
        return {ast.unparse(one) for target in statement.targets for one in ast.walk(target) if isinstance(one, _PLAIN)}
    if isinstance(statement, ast.AugAssign):
        if not _domain(statement):
            return {ast.unparse(statement.target)}
        return {ast.unparse(one.func.value) for one in ast.walk(statement.value) if isinstance(one, ast.Call)
                and isinstance(one.func, ast.Attribute) and one.func.attr == "eq"}
    call = statement.value
    is_method = isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
    return {ast.unparse(call.func.value)} - {"m", "wiring"} if is_method else set()


def _is_first(source, statement, name):
    """Whether no statement before one of its function binds a name."""
    function = source.function(statement)
    if function is None or not name.isidentifier():
        return function is None
    arguments = {one.arg for one in ast.walk(function.args) if isinstance(one, ast.arg)}
    begin = source.span(statement)[0]
    return name not in arguments and not any(
        isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store) and one.id == name and source.span(one)[0] < begin
        for one in ast.walk(function))

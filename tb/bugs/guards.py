"""Conditions under which alone a bug shows: a large configuration, or a second event.

The old text runs where the condition does not hold, so what differs is the combination alone. A condition is made of
what is bound where the bug is, and of nothing that the bug changes.
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce

from golden.engine.config import PRESETS
from tb.bugs.rules import Change
from tb.bugs.source import Source

__all__ = ["LARGE", "SMALL", "Guard", "guarded", "guards"]

# Presets: that of most tests, and one in which whatever is large is larger.
SMALL, LARGE = "small", "large"

# Behind the sources of a file, so that no line moves. In hardware the choice has the shape of the old value, and a
# register counts the cycles in which an arm was chosen.
_AGAIN = '''

def _bug_again(owner, seen={}):  # noqa: B006
    """Whether this has been called before for the same object."""
    is_known = id(owner) in seen
    seen[id(owner)] = owner
    return is_known
'''
_CHOICE = '''

def _bug_choice(condition, new, old):
    """One of two values by a register, with the shape of the old one."""
    from amaranth.hdl import Mux, Value
    new, old = Value.cast(new), Value.cast(old)
    chosen = Mux(condition, new, old)[:len(old)]
    return chosen.as_signed() if old.shape().signed else chosen


def _bug_earlier(m, event, count):
    """Whether an event has occurred in so many earlier cycles."""
    from amaranth.hdl import Signal
    seen = Signal(range(count + 1))
    with m.If(event & (seen != count)):
        m.d.sync += seen.eq(seen + 1)
    return seen == count
'''
_COUNTS = re.compile(r"\b(nodes|clusters|count|counts|rows|columns|blocks|size|samples|depth|processes|parts|steps|"
                     r"workers|rays|cells|patches|bounces|width|height|levels|length|number|total)$")
_LOOPS = (ast.For, ast.While, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
# Run once for an object, whose attributes are not there yet.
_ONCE = ("__init__", "__post_init__")
_ENDS = (ast.Raise, ast.Return, ast.Continue, ast.Break)
_PURE = (ast.Name, ast.Attribute, ast.Compare, ast.BoolOp, ast.UnaryOp, ast.Constant, ast.Load, ast.cmpop, ast.boolop,
         ast.unaryop)


@dataclass(frozen=True, kw_only=True)
class Guard:
    """A condition of a bug.

    Parameters
    ----------
    kind
        "configuration", "size", "option", "feature", "iteration", "call"; in hardware "register" and "cycle".
    condition
        Its text.
    helper
        Text behind the file.
    loop
        Span and new text of a loop that counts its iterations.
    """

    kind: str
    condition: str
    helper: str = ""
    loop: tuple[int, int, str] | None = None


def guards(source: Source, change: Change) -> list[Guard]:
    """All conditions that can be put to a bug."""
    function = source.function(change.node)
    if function is None or change.kind == "part":
        return []
    found = list(_configurations(source, change, function))
    if _hardware(source, change):
        is_list = change.kind == "element" and not (isinstance(change.node, ast.Call) and change.node.args)
        return found if is_list else [*found, *_registers(source, change, function), *_cycles(source, change)]
    if "import amaranth" in source.text or "from amaranth" in source.text:
        return found
    is_compiled = any("compiled" in ast.unparse(one) for one in function.decorator_list)
    found += [*_sizes(function), *_features(source, change, function), *_iterations(source, change, function)]
    is_repeated = any(isinstance(one, _LOOPS) for one in _inside(source, change, function))
    if not (is_compiled or is_repeated or function.name in _ONCE):
        owner = "self" if "self" in _arguments(function) else "None"
        found.append(Guard(kind="call", condition=f"_bug_again({owner})", helper=_AGAIN))
    return found


def guarded(source: Source, change: Change, guard: Guard) -> tuple[int, int, str] | None:
    """Span and text of a bug that shows under a condition alone, or nothing where the two do not fit."""
    old, condition = source.data[change.begin:change.end].decode(), guard.condition
    is_register = guard.helper == _CHOICE
    if change.kind == "statement":
        begins = f"with m.If(~({condition})): " if is_register else f"if not ({condition}): "
        return change.begin, change.end, begins + old
    if change.kind == "element":
        return *source.span(change.node), _element(source, change.node, condition, is_register)
    if change.kind == "expression":
        new = f"_bug_choice({condition}, {change.new}, {old})" if is_register else \
            f"({change.new} if {condition} else {old})"
        return change.begin, change.end, new
    if is_register:
        return None
    indent = " " * change.node.col_offset
    new, old = (re.sub(r"\n(?=.)", "\n    ", text) for text in (change.new, old))
    return change.begin, change.end, f"if {condition}:\n{indent}    {new}\n{indent}else:\n{indent}    {old}"


def _element(source, node, condition, is_register):
    """One of a list of assignments without what it does under a condition: a register keeps its value, a net is 0."""
    text = source.of(node)
    if not is_register:
        return f"*([] if {condition} else [{text}])"
    target, value = source.of(node.func.value), ", ".join(source.of(one) for one in node.args)
    domain = next(one for one in source.around(node) if isinstance(one, ast.AugAssign)).target.attr
    return f"{target}.eq(_bug_choice({condition}, {0 if domain == 'comb' else target}, {value}))"


def _hardware(source, change):
    """The statement or condition of a module that a bug is in, if registers of the module can decide about it."""
    for one in (change.node, *source.around(change.node)):
        if isinstance(one, ast.Lambda):
            return None
        if (isinstance(one, ast.AugAssign) and ast.unparse(one.target).startswith("m.d.")) or (
                isinstance(one, ast.Call) and ast.unparse(one.func) in ("m.If", "m.Elif")):
            return one
    return None


def _configurations(source, change, function) -> Iterator[Guard]:
    """A field of the configuration that the class or file reads is larger than in the preset `SMALL`."""
    owner = source.class_of(change.node)
    arguments, is_method = _arguments(function), "self" in _arguments(function) and function.name != "__init__"
    keeps = owner is not None and re.search(r"self\._config\b.* = ", source.of(owner)) is not None
    root = "config" if "config" in arguments else "self._config" if is_method and keeps else ""
    chains = set(re.findall(r"(?:\b|_)config\.((?:\w+\.)?\w+)\b(?!\()", source.of(owner) if owner else source.text)
                 if root else ())
    for chain in sorted(chains):
        values = {name: _field(config, chain) for name, config in PRESETS.items()}
        if all(type(value) is int for value in values.values()) and values[LARGE] > values[SMALL]:
            yield Guard(kind="configuration", condition=f"{root}.{chain} > {values[SMALL]}")


def _field(config, chain):
    try:
        return reduce(getattr, chain.split("."), config)
    except AttributeError:
        return None


def _sizes(function) -> Iterator[Guard]:
    """More than a few items, or a count above a bound."""
    for one in _parameters(function):
        kind = ast.unparse(one.annotation) if one.annotation is not None else ""
        if re.match(r"(np\.ndarray|list|tuple|Sequence|Mapping|dict)", kind):
            yield from (Guard(kind="size", condition=f"len({one.arg}) > {bound}") for bound in (1, 4))
        elif kind == "int" and _COUNTS.search(one.arg):
            yield from (Guard(kind="size", condition=f"{one.arg} > {bound}") for bound in (1, 4))


def _features(source, change, function) -> Iterator[Guard]:
    """An option is given, or a condition elsewhere in the function holds."""
    named = [*function.args.posonlyargs, *function.args.args]
    given = [*zip(reversed(named), reversed(function.args.defaults), strict=False),
             *zip(function.args.kwonlyargs, function.args.kw_defaults, strict=True)]
    for one, default in given:
        if isinstance(default, ast.Constant) and isinstance(default.value, bool):
            yield Guard(kind="option", condition=f"{'not ' if default.value else ''}{one.arg}")
        elif isinstance(default, ast.Constant):
            differs = "is not None" if default.value is None else f"!= {default.value!r}"
            yield Guard(kind="option", condition=f"{one.arg} {differs}")
    stored = {one.id for one in ast.walk(function) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)}
    bound = _arguments(function) - stored - ({"self"} if function.name in _ONCE else set())
    inside = set(_inside(source, change, function))
    for one in ast.walk(function):
        if isinstance(one, ast.If | ast.IfExp) and one not in inside and one.test is not change.node:
            # Behind a condition that ends the function it never holds.
            if isinstance(one, ast.If) and isinstance(one.body[-1], _ENDS):
                continue
            parts = list(ast.walk(one.test))
            names = {part.id for part in parts if isinstance(part, ast.Name)}
            if names and names <= bound and all(isinstance(part, _PURE) for part in parts):
                text = source.of(one.test)
                yield from (Guard(kind="feature", condition=form) for form in (f"({text})", f"(not ({text}))"))


def _iterations(source, change, function) -> Iterator[Guard]:
    """Not the first ones of a loop's iterations."""
    clause = None
    for one in _inside(source, change, function):
        if isinstance(one, ast.comprehension):
            clause = one
        if isinstance(one, ast.For):
            loop, inside = one, change.begin > source.span(one.iter)[1]
        elif isinstance(one, _LOOPS[2:]):
            # Conditions and the element are in the last one of its loops.
            loop = one.generators[-1]
            inside = clause in (None, loop) and (
                change.end <= source.span(loop.target)[0] or change.begin >= source.span(loop.iter)[1])
        else:
            continue
        if inside and not re.match(r"(prange|numba\.)", source.of(loop.iter)):
            begin, end = source.span(loop.target)[0], source.span(loop.iter)[1]
            target = source.of(loop.target)
            # `for a, b in` needs parentheses beside the count.
            target = f"({target})" if isinstance(loop.target, ast.Tuple) and target[0] != "(" else target
            text = f"bug_number, {target} in enumerate({source.of(loop.iter)})"
            yield from (Guard(kind="iteration", condition=f"bug_number > {count}", loop=(begin, end, text))
                        for count in (0, 3))
        return


def _registers(source, change, function) -> Iterator[Guard]:
    """A register is, or is not, 0; a counter is above 1.

    Neither a condition around the bug reads it, nor the assignment or condition that the bug is in.
    """
    statement, chain = _hardware(source, change), [change.node, *source.around(change.node)]
    below = [one for one in chain[:chain.index(statement)] if not isinstance(one, ast.List)] or [statement]
    tested = " ".join(source.of(one) for one in (
        below[-1], *(one.items[0].context_expr for one in chain if isinstance(one, ast.With))))
    site = source.span(statement)[0]
    local = {one.id for one in ast.walk(function) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)
             and source.span(one)[0] < site} | _arguments(function)
    seen = set()
    for one in ast.walk(function):
        if not (isinstance(one, ast.AugAssign) and ast.unparse(one.target) == "m.d.sync"):
            continue
        for call in ast.walk(one.value):
            is_assignment = isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) \
                and call.func.attr == "eq"
            name = source.of(call.func.value) if is_assignment else ""
            if not re.fullmatch(r"\w+(\.\w+)*", name) or name.partition(".")[0] not in local or name in seen \
                    or re.search(rf"(?<![\w.]){re.escape(name)}\b", tested):
                continue
            seen.add(name)
            bounds = ["!= 0", "== 0"]
            if any(f"{name} {sign}" in source.of(call) for sign in "+-"):
                bounds.append("> 1")
            yield from (Guard(kind="register", condition=f"({name} {bound})", helper=_CHOICE) for bound in bounds)


def _cycles(source, change) -> Iterator[Guard]:
    """What the bug is in has occurred in earlier cycles."""
    site = _hardware(source, change)
    if isinstance(site, ast.Call):
        # Statements between an `If` and its `Elif` are not allowed.
        event = source.of(site.args[0]) if site.func.attr == "If" else ""
    else:
        arms = [one for one in source.around(site) if isinstance(one, ast.With)]
        event = "1" if arms else ""
    if event:
        yield from (Guard(kind="cycle", condition=f"_bug_earlier(m, ({event}), {count})", helper=_CHOICE)
                    for count in (1, 4))


def _parameters(function):
    return [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]


def _arguments(function):
    return {one.arg for one in _parameters(function)}


def _inside(source, change, function):
    """What a bug is in, up to its function."""
    for one in source.around(change.node):
        if one is function:
            return
        yield one

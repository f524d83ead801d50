"""Docstrings of components: their members are the signature's, each with its direction and shape."""

import inspect
import re
from types import MappingProxyType
from unittest import mock

import pytest
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import PRESETS
from hw.noc.input_queue import InputQueue
from radiosity.flow.package.tops import TOPS
from tb.docs.contents import makers
from tb.docs.structure import component_classes, structures

# Sections of a component's docstring, in their order.
SECTIONS = ("Parameters", "Members", "Timing", "Raises")
# Ports of a design are members of the class that Verilator makes of it.
VERILATED = {"contextp", "eval", "eval_end_step", "eval_step", "final", "name", "threads", "trace"}
# Its members are those of the component that it stands for.
GENERIC = {"hw/lib/black_box.py"}
# Components that are in none of them.
UNUSED = {"radiosity.flow.synthesis.scan_harness.ScanHarness"}


def sections(cls):
    """Titles and bodies of a docstring."""
    parts = re.split(r"(?m)^(\w[\w ]*)\n-{3,}\n", inspect.getdoc(cls) or "")
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def entries(cls):
    """Directions and shapes of members, by name or, for ``o_<level>``, by pattern; two names may have one each.

    Lines that are not indented name members; ``;`` separates several of one line.
    """
    found = {}
    for line in re.findall(r"(?m)^\S.*$", sections(cls).get("Members", "")):
        for entry in line.split("; "):
            names, _, rest = entry.partition(" : ")
            names = [re.sub(r"<\w+>", r"\\w+", name) for name in names.split(", ")]
            directions, shape = re.match(r"((?:(?:In|Out)\b(?:, )?)*)(.*)", rest).groups()
            directions = [one for one in directions.split(", ") if one] or [""]
            directions *= len(names) if len(directions) == 1 else 1
            found |= {name: (direction, shape) for name, direction in zip(names, directions, strict=False)}
    return found


def faults(cls, members):
    """What is wrong with a docstring, given the members of each instance that was made."""
    present = list(sections(cls))
    if present != [title for title in SECTIONS if title in present]:
        yield f"sections {present}"
    listed, always, ever = entries(cls), set.intersection(*map(set, members)), set().union(*members)

    def entry(name):
        return next((found for pattern, found in listed.items() if re.fullmatch(pattern, name)), None)

    yield from (f"no member {name}" for name in listed if not any(re.fullmatch(name, member) for member in ever))
    yield from (f"{name} is not listed" for name in sorted(ever) if entry(name) is None)
    yield from (f"{name} is a method of Verilator's models" for name in sorted(ever & VERILATED))
    for name in sorted(always):
        # All members of a pattern without a fixed part are described in words.
        if entry(name) is None or listed.get("\\w+") == entry(name):
            continue
        member, (direction, shape) = members[0][name], entry(name)
        if direction != ("In" if member.flow is In else "Out"):
            yield f"{name}: direction {direction!r}"
        elif not shape:
            yield f"{name}: no shape"
        elif member.is_signature and isinstance(member.signature, stream.Signature) and "stream" not in shape:
            yield f"{name}: no stream"


@pytest.fixture(scope="module")
def made():
    """By class: the members of its instances in an engine, a board and the units that are measured."""
    found: dict[type, list[dict]] = {}
    original = wiring.Component.__init__

    def note(self, *arguments, **given):
        original(self, *arguments, **given)
        found.setdefault(type(self), []).append(dict(self.signature.members.items()))

    # With patch stores, subshell lists and shadow frusta, which no preset has together. Patch nodes are measured alone.
    config = PRESETS["small"].replace({"ctu.subshell_bits": 10, "ctu.subshell_barrier": 1, "icu.shadow_bits": 8})
    with mock.patch.object(wiring.Component, "__init__", note):
        # Exported routers have their node as an input, and so have their queues.
        structures([*makers(config), lambda: TOPS["router"].make(config),
                    lambda: InputQueue(bits=8, depth=2, routes={0: 0, 3: 1}, node_bits=1)], has_links=False)
    return found


def test_components_are_made(made):
    missing = {name for name, cls in component_classes().items() if cls not in made}
    assert missing <= UNUSED


def test_members_are_those_of_the_signature(made):
    wrong = {name: list(faults(cls, made[cls])) for name, cls in component_classes().items() if cls in made}
    wrong = {name: found for name, found in wrong.items() if found and _file(name) not in GENERIC}
    assert not wrong


def _file(name):
    return name.rpartition(".")[0].replace(".", "/") + ".py"


class Documented:
    """A component.

    Members
    -------
    a, b : In(1)
        Two bits.
    o : Out, stream of ``x``
        Items.
    """

    members = MappingProxyType({"a": In(1), "b": In(1), "o": Out(stream.Signature(1))})


def test_a_right_docstring_passes():
    assert not list(faults(Documented, [Documented.members]))


@pytest.mark.parametrize(("right", "wrong", "fault"), [
    ("a, b : In(1)", "a : In(1)", "b is not listed"),
    ("a, b : In(1)", "a, b, c : In(1)", "no member c"),
    ("a, b : In(1)", "a, b : In, Out, one bit each", "b: direction 'Out'"),
    ("a, b : In(1)", "a : In(1); c_<k> : In(1)", "no member c_\\w+"),
    ("a, b : In(1)", "a, b : In", "a: no shape"),
    ("a, b : In(1)", "a, b", "a: direction ''"),
    ("o : Out, stream", "o : In, stream", "o: direction 'In'"),
    ("o : Out, stream of", "o : Out,", "o: no stream"),
    ("Members\n    -------", "Errors\n    ------", "sections ['Errors']"),
])
def test_faults_are_found(right, wrong, fault):
    component = type("Wrong", (Documented,), {"__doc__": Documented.__doc__.replace(right, wrong)})
    assert fault in list(faults(component, [Documented.members]))


def test_a_port_that_verilator_cannot_name_is_found():
    component = type("Wrong", (Documented,), {"__doc__": Documented.__doc__.replace("a, b :", "a, b, final :")})
    found = list(faults(component, [Documented.members | {"final": In(1)}]))
    assert found == ["final is a method of Verilator's models"]

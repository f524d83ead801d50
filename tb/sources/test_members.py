"""Docstrings of components: their members are the signature's, each with its direction and shape."""

import inspect
import re
from types import MappingProxyType
from unittest import mock

import pytest
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PRESETS
from tb.docs.contents import makers
from tb.docs.structure import component_classes, structures

# Sections of a component's docstring, in their order.
SECTIONS = ("Parameters", "Members", "Timing", "Raises")
# Files whose docstrings do not comply yet.
UNFINISHED: set[str] = {
    "hw/ctu/cell_number.py", "hw/ctu/cell_steps.py", "hw/ctu/cell_traversal.py", "hw/ctu/ct_ray_generator.py",
    "hw/ctu/grid_direction.py", "hw/ctu/grid_entries.py", "hw/ctu/group_split.py", "hw/ctu/near_window.py",
    "hw/ctu/position_search.py", "hw/ctu/ray_banks.py", "hw/ctu/ray_memory.py", "hw/ctu/ray_traversal.py",
    "hw/ctu/row_arcs.py", "hw/ctu/row_pieces.py", "hw/ctu/settle_sweep.py", "hw/ctu/square_scan.py",
    "hw/ctu/stage_count.py", "hw/ctu/stage_rows.py", "hw/ctu/subshell_generator.py", "hw/ctu/subshell_table.py",
    "hw/ctu/subshell_windows.py", "hw/ctu/survival.py", "hw/ctu/traversal_start.py", "hw/ctu/traversal_unit.py",
    "hw/icu/collector.py", "hw/icu/edge_planes.py", "hw/icu/g2r_transform.py", "hw/icu/ic_ray_generator.py",
    "hw/icu/intersection_pipeline.py", "hw/icu/intersection_unit.py", "hw/icu/inverse_distance.py",
    "hw/icu/inverse_distance_bound.py", "hw/icu/ipbb.py", "hw/icu/patch_queue.py", "hw/icu/patch_setup.py",
    "hw/icu/patch_slots.py", "hw/icu/plane_factor.py", "hw/icu/ray_direction.py", "hw/icu/ray_issue.py",
    "hw/icu/ray_memory.py", "hw/icu/read_out.py", "hw/icu/sbb.py", "hw/icu/screening.py", "hw/icu/section_clip.py",
    "hw/icu/settle_map.py", "hw/icu/spherical_coordinates.py", "hw/icu/uv_alignment.py", "hw/icu/uv_subdivision.py",
    "hw/icu/vertex_direction.py", "hw/icu/vertex_gather.py", "hw/icu/window_walk.py", "hw/lib/black_box.py",
    "hw/lib/reciprocal.py", "hw/lib/update_memory.py", "hw/memsys/deferred_store.py", "hw/memsys/istructure.py",
    "hw/noc/input_queue.py", "hw/noc/link_receiver.py", "hw/noc/link_sender.py", "hw/noc/network.py",
    "hw/noc/network_interface.py", "hw/noc/output_port.py", "hw/noc/packer.py", "hw/noc/patch_network.py",
    "hw/noc/router.py", "hw/noc/unpacker.py", "hw/registers/registers.py",
}
# Components that no preset makes.
UNUSED: set[str] = {"hw.lib.join.Join", "hw.synthesis.scan_harness.ScanHarness"}


def sections(cls):
    """Titles and bodies of a docstring."""
    parts = re.split(r"(?m)^(\w[\w ]*)\n-{3,}\n", inspect.getdoc(cls) or "")
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def entries(cls):
    """By member: what follows its name, without direction if none is given."""
    found = {}
    for line in re.findall(r"(?m)^(\w+(?:, \w+)*(?: :.*)?)$\n^ {4}\S", sections(cls).get("Members", "") + "\n"):
        names, _, rest = line.partition(" : ")
        found |= dict.fromkeys(names.split(", "), rest)
    return found


def faults(cls, members):
    """What is wrong with a docstring, given the members of each instance that was made."""
    told = list(sections(cls))
    if told != [title for title in SECTIONS if title in told]:
        yield f"sections {told}"
    listed, always, ever = entries(cls), set.intersection(*map(set, members)), set().union(*members)
    yield from (f"no member {name}" for name in sorted(listed.keys() - ever))
    yield from (f"{name} is not listed" for name in sorted(ever - listed.keys()))
    for name in sorted(always & listed.keys()):
        member = members[0][name]
        match = re.match(r"(In|Out)\b(.*)", listed[name])
        if match is None or (match[1] == "In") != (member.flow is In):
            yield f"{name}: direction in {listed[name]!r}"
        elif member.is_port and not re.match(r"\(.+\)", match[2]):
            yield f"{name}: shape in {listed[name]!r}"
        elif member.is_signature and isinstance(member.signature, stream.Signature) and "stream" not in match[2]:
            yield f"{name}: stream in {listed[name]!r}"


@pytest.fixture(scope="module")
def made():
    """By class: the members of its instances in an engine of each preset, a board and the units that are measured."""
    found: dict[type, list[dict]] = {}
    original = wiring.Component.__init__

    def note(self, *arguments, **given):
        original(self, *arguments, **given)
        found.setdefault(type(self), []).append(dict(self.signature.members.items()))

    with mock.patch.object(wiring.Component, "__init__", note):
        for preset in ("small", "thesis"):
            if preset in PRESETS:
                structures(makers(PRESETS[preset]))
    return found


def test_components_are_made(made):
    missing = {name for name, cls in component_classes().items() if cls not in made}
    assert missing <= UNUSED


def test_members_are_those_of_the_signature(made):
    wrong = {name: list(faults(cls, made[cls])) for name, cls in component_classes().items() if cls in made}
    wrong = {name: found for name, found in wrong.items() if found and _file(name) not in UNFINISHED}
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
    ("a, b : In(1)", "a, b : In", "a: shape in 'In'"),
    ("a, b : In(1)", "a, b", "a: direction in ''"),
    ("o : Out, stream", "o : In, stream", "o: direction in 'In, stream of ``x``'"),
    ("o : Out, stream of", "o : Out,", "o: stream in 'Out, ``x``'"),
    ("Members\n    -------", "Errors\n    ------", "sections ['Errors']"),
])
def test_faults_are_found(right, wrong, fault):
    component = type("Wrong", (Documented,), {"__doc__": Documented.__doc__.replace(right, wrong)})
    assert fault in list(faults(component, [Documented.members]))

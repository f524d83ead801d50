"""Verilog of components."""

import os
from collections.abc import Callable

from amaranth.back import verilog
from amaranth.hdl import Elaboratable
from amaranth.lib import wiring

from golden.base.without_collection import without_collection
from hw.lib.black_box import flatten
from hw.lib.checks import checked
from radiosity.flow.verilog.verilog_text import add_zero_loops, merge_equal_words, remove_empty_wires, wait_for_nothing
from radiosity.flow.verilog.zero_memories import omit_zeros

__all__ = ["verilog_of"]


def verilog_of(component: wiring.Component, name: str, *, port_name: Callable[[str], str] = str,
               is_checked: bool = False) -> str:
    """A component as the module ``name``, in SystemVerilog, with its checks (`hw.lib.checks`) if it ``is_checked``.

    Its ports have the names of its members, joined by two underscores, or what ``port_name`` makes of them.
    """
    os.environ["AMARANTH_USE_YOSYS"] = "builtin"
    # Of a million objects none is garbage, and searching takes more than half of an export's time.
    with checked(is_checked), omit_zeros() as omitted, without_collection():
        text = verilog.convert(_Flat(component, port_name), name=name, emit_src=False, strip_internal_attrs=True)
    return add_zero_loops(merge_equal_words(wait_for_nothing(remove_empty_wires(text))), len(omitted))


class _Flat(Elaboratable):
    """A component with the ports that its module shall have."""

    def __init__(self, component, port_name):
        self._component, members = component, {}
        for path, member, value in flatten(component):
            name = port_name(path)
            if name in members:
                raise ValueError(f"Names of ports must differ, not be {name} twice")
            members[name] = member.flow(len(value))
            setattr(self, name, value)
        self.signature = wiring.Signature(members)

    def elaborate(self, platform):
        return self._component

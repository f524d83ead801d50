"""The latencies of the units that a component has."""

from amaranth.hdl import Fragment
from amaranth.lib import wiring

from golden.base.without_collection import without_collection

__all__ = ["unit_latencies"]

# Folders of hw/ whose components are units; those of hw/lib/ are parts of them.
_BLOCKS = ("icu", "ctu", "memsys", "control", "registers", "noc")


def unit_latencies(*components: wiring.Component) -> dict[str, int]:
    """The latencies in cycles of some components and of all components inside them, by block and name.

    Left out are components without a latency, and those whose instances differ in it.
    """
    found = {}
    with without_collection():
        for component in components:
            _collect(Fragment.get(component, None), found)
    return {name: latencies.pop() for name, latencies in sorted(found.items()) if len(latencies) == 1}


def _collect(fragment, found):
    for origin in fragment.origins or ():
        block = type(origin).__module__.removeprefix("hw.").partition(".")[0]
        latency = getattr(origin, "latency", None)
        if block in _BLOCKS and latency is not None:
            found.setdefault(f"{block}.{type(origin).__name__}", set()).add(latency)
    for part, *_ in fragment.subfragments:
        _collect(part, found)

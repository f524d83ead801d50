"""The manifest of a core: what a program must know of it."""

import hashlib

from amaranth.lib.data import Layout
from amaranth.lib.wiring import In

from golden.base.package_version import package_version
from golden.engine.config import Config
from golden.engine.icu.patch_sums import SUM_BITS
from golden.engine.jobs.descriptor import VERSION as DESCRIPTOR_VERSION
from golden.engine.memory_map.layout import MAGIC as IMAGE_MAGIC
from golden.engine.memory_map.layout import REGIONS
from golden.engine.memory_map.layout import VERSION as IMAGE_VERSION
from hw.cluster import COUNTERS
from hw.lib.black_box import flatten
from hw.lib.inspection import inspect
from hw.memsys.bus.cache_policy import CachePolicy
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS, MAGIC, VERSION
from hw.registers.error_code import ABOUT, ErrorCode
from hw.registers.register import WORD_BYTES, Access, addresses
from radiosity.flow.package.flit_format import flit_format
from radiosity.flow.package.notice import COPYRIGHT, LICENCE
from radiosity.flow.package.port_names import port_name
from radiosity.flow.package.tops import TOPS
from radiosity.flow.package.unit_latencies import unit_latencies

__all__ = ["manifest"]


def manifest(top: str, name: str, *, config: Config, preset: str, text: str) -> dict[str, object]:
    """The manifest, as JSON has it.

    Parameters
    ----------
    top, name
        One of `TOPS`, and the name of its module.
    config, preset
        The configuration, and what it was made from.
    text
        The SystemVerilog.
    """
    ports = [{"name": "clk", "direction": "input", "width": 1}, {"name": "rst", "direction": "input", "width": 1}]
    ports += inspect(lambda: TOPS[top].make(config), _ports)
    facts = {
        "name": name, "about": TOPS[top].about, "version": package_version(), "licence": LICENCE,
        "copyright": COPYRIGHT, "preset": preset,
        "parameters": config.parameters(), "clock": {"port": "clk", "edge": "rising"},
        "reset": {"port": "rst", "active": "high", "synchronous": True}, "ports": ports,
        "latencies": unit_latencies(*(make(config) for make in (TOPS[top].make, *TOPS[top].parts))),
        "sha256": hashlib.sha256(text.encode()).hexdigest()}
    if TOPS[top].buses:
        facts["buses"] = [{"name": bus, "clock": {"port": f"{bus}_aclk", "edge": "rising"}, "reset": {
            "port": f"{bus}_aresetn", "active": "low", "synchronous": False}} for bus in TOPS[top].buses]
        facts["reset"]["synchronous"] = False
    if TOPS[top].is_engine:
        facts |= _program_view(config)
    if TOPS[top].is_network:
        facts["flit"] = flit_format(config)
    if TOPS[top].is_engine or top == "cluster":
        facts["counters"] = {"names": list(COUNTERS), "base": COUNTERS_BASE, "stride": WORD_BYTES << COUNTER_BITS}
    return facts


def _ports(component):
    """Names, directions, widths and fields."""
    ports = []
    for path, member, value in flatten(component):
        ports.append({"name": port_name(path), "direction": "input" if member.flow is In else "output",
                      "width": len(value)})
        if isinstance(member.shape, Layout):
            ports[-1]["fields"] = list(_fields(member.shape))
    return ports


def _fields(layout, path="", low=0):
    """Names, lowest bits and widths of what has no parts."""
    for key, field in layout:
        name = f"{path}.{key}" if path else str(key)
        if isinstance(field.shape, Layout):
            yield from _fields(field.shape, name, low + field.offset)
        elif field.width:
            yield {"name": name, "low": low + field.offset, "width": field.width}


def _program_view(config):
    """What a driver needs: registers, error codes, and the formats in main memory."""
    offsets, numbers = addresses(ENGINE_REGISTERS), config.numbers
    return {
        "formats": {"registers": {"magic": MAGIC, "version": VERSION},
                    "image": {"magic": IMAGE_MAGIC, "version": IMAGE_VERSION},
                    "descriptor": {"version": DESCRIPTOR_VERSION}},
        "registers": [{"name": one.name, "address": offsets[one.name], "bits": one.width, "access": one.access.value,
                       **_reset(one), "about": one.about, "fields": _bits(one)} for one in ENGINE_REGISTERS],
        "results": {"inverse": {"fraction_bits": numbers.fraction_bits, "exponent_bits": numbers.exponent_bits,
                                "bias": numbers.inverse_bias},
                    "uv_bits": config.icu.uv_bits, "sum_bits": SUM_BITS},
        "policies": {one.name.lower(): one.value for one in CachePolicy},
        "errors": [{"code": one.value, "name": one.name, "about": ABOUT[one.name]} for one in ErrorCode],
        "regions": [{"bit": bit, "name": one.name, "life": one.life, "record_bytes": one.dtype.itemsize}
                    for bit, one in enumerate(REGIONS)]}


def _reset(register):
    """The reset value; what is only read shows a state or a constant instead."""
    return {} if register.access is Access.READ else {"reset": register.reset}


def _bits(register):
    """The fields of a register with their lowest bits."""
    return [{"name": field.name, "low": low, "width": field.width, "about": field.about}
            for field, low in register.placed]

"""The registers in SystemRDL 2.0 (Accellera), from the tables that the hardware is made from."""

from hw.cluster import COUNTERS
from hw.registers.axi_lite_signature import DATA_BITS
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.error_code import ABOUT, CODE_BITS, ErrorCode
from hw.registers.register import WORD_BYTES, Access, Field, Register, addresses
from radiosity.flow.package.plain_text import plain_text

__all__ = ["system_rdl"]

_PROPERTIES = {
    Access.READ: "sw = r; hw = w;", Access.WRITE: "sw = rw; hw = r;", Access.COMMAND: "sw = w; hw = r;",
    Access.CONTROL: "sw = rw; hw = rw;"}
# Fields with the codes of `ErrorCode`.
_CODES = ("error",)


def system_rdl(name: str, *, clusters: int) -> str:
    """All registers and counters of an engine as the address map ``name``.

    Parameters
    ----------
    name
        Of the address map.
    clusters
        Number of clusters: each has a register file of counters.
    """
    offsets = addresses(ENGINE_REGISTERS)
    registers = "\n".join(_register(one, offsets[one.name]) for one in ENGINE_REGISTERS)
    files = "\n".join(_counter(counter, about, WORD_BYTES * k) for k, (counter, about) in enumerate(COUNTERS.items()))
    return f"""\
// The registers of {name}, SystemRDL 2.0.

enum error_code {{
{_codes()}
}};

addrmap {name} {{
    name = "{name}";
    desc = "AXI4-Lite, {DATA_BITS} bits. Registers of 64 bits take two words; write the low one first.";
    littleendian;
    lsb0;
    addressing = compact;
    default regwidth = {DATA_BITS};
    default accesswidth = {DATA_BITS};

{registers}
    regfile {{
        name = "Counters of a cluster";
        desc = "From the beginning of the section on; memory_answered, memory_deferred, memory_stalls since reset.";
{files}
    }} counters[{clusters}] @ {COUNTERS_BASE:#06x} += {WORD_BYTES << COUNTER_BITS:#x};
}};
"""


def _codes():
    return "\n".join(f"    {one.name} = {CODE_BITS}'d{one.value} {{ name = \"{one.name}\"; "
                     f"desc = \"{plain_text(ABOUT[one.name])}\"; }};" for one in ErrorCode)


def _register(one, offset):
    fields = one.fields or _parts(one)
    lines, low = [], 0
    for field in fields:
        lines.append(_field(one, field, low))
        low += field.width
    wide = [f"        regwidth = {2 * DATA_BITS};"] if one.words > 1 else []
    about = plain_text(f"{one.about} {one.rule}".rstrip())
    return "\n".join([
        "    reg {", f"        name = \"{one.name}\";", f"        desc = \"{about}\";", *wide, *lines,
        f"    }} {one.name} @ {offset:#05x};", ""])


def _parts(one):
    """One number. What software writes must lie within a word, so that each word takes effect by itself."""
    if one.words == 1 or one.access is Access.READ:
        return Field(name="value", width=one.width, about=""),
    return (Field(name="low", width=DATA_BITS, about="written first"),
            Field(name="high", width=one.width - DATA_BITS, about="written after low"))


def _field(register: Register, field: Field, low: int):
    properties = [_PROPERTIES[register.access]]
    if register.access is Access.COMMAND and field.width == 1:
        properties.append("singlepulse;")
    if field.clears:
        properties.append("onwrite = woclr;")
    if register.name in _CODES:
        properties.append("encode = error_code;")
    if field.about:
        properties.append(f"desc = \"{plain_text(field.about)}\";")
    reset = ""
    if register.access is not Access.READ:
        reset = f" = {field.width}'h{register.reset >> low & (1 << field.width) - 1:x}"
    return f"        field {{ {' '.join(properties)} }} {field.name}[{low + field.width - 1}:{low}]{reset};"


def _counter(name, about, offset):
    return (f"        reg {{ name = \"{name}\"; field {{ sw = r; hw = w; desc = \"{plain_text(about)}\"; }} "
            f"value[{DATA_BITS - 1}:0]; }} {name} @ {offset:#04x};")

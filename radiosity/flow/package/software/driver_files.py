"""The driver in C99, with constants from the tables that the hardware is made from."""

from collections.abc import Iterable
from pathlib import Path

from golden.engine.icu.patch_sums import SUM_BITS
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR
from hw.cluster import COUNTERS
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS, MAGIC, VERSION
from hw.registers.error_code import ABOUT, ErrorCode
from hw.registers.register import WORD_BYTES, addresses
from radiosity.flow.package.plain_text import plain_text

__all__ = ["driver_files"]

_FOLDER = Path(__file__).parent


def driver_files() -> dict[str, str]:
    """The texts of the driver by the names of its files."""
    parts = {
        "CONSTANTS": _constants(),
        "ERRORS": "\n".join(f'    {{{one.value}, "{one.name}", "{plain_text(ABOUT[one.name])}"}},'
                            for one in ErrorCode),
        "COUNTERS": "\n".join(f'    "{name}",' for name in COUNTERS),
        "COMPLETION": "\n".join(_completion())}
    files = {}
    for name in "radiosity.h", "radiosity.c":
        text = (_FOLDER / f"{name}.in").read_text()
        for mark, part in parts.items():
            text = text.replace(f"@{mark}@", part)
        files[name] = text
    return files


def _constants():
    """Macros and enumerations."""
    offsets = addresses(ENGINE_REGISTERS)
    errors = [(one.name, f"{one.value}", ABOUT[one.name]) for one in ErrorCode]
    return "\n".join([
        f"#define RADIOSITY_MAGIC UINT32_C({MAGIC:#x})", f"#define RADIOSITY_VERSION {VERSION}u",
        f"#define RADIOSITY_DESCRIPTOR_BYTES {DESCRIPTOR.dtype.itemsize}u",
        f"#define RADIOSITY_SUM_BITS {SUM_BITS}",
        f"#define RADIOSITY_COUNTERS_BASE UINT32_C({COUNTERS_BASE:#x})",
        f"#define RADIOSITY_COUNTERS_STRIDE UINT32_C({WORD_BYTES << COUNTER_BITS:#x})",
        f"#define RADIOSITY_COUNTERS {len(COUNTERS)}u", "",
        *_enumeration("radiosity_register", "REG", [
            (one.name, f"{offsets[one.name]:#05x}", f"{one.width} bits. {one.about}") for one in ENGINE_REGISTERS]),
        "", *_fields(), *_enumeration("radiosity_error", "ERROR", errors), "",
        *_enumeration("radiosity_counter", "COUNTER", [
            (name, f"{number}", about) for number, (name, about) in enumerate(COUNTERS.items())])])


def _enumeration(name: str, prefix: str, values: Iterable[tuple[str, str, str]]):
    """Of names, values and comments."""
    lines = [f"    RADIOSITY_{prefix}_{one.upper()} = {value}, /* {plain_text(about)} */"
             for one, value, about in values]
    # ISO C99 allows a comma behind the last one, C++98 does not.
    return [f"enum {name} {{", *lines[:-1], lines[-1].replace(", /*", " /*", 1), "};"]


def _fields():
    """Masks of the registers with fields."""
    for one in ENGINE_REGISTERS:
        for field, low in one.placed:
            mask = (1 << field.width) - 1 << low
            yield (f"#define RADIOSITY_{one.name.upper()}_{field.name.upper()} UINT32_C({mask:#x}) "
                   f"/* {plain_text(field.about)} */")
        if one.fields:
            yield ""


def _completion():
    """Assignments of a record's fields."""
    offset = 0
    for field in COMPLETION.fields:
        size = int(field.type[1:])
        cast = "" if size == 8 else f"(uint{8 * size}_t)"
        yield f"    record->{field.name} = {cast}little_endian(bytes + {offset}, {size});"
        offset += size

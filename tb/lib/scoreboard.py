"""Scoreboard: what came against what was expected."""

from hw.lib.payload import mask_of, pack, unpack

__all__ = ["check"]


def check(shape, got: list[int], expected: list, *, what: str) -> None:
    """All items are those that were expected, in their order.

    Parameters
    ----------
    expected
        Bits or values; a field that is None may have any value.

    Raises
    ------
    AssertionError
        Says which item is the first one that differs, in which fields; or how many are missing or too many.
    """
    for number, (item, value) in enumerate(zip(got, expected, strict=False)):
        bits = isinstance(value, int) and value >= 0
        item, required = (item, value) if bits else (item & mask_of(shape, value), pack(shape, value))
        if item != required:
            fields = _differences(unpack(shape, item), unpack(shape, required), what)
            raise AssertionError(f"item {number} of {len(expected)}: " + "; ".join(fields))
    if len(got) != len(expected):
        raise AssertionError(f"{what}: {len(got)} items came, not {len(expected)}")


def _differences(got, expected, path):
    if isinstance(got, dict):
        return [line for name in got for line in _differences(got[name], expected[name], f"{path}.{name}")]
    if isinstance(got, list):
        return [line for k in range(len(got)) for line in _differences(got[k], expected[k], f"{path}[{k}]")]
    return [] if got == expected else [f"{path} is {got}, not {expected}"]

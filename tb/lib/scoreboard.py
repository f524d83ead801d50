"""Scoreboard: what came against what was expected."""

from tb.lib.payload import unpack

__all__ = ["check"]


def check(shape, got: list[int], expected: list[int], *, what: str) -> None:
    """All items are those that were expected, in their order.

    Raises
    ------
    AssertionError
        Says which item is the first one that differs, in which fields; or how many are missing or too many.
    """
    for number, (item, wanted) in enumerate(zip(got, expected, strict=False)):
        if item != wanted:
            fields = _differences(unpack(shape, item), unpack(shape, wanted), what)
            raise AssertionError(f"item {number} of {len(expected)}: " + "; ".join(fields))
    if len(got) != len(expected):
        raise AssertionError(f"{what}: {len(got)} items came, not {len(expected)}")


def _differences(got, expected, path):
    if isinstance(got, dict):
        return [line for name in got for line in _differences(got[name], expected[name], f"{path}.{name}")]
    if isinstance(got, list):
        return [line for k in range(len(got)) for line in _differences(got[k], expected[k], f"{path}[{k}]")]
    return [] if got == expected else [f"{path} is {got}, not {expected}"]

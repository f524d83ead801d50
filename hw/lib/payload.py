"""Payloads of streams as integers, by their Amaranth layout."""

import functools

from amaranth.hdl import Shape
from amaranth.lib.data import ArrayLayout, Layout, StructLayout

__all__ = ["mask_of", "pack", "unpack"]


@functools.cache
def _cast_once(shape):
    """Amaranth casts all members of an enumeration each time."""
    return Shape.cast(shape)


def _cast(shape):
    # Layouts cannot be hashed.
    return Shape.cast(shape) if isinstance(shape, Layout) else _cast_once(shape)


def pack(shape, value) -> int:
    """The bits of a payload: dicts for structs, lists for arrays, integers for the rest; None or missing is 0.

    Raises
    ------
    KeyError
        The struct has no such field.
    """
    if value is None:
        return 0
    if isinstance(shape, StructLayout):
        known = dict(iter(shape))
        if set(value) - set(known):
            raise KeyError(f"there is no {', '.join(sorted(set(value) - set(known)))} in {', '.join(known)}")
        return sum(pack(known[name].shape, part) << known[name].offset for name, part in value.items())
    if isinstance(shape, ArrayLayout):
        width = _cast(shape.elem_shape).width
        return sum(pack(shape.elem_shape, part) << k * width for k, part in enumerate(value))
    return int(value) & (1 << _cast(shape).width) - 1


def mask_of(shape, value) -> int:
    """The bits of a payload that are compared with those of a value: all but those of a None."""
    width = Shape.cast(shape).width
    if value is None:
        return 0
    if isinstance(shape, StructLayout):
        known = dict(iter(shape))
        free = sum((1 << Shape.cast(known[name].shape).width) - 1 - mask_of(known[name].shape, part)
                   << known[name].offset for name, part in value.items())
        return (1 << width) - 1 - free
    if isinstance(shape, ArrayLayout):
        each = Shape.cast(shape.elem_shape).width
        return sum(mask_of(shape.elem_shape, part) << k * each for k, part in enumerate(value))
    return (1 << width) - 1


def unpack(shape, bits: int):
    """The value of a payload's bits: the inverse of `pack`."""
    if isinstance(shape, StructLayout):
        return {name: unpack(field.shape, bits >> field.offset) for name, field in shape}
    if isinstance(shape, ArrayLayout):
        width = _cast(shape.elem_shape).width
        return [unpack(shape.elem_shape, bits >> k * width) for k in range(shape.length)]
    cast = _cast(shape)
    bits &= (1 << cast.width) - 1
    return bits - (1 << cast.width) if cast.signed and bits >> cast.width - 1 else bits

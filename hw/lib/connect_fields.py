"""Streams that are driven from fields of other ones."""

from collections.abc import Iterable

__all__ = ["connect_fields"]


def connect_fields(m, target, source, *, tags: Iterable = (), **fields) -> None:
    """Drive a stream that is always ready: its ``valid`` from another stream, its payload field by field.

    Parameters
    ----------
    m
        The component's module.
    target, source
        The streams.
    tags
        Structs: each drives those fields of the payload's ``tag`` that have the names of its own.
    fields
        Values by the names of the payload's fields.
    """
    m.d.comb += target.valid.eq(source.valid)
    m.d.comb += [target.payload[name].eq(value) for name, value in fields.items()]
    for given in tags:
        names = {name for name, _ in given.shape()}
        m.d.comb += [target.payload.tag[name].eq(given[name])
                     for name, _ in target.payload.tag.shape() if name in names]

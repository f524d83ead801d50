"""What a component is given and what it must answer."""

from dataclasses import dataclass, field, replace

__all__ = ["Vectors"]


@dataclass(kw_only=True)
class Vectors:
    """Payloads as dicts and lists, by stream; a field of an expected one that is None may have any value.

    Parameters
    ----------
    inputs, expected
        Items of the streams in and out.
    first
        Items of input streams that come before all others, one stream after the other, and again after a reset.
    ports, after
        Values of other inputs, which stay, and of other outputs when all is over.
    about
        What the items were made of, for a testbench's own methods.
    """

    inputs: dict[str, list]
    expected: dict[str, list]
    first: dict[str, list] = field(default_factory=dict)
    ports: dict = field(default_factory=dict)
    after: dict = field(default_factory=dict)
    about: object = None

    def part(self, begin: int, end: int) -> "Vectors":
        """Some items of the only input, and the same share of each output."""
        (name, items), = self.inputs.items()
        count = len(items)
        return replace(self, inputs={name: items[begin:end]}, expected={
            stream: values[len(values) * begin // count:len(values) * end // count]
            for stream, values in self.expected.items()})

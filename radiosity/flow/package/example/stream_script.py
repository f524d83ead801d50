"""What the streams of a unit are given in an example, what must come of it, and what stands around the unit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from amaranth.hdl import Shape
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hw.lib.black_box import flatten
from hw.lib.payload import mask_of, pack
from radiosity.flow.package.port_names import port_name

__all__ = ["STEP_BITS", "Responder", "Script", "StreamItems"]

# Of the number of a step.
STEP_BITS = 16


@dataclass(kw_only=True)
class StreamItems:
    """The items of a stream in their order.

    Parameters
    ----------
    stream
        Its name, as the ports have it.
    width
        Bits of an item.
    has_ready
        It has back-pressure.
    is_input
        The unit takes them.
    any_order
        Those of a step may come in any order.
    items
        Of each its step, its bits, and those of them that are compared.
    """

    stream: str
    width: int
    has_ready: bool
    is_input: bool
    any_order: bool
    items: list[tuple[int, int, int]]


@dataclass(frozen=True, kw_only=True)
class Responder:
    """A part outside that answers the requests of one stream on another one.

    Parameters
    ----------
    request, answer
        The streams.
    pairs
        A request, and an item of its answer; items of the same answer follow each other.
    """

    request: StreamItems
    answer: StreamItems
    pairs: list[tuple[int, int]]


class Script:
    """Items in steps: a step begins when all items of the one before have been given or have come.

    Values are as of `hw.lib.payload`; of those that must come None is not compared.

    Parameters
    ----------
    component
        The unit, which is never elaborated.

    Members
    -------
    streams, responders, constants
        Of the script, by the names of ports: `StreamItems`, `Responder`, and integers.
    unchanged
        Outputs that must have a value at the end.
    """

    def __init__(self, component: wiring.Component):
        members = component.signature.members
        self._inputs = {name for name, member in members.items() if member.flow is In}
        self._shapes = {name: getattr(component, name).payload.shape() if member.is_signature else member.shape
                        for name, member in members.items()}
        self._widths = {path: len(value) for path, _, value in flatten(component)}
        self._step, self.streams, self.responders = 0, {}, []
        self.constants, self.unchanged = {}, {}

    @property
    def step(self) -> int:
        """The number of the present step."""
        return self._step

    @property
    def ports(self) -> dict[str, tuple[bool, int]]:
        """Of all ports that are not of a stream of the script: whether they are inputs, and their bits."""
        used = {*self.streams, *(one.stream for pair in self.responders for one in (pair.request, pair.answer))}
        return {port_name(path): (path.partition("__")[0] in self._inputs, width)
                for path, width in self._widths.items() if path.partition("__")[0] not in used}

    def next_step(self, *, pause: int = 0) -> None:
        """What follows waits for what was before, and so many cycles: a step without items takes one.

        Raises
        ------
        ValueError
            There are too many steps.
        """
        self._step += 1 + pause
        if self._step >> STEP_BITS:
            raise ValueError(f"A script must have less than {1 << STEP_BITS} steps, not {self._step + 1}")

    def give(self, stream: str, values: Sequence) -> None:
        """The unit is given items in this step."""
        self._add(stream, values, any_order=False)

    def require(self, stream: str, values: Sequence, *, any_order: bool = False,
                compared: Sequence[int] | None = None) -> None:
        """Items must come in this step; ``compared`` has the bits of each that are compared, by default all."""
        self._add(stream, values, any_order=any_order, compared=compared)

    def answer(self, request: str, answer: str, pairs: Mapping[object, Sequence]) -> None:
        """Requests are answered at any time; ``pairs`` has bits of requests, and values of answers."""
        requested, replied, shape = self._items(request), self._items(answer), self._shapes[answer]
        self.responders.append(Responder(request=requested, answer=replied, pairs=[
            (key, pack(shape, value)) for key, values in pairs.items() for value in values]))

    def hold(self, port: str, value) -> None:
        """An input is constant."""
        self.constants[port] = pack(self._shapes[port], value)

    def ends_with(self, port: str, value) -> None:
        """An output has a value at the end."""
        self.unchanged[port] = pack(self._shapes[port], value)

    def _add(self, stream, values, *, any_order, compared=None):
        shape = self._shapes[stream]
        found = self.streams.setdefault(stream, self._items(stream))
        found.any_order |= any_order
        compared = compared or [mask_of(shape, value) for value in values]
        found.items += [(self._step, pack(shape, value), mask)
                        for value, mask in zip(values, compared, strict=True)]

    def _items(self, stream):
        return StreamItems(stream=stream, width=Shape.cast(self._shapes[stream]).width,
                           has_ready=f"{stream}__ready" in self._widths, is_input=stream in self._inputs,
                           any_order=False, items=[])

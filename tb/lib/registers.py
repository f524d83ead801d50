"""A pipeline in a golden model of cycles."""

from collections import deque

__all__ = ["Registers"]


class Registers(deque):
    """Registers that all stall while the item at their end, the first one of the deque, waits.

    Parameters
    ----------
    latency
        Registers.
    """

    def __init__(self, latency: int):
        super().__init__([None] * latency)

    def moves(self, ready: bool) -> bool:
        """Whether they accept an item."""
        return self[0] is None or bool(ready)

    def step(self, item, ready: bool) -> None:
        """The end of a cycle in which an item or None is offered."""
        if self.moves(ready):
            self.popleft()
            self.append(item)

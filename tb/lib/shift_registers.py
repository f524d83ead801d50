"""A rigid pipeline, for golden models of units that hold one."""

__all__ = ["ShiftRegisters"]


class ShiftRegisters:
    """Registers that all stall while the item at the end waits.

    Parameters
    ----------
    latency
        Their number.
    """

    def __init__(self, latency: int):
        self._items = [None] * latency

    @property
    def end(self):
        """The item at the end, or None."""
        return self._items[-1]

    def advances(self, ready: bool) -> bool:
        """Whether they move when what follows is ready or not."""
        return ready or self.end is None

    def step(self, item, ready: bool) -> None:
        """A cycle with an item or None at the input."""
        if self.advances(ready):
            self._items = [item, *self._items[:-1]]

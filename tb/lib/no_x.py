"""No unknown values where a component says whether something is there."""

__all__ = ["assert_known"]


def assert_known(dut, streams) -> None:
    """``valid`` and ``ready`` of a component's streams are 0 or 1: read after reset, of a four-state simulator.

    Raises
    ------
    AssertionError
        Names the signals that are neither.
    """
    signals = [getattr(dut, f"{name}__{wire}", None) for name in streams for wire in ("valid", "ready")]
    unknown = [signal._name for signal in signals if signal is not None and not signal.value.is_resolvable]
    assert not unknown, f"{', '.join(unknown)} must be 0 or 1 after reset"

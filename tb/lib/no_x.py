"""No unknown values where a component says whether something is there."""

__all__ = ["assert_known"]


def assert_known(dut) -> None:
    """All ``valid`` and ``ready`` of a component's streams are 0 or 1: asked after reset, of a four-state simulator.

    Errors
    ------
    AssertionError
        Names the signals that are neither.
    """
    signals = [getattr(dut, name) for name in dir(dut) if name.endswith(("__valid", "__ready"))]
    unknown = [signal._name for signal in signals if not signal.value.is_resolvable]
    assert not unknown, f"{', '.join(unknown)} must be 0 or 1 after reset"

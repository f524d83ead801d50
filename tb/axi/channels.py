"""What the rules of all AXI channels share: operators on integers or on Amaranth values, and the rules of an offer."""

from dataclasses import dataclass
from types import SimpleNamespace

from amaranth.hdl import Array, Mux

__all__ = ["AMARANTH", "PYTHON", "Operators", "channel_rules", "channel_state", "no"]


@dataclass(frozen=True, kw_only=True)
class Operators:
    """Operations that Python has no operator for that works on integers and on Amaranth values alike.

    Parameters
    ----------
    mux
        Of a condition and two values, the first one if it holds.
    select
        Of a list and an index, the item.
    """

    mux: object
    select: object


AMARANTH = Operators(mux=Mux, select=lambda items, index: Array(items)[index])
PYTHON = Operators(mux=lambda condition, one, other: one if condition else other,
                   select=lambda items, index: items[index])


def no(value):
    """1 if a value is 0."""
    return value == 0


def channel_state(pins: dict[str, int], channels: dict[str, tuple[str, ...]]) -> dict[str, list[tuple[int, int]]]:
    """Widths and initial values of the state of `channel_rules`.

    Parameters
    ----------
    pins
        Widths.
    channels
        By name of a channel the pins of its payload.
    """
    return {"fresh": [(1, 1)], **{f"{name}_waited": [(1, 0)] for name in channels},
            **{f"{name}_before": [(pins[pin], 0) for pin in payload] for name, payload in channels.items()}}


def channel_rules(pins: SimpleNamespace, state: dict, channels: dict[str, tuple[str, ...]]) -> tuple[dict, dict]:
    """An offer stays, unchanged, until it is accepted or a reset comes; there is none in the cycles after one of reset.

    Returns violations and the next state.
    """
    (fresh,) = state["fresh"]
    violated, following = {}, {"fresh": [0]}
    for name, payload in channels.items():
        valid, ready = getattr(pins, f"{name}valid"), getattr(pins, f"{name}ready")
        (waited,), now = state[f"{name}_waited"], [getattr(pins, pin) for pin in payload]
        same = valid
        for one, other in zip(now, state[f"{name}_before"], strict=True):
            same = same & (one == other)
        violated[f"{name}_stable"] = waited & no(same | pins.reset)
        violated[f"{name}_reset"] = fresh & valid
        following |= {f"{name}_waited": [valid & no(ready)], f"{name}_before": now}
    return violated, following

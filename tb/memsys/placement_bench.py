"""Requests of placements, and golden's answers."""

import numpy as np

from tb.lib.schedules import ScheduleBench
from tb.memsys.started import PAUSE, started

__all__ = ["TAGS", "answers", "check_starts", "keys_of", "requests"]

# Keys that come again at once, after any number of others, and never; that share sets, and that do not.
_STRINGS = (
    lambda draw, lines: draw.integers(0, 2 * lines, 120),
    lambda draw, lines: draw.integers(0, 3, 60) * lines,
    lambda draw, lines: np.minimum(draw.geometric(1 / lines, 120), 255),
    lambda draw, lines: np.arange(100) % (lines + 1))
TAGS = 64


def keys_of(lines: int, seed: int) -> np.ndarray:
    """Strings of keys of all kinds, one after the other."""
    return np.concatenate([string(np.random.default_rng(seed), lines) for string in _STRINGS])


def requests(keys: np.ndarray) -> list[dict]:
    """The requests of keys."""
    return [{"tag": number % TAGS, "key": int(key)} for number, key in enumerate(keys)]


def answers(golden, keys: np.ndarray) -> list[dict]:
    """Their answers, from an empty placement on."""
    golden.clear()
    hit, line, _ = golden.access(keys)
    assert len(set(hit)) == 2, "there must be hits and misses"
    return [{"tag": number % TAGS, "line": int(line[number]), "hit": int(hit[number])} for number in range(len(keys))]


def check_starts(placement, golden, strings: list[np.ndarray], *, miss: int = 1, **ports: int) -> None:
    """Each string of keys has golden's answers, after a start of its own; a miss takes ``miss`` cycles."""
    expected = [answers(golden, keys) for keys in strings]
    times = [sum(1 if one["hit"] else miss for one in answered) for answered in expected]
    bench = ScheduleBench(placement, idle_limit=4 * PAUSE)
    came = bench.run(started([requests(keys) for keys in strings], times), **ports)["o"]
    assert came == [one for answered in expected for one in answered]

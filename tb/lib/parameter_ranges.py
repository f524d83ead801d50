"""The documented ranges of the configuration's parameters, and configurations at their ends."""

import re
from collections.abc import Iterator

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from radiosity.tasks.config import about_parameters

__all__ = ["corner", "documented_ranges"]


def documented_ranges() -> Iterator[tuple[str, int, int, bool]]:
    """Of each parameter its least and largest value, and whether it is a power of two, as its text says."""
    about = about_parameters(Config())
    shared = {}
    for path, text in about.items():
        group = path.partition(".")[0]
        ranges = [tuple(2 ** int(end[2:]) if "^" in end else int(end) for end in found)
                  for found in re.findall(r"(?:; |and |, )(\d+) to (\d+\^?\d*)\b", text)]
        position = shared[group, text] = shared.get((group, text), -1) + 1
        if ranges:
            yield path, *ranges[min(position, len(ranges) - 1)], "power" in text.partition(" to ")[0]


def corner(generator: np.random.Generator, *groups: str) -> Config:
    """A configuration with each parameter of some groups at an end of its range, drawn until it breaks no rule."""
    ends = {path: int(generator.choice(ends)) for path, *ends, _ in documented_ranges() if path.startswith(groups)}
    try:
        # The range of the fraction depends on another parameter.
        return Config().replace(ends | {"icu.settle_fraction": 1})
    except InputError:
        return corner(generator, *groups)

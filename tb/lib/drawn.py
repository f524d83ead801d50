"""A night's share of cases that take long."""

from collections.abc import Sequence
from random import Random

from tb.lib.seed import NIGHTS, SEED

__all__ = ["drawn"]


def drawn(cases: Sequence, each: int = 1) -> list:
    """Those of some cases that NIGHTS nights have, in their order: a night has ``each`` of them, drawn by SEED."""
    chosen = Random(SEED).sample(range(len(cases)), min(each * NIGHTS, len(cases)))
    return [cases[number] for number in sorted(chosen)]

"""Schedules as the simulated machine is given them."""

from dataclasses import fields, replace

import numpy as np

from golden.schedule.phase import Schedule
from golden.schedule.subshells import SubshellList

__all__ = ["without_subshells"]


def without_subshells(plan: Schedule) -> Schedule:
    """With no subshell but the last one, which is not listed: the hits are the same, and each subshell takes cycles."""
    none = SubshellList(*(np.zeros(0, dtype=np.int64) for _ in fields(SubshellList)))
    return replace(plan, subshells=(none,) * len(plan.subshells))

"""Ray timing: microseconds of the steps of a ray on a node, and of its messages."""

from dataclasses import dataclass

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["PROFILES", "RayTiming"]


@dataclass(frozen=True, kw_only=True)
class RayTiming(TimingNumbers):
    """Microseconds on a node. The defaults are the profile ``1987``: a VAX 11/780 without floating-point hardware.

    The source has the times of a step, of its setup, of tests and of hits, and 2 ms for a call of the shared memory.
    The time of the rest of a ray, its generation, shading and children, is not stated. With 6 ms its totals and two
    of its three speedups by grids follow from its own counts; the third does not.

    Parameters
    ----------
    array_setup, array_step, hash_setup, hash_step
        Setup of a ray's walk on a node, and each step to the next voxel.
    sphere_test, polygon_test
        Test of an object.
    sphere_hit, polygon_hit
        Further time for an object that is hit.
    rest
        All else of a ray, once.
    call
        A message that is sent or received.

    Raises
    ------
    TypeError, ValueError
        See `TimingNumbers`.

    Source: Pearce 1987, tables 4-3 and 4-4, and section 5.2 for calls.
    """

    array_setup: int = 684
    array_step: int = 59
    hash_setup: int = 807
    hash_step: int = 90
    sphere_test: int = 218
    polygon_test: int = 320
    sphere_hit: int = 1301
    polygon_hit: int = 1362
    rest: int = 6000
    call: int = 2000


PROFILES = {"1987": RayTiming()}
"""Timings by name."""

"""View factors from points in space, with occlusion."""

from dataclasses import dataclass

import numpy as np

from golden.cast.casters import CastsRays
from golden.cast.frame import frame
from golden.cast.rays import Rays
from golden.light.factors.coincident_fronts import CoincidentFronts
from golden.light.factors.groups import surface_numbers
from golden.light.factors.points import REPLICATES
from golden.light.factors.replicate_shares import replicate_shares
from golden.light.factors.sides import Sides
from golden.light.photometry.sensors import Sensors
from golden.light.sampling import mix, sobol
from golden.scene.scene import Scene

__all__ = ["ReceiverFactors", "receiver_factors"]

# Rays of a receiver at first and at most, and of all receivers that are cast together.
_FEWEST, _MOST, _RAYS = 1 << 12, 1 << 20, 1 << 19

# Of the random numbers' uses.
_RECEIVERS = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class ReceiverFactors:
    """What S points see of G surfaces.

    Parameters
    ----------
    names
        Of the surfaces.
    share, error
        S x (G + 2) float64: view factors from each point to the surfaces, to the sky and to black backs of one-sided
        patches, which add up to 1; and their standard errors.
    """

    names: list[str]
    share: np.ndarray
    error: np.ndarray


def receiver_factors(scene: Scene, caster: CastsRays, points: Sensors, *, error: float, seed: int) -> ReceiverFactors:
    """The view factors from points, small black elements that face a direction, to surfaces by their names.

    A hemisphere of rays distributed by the cosine measures each, in replicates whose scatter is the standard error. It
    has four times the rays until the error of every factor is the requested one, or 2^20. An error that was above it is
    not below it then: of several estimates one that is too small ends the search.

    Parameters
    ----------
    scene, caster
        The patches, and a caster of any rays.
    points
        Positions and directions. The patch on which a point lies hides nothing.
    error
        Requested error of every factor, twice its standard error.
    seed
        Of the random numbers, at least 0.
    """
    sides, materials = Sides(scene), np.array([material.name for material in scene.materials])
    number, names = surface_numbers(materials[scene.material[sides.patch]], sides.front)
    fronts, on = CoincidentFronts(sides), points.patches(scene, caster)
    source = np.where(on < 0, -1, scene.surface[on])
    axes, targets = frame(points.normal), len(names) + 2
    (share, spread), least = np.empty((2, len(points), targets)), np.zeros((len(points), targets))
    waiting, rays = np.arange(len(points)), _FEWEST
    while len(waiting):
        step = max(1, _RAYS // rays)
        for some in np.split(waiting, range(step, len(waiting), step)):
            direction = _directions(axes[some], mix(seed, _RECEIVERS, some), rays)
            met = _met(sides, fronts, caster, np.repeat(points.position[some], rays, axis=0), direction,
                       np.repeat(source[some], rays))
            target = np.where(met >= 0, number[met], len(names) - met - 1)
            # The rays of a replicate follow each other.
            slot = np.arange(len(target)) // (rays // REPLICATES) * targets + target
            counts = np.bincount(slot, minlength=len(some) * REPLICATES * targets).reshape(-1, REPLICATES, targets)
            part = counts.transpose(0, 2, 1).reshape(-1, REPLICATES).astype(np.float64)
            whole = np.full_like(part, rays / REPLICATES)
            share[some], spread[some] = (values.reshape(-1, targets) for values in replicate_shares(
                whole, part, np.full(len(part), float(rays))))
        spread[waiting] = np.maximum(spread[waiting], least[waiting])
        least[spread > error / 2] = error / 2
        waiting = waiting[spread[waiting].max(axis=1) > error / 2] if rays < _MOST else waiting[:0]
        rays *= 4
    return ReceiverFactors(names=names, share=share, error=spread)


def _directions(axes, use, rays):
    """Unit vectors by the cosine with the third of each point's axes, from a lattice that each replicate shifts."""
    uv = sobol(mix(use[:, None], np.arange(REPLICATES)).ravel(), rays // REPLICATES).reshape(len(use), rays, 2)
    turn, radius = 2 * np.pi * uv[..., 0], np.sqrt(uv[..., 1])
    local = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - uv[..., 1])], axis=-1)
    return (local @ axes).reshape(-1, 3)


def _met(sides, fronts, caster, origin, direction, source):
    """The side that each ray meets, -1 of the sky and -2 of a black back."""
    patch = caster.nearest_patches(Rays(origin, direction, source=source))
    hit = np.flatnonzero(patch >= 0)
    met = np.full(len(patch), -1)
    side = sides.met(patch[hit], direction[hit])
    black = np.flatnonzero(side < 0)
    rays = hit[black]
    side[black] = fronts.met(patch[rays], origin[rays], direction[rays])
    met[hit] = np.where(side < 0, -2, side)
    return met

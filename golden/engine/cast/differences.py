"""Fixed point against the oracle: the rays that differ, by cause."""

from dataclasses import dataclass

import numpy as np

from golden.cast.rays import Hits, Rays
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.edge_planes import EDGES
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene

__all__ = ["Differences", "differences", "oracle_rays"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Differences:
    """The numbers of the rays whose patch differs from the oracle's, by cause; each ray is in one array.

    Parameters
    ----------
    edge
        The ray passes the plane through the origin and an edge of one of the two patches within 2^-14 + 2^-21/t.
    long_edge
        The same within 2^-14 + (2^-21 + 2^-16 L)/t, L the distance of the edge's farther end: V' is rounded in
        proportion to L, so an edge that passes the origin much nearer than it is long turns by more.
    depth
        The two patches' 1/t differ by less than the sum of both lengths of m times (2^-16 + 2^-21/t).
    dropped
        The oracle hits a patch whose plane passes through the origin within two units.
    unexplained
        No such cause: a fault.

    Source: docs/exactness.md, Against the oracle.
    """

    edge: np.ndarray
    long_edge: np.ndarray
    depth: np.ndarray
    dropped: np.ndarray
    unexplained: np.ndarray

    def counts(self) -> dict[str, int]:
        """Number of rays by cause."""
        return {cause: len(rays) for cause, rays in vars(self).items()}


def oracle_rays(record: FrustumRecord, geometry: PatchGeometry) -> Rays:
    """The record's rays for the float64 casters: the inverse of its rounded matrix times its integer directions.

    The oracle's t is then in the machine's unit.
    """
    coordinates, unit = geometry.coordinates, 2.0**-record.numbers.direction_fraction
    to_scene = np.linalg.inv(record.matrix * unit) / coordinates.scale
    direction = (record.all_directions() * unit) @ to_scene.T
    origin = np.broadcast_to(coordinates.points(record.origin), direction.shape)
    return Rays(origin, direction, np.full(len(direction), record.source))


def differences(fixed: FixedHits, oracle: Hits, record: FrustumRecord, scene: Scene, geometry: PatchGeometry,
                config: Config) -> Differences:
    """The rays that hit different patches, sorted by cause. Of patches back to back fixed point hits either.

    Parameters
    ----------
    fixed
        Hits of the record's rays.
    oracle
        Hits of `oracle_rays`.
    record, scene, geometry, config
        The frustum, the scene in float64 and in G coordinates, and the configuration.
    """
    met = scene.facing(fixed.patch, oracle_rays(record, geometry).direction)
    ray = np.flatnonzero(met != oracle.patch)
    direction = record.directions(ray % record.columns, ray // record.columns) \
        * 2.0**-record.numbers.direction_fraction
    vertices = _exact_vertices(record, scene, geometry)
    dropped = PatchSetup(record, config).patches(geometry).factor.dropped
    candidates = [_candidate(vertices[patch], direction, patch >= 0) for patch in (fixed.patch[ray], oracle.patch[ray])]
    (edge, long_edge), (other_edge, other_long_edge) = (candidate[:2] for candidate in candidates)
    (inverse, slack), (other_inverse, other_slack) = (candidate[2:] for candidate in candidates)
    both = (fixed.patch[ray] >= 0) & (oracle.patch[ray] >= 0)
    causes = {"dropped": (oracle.patch[ray] >= 0) & dropped[oracle.patch[ray]],
              "depth": both & (np.abs(inverse - other_inverse) < slack + other_slack),
              "edge": edge | other_edge, "long_edge": long_edge | other_long_edge}
    rest, sorted_rays = np.ones(len(ray), dtype=bool), {}
    for cause, holds in causes.items():
        sorted_rays[cause] = ray[rest & holds]
        rest &= ~holds
    return Differences(**sorted_rays, unexplained=ray[rest])


def _exact_vertices(record, scene, geometry):
    """Vertices in the R frame: only matrix and origin are rounded."""
    coordinates = geometry.coordinates
    offset = (scene.vertices - coordinates.points(record.origin)) * coordinates.scale
    return offset @ (record.matrix.T * 2.0**-record.numbers.direction_fraction)


def _candidate(vertices, direction, exists):
    """Whether rays pass near an edge and a long edge, their 1/t, and the bound of its rounding error."""
    normal = np.cross(vertices[:, 2] - vertices[:, 0], vertices[:, 3] - vertices[:, 1])
    near, near_long = np.zeros((2, len(vertices)), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = normal / np.einsum("ki,ki->k", normal, vertices[:, 0])[:, None]
        inverse = np.einsum("ki,ki->k", factor, direction)
        allowed = 2.0**-14 + 2.0**-21 * np.abs(inverse)
        for i, j in EDGES[:4]:
            plane = np.cross(vertices[:, i], vertices[:, j])
            length = np.linalg.norm(plane, axis=1) * np.linalg.norm(direction, axis=1)
            angle = np.abs(np.einsum("ki,ki->k", plane, direction)) / length
            far = np.linalg.norm(vertices[:, [i, j]], axis=2).max(axis=1)
            near |= angle < allowed
            near_long |= angle < allowed + 2.0**-16 * far * np.abs(inverse)
    slack = np.linalg.norm(factor, axis=1) * (2.0**-16 + 2.0**-21 * np.abs(inverse))
    return near & exists, near_long & exists, inverse, slack

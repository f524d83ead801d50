"""Hits of a frustum by the references of `benchmarks.truth`, which take from golden what the host gives."""

import numpy as np

from benchmarks.truth.exact_geometry import ExactGeometry
from benchmarks.truth.integer_rule import IntegerRule, RuleHits
from benchmarks.truth.ray_directions import hemisphere_directions, screen_directions
from golden.engine.frustum import FrustumRecord
from golden.engine.scene.patch_geometry import PatchGeometry

__all__ = ["exact_geometry", "ray_directions", "rule_hits"]


def ray_directions(record: FrustumRecord) -> np.ndarray:
    """Directions of a record's rays, rows x columns x 3, from its sizes and the side of a screen's pixel alone."""
    if record.is_screen:
        return screen_directions(record.columns, record.rows, 2 * record.slopes[1] / record.rows)
    return hemisphere_directions(record.columns, record.rows)


def rule_hits(record: FrustumRecord, geometry: PatchGeometry, numbers: type = np.int64) -> RuleHits:
    """Hits by the integer rule."""
    return IntegerRule(**_given(record, geometry), numbers=numbers).cast(ray_directions(record))


def exact_geometry(record: FrustumRecord, geometry: PatchGeometry) -> ExactGeometry:
    """Exact geometry of the snapped vertices and the grid's directions."""
    return ExactGeometry(**_given(record, geometry), directions=ray_directions(record))


def _given(record, geometry):
    """What the host gives: vertices and origin in G, the matrix, and the source."""
    sources = np.flatnonzero(geometry.surface == record.source) if record.source >= 0 else ()
    return {"corners": geometry.vertices, "matrix": record.matrix, "origin": record.origin, "sources": sources}

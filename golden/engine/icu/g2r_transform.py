"""G2R transform: vertices from scene coordinates to the frustum's R frame."""

import numpy as np

from golden.engine.frustum import FrustumRecord
from golden.engine.lib.fixed import round_shift

__all__ = ["g2r_transform"]


def g2r_transform(record: FrustumRecord, vertices: np.ndarray) -> np.ndarray:
    """``V = matrix (P - origin)``, signed 1.22, one rounding per component.

    Parameters
    ----------
    record
        The frustum.
    vertices
        ... x 3 int64, G coordinates.

    Returns
    -------
    ... x 3 int64, units of 2^-22 by default. A row of the matrix is at most sqrt(1 + 2^-15) long and an offset at most
    sqrt(3), so the product is below 2.
    """
    numbers = record.numbers
    offset = numbers.offset.check(vertices - record.origin, "vertex offset")
    # Below 3 x 2^24 x 2^16: exact.
    product = offset @ record.matrix.T
    lost = numbers.scene_bits + numbers.direction_fraction - numbers.vector_fraction
    return numbers.vector.check(round_shift(product, lost), "R vertex")

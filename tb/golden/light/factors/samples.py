"""View factors with all of their parts, for tests of what stores them."""

import numpy as np
from scipy import sparse

from golden.light.factors.view_factors import ViewFactors

__all__ = ["three_sides"]


def three_sides(**changed) -> ViewFactors:
    """A triangular duct with sides 3, 4 and 5, where a share of 0.06 leaves the first side and 0.04 meets a back."""
    matrix = sparse.csr_array([(0, 0.3, 0.6), (1 / 4, 0, 3 / 4), (2 / 5, 3 / 5, 0)])
    given = {
        "F": matrix, "sky": np.array([0.06, 0, 0]), "back": np.array([0.04, 0, 0]), "area": np.array([3.0, 4, 5]),
        "normal": np.eye(3),
        "surface": np.array(["sun", "Wand süd", ""]), "unprojected_sky": np.array([0.08, 0, 0]),
        "sky_error": np.array([0.01, 0.004, 0]),
        "sky_patches": sparse.csr_array([(0, 0.04, 0, 0.02), (0,) * 4, (0,) * 4]),
        "patch": np.array([0, 1, 0]), "front": np.array([True, True, False]), "hidden_error": 0.001,
        "error": sparse.csr_array((matrix.data / 100, matrix.indices, matrix.indptr), shape=(3, 3)),
        "unprojected": sparse.csr_array((matrix.data * 1.01, matrix.indices, matrix.indptr), shape=(3, 3)),
        "row_sums": np.array([[3, 4], [4, 4], [4, 4]]), "weight_bits": 2, "settings": {"rays": "4x4", "samples": 2}}
    return ViewFactors(**given | changed)

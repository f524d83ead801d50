"""View factors with all of their parts, for tests of what stores them."""

import numpy as np
from hypothesis import strategies as st
from scipy import sparse

from golden.light.factors.view_factors import ViewFactors

__all__ = ["sparse_sides", "three_sides"]


def three_sides(**changed) -> ViewFactors:
    """A triangular duct with sides 3, 4 and 5, where a share of 0.06 leaves the first side and 0.04 meets a back."""
    matrix = sparse.csr_array([(0, 0.3, 0.6), (1 / 4, 0, 3 / 4), (2 / 5, 3 / 5, 0)])
    given = {
        "F": matrix, "sky": np.array([0.06, 0, 0]), "back": np.array([0.04, 0, 0]), "area": np.array([3.0, 4, 5]),
        "normal": np.eye(3),
        "surface": np.array(["sun", "Wand süd", ""]), "unprojected_sky": np.array([0.08, 0, 0]),
        "sky_error": np.array([0.01, 0.004, 0]),
        "sky_patches": sparse.csr_array([(0, 0.04, 0, 0.02), (0,) * 4, (0,) * 4]),
        "sky_patches_error": sparse.csr_array([(0, 0.003, 0, 0.001), (0,) * 4, (0,) * 4]),
        "patch": np.array([0, 1, 0]), "front": np.array([True, True, False]), "hidden_error": 0.001,
        "error": sparse.csr_array((matrix.data / 100, matrix.indices, matrix.indptr), shape=(3, 3)),
        "unprojected": sparse.csr_array((matrix.data * 1.01, matrix.indices, matrix.indptr), shape=(3, 3)),
        "row_sums": np.array([[3, 4], [4, 4], [4, 4]]), "weight_bits": 2, "settings": {"rays": "4x4", "samples": 2}}
    return ViewFactors(**given | changed)


@st.composite
def sparse_sides(draw) -> ViewFactors:
    """Draws up to five sides, of which any may see nothing, no sky and no patch of the sky: rows may be empty."""
    count = draw(st.integers(1, 5))
    values = st.sampled_from((0.0, 0.0, 0.125, 0.5))

    def matrix(columns):
        rows = [[draw(values) for _ in range(columns)] for _ in range(count)]
        return sparse.csr_array(np.array(rows).reshape(count, columns))

    def of_sides():
        return np.array([draw(values) for _ in range(count)])

    factors = matrix(count)
    like = sparse.csr_array((factors.data / 100, factors.indices, factors.indptr), shape=factors.shape)
    return ViewFactors(
        F=factors, sky=of_sides(), back=of_sides(), patch=np.arange(count), front=np.ones(count, dtype=bool),
        area=of_sides() + 1, normal=np.tile((0.0, 0, 1), (count, 1)), surface=np.array(["side"] * count),
        error=draw(st.sampled_from((None, like))), sky_error=draw(st.sampled_from((None, of_sides()))),
        sky_patches=draw(st.sampled_from((None, matrix(draw(st.integers(1, 3)))))))

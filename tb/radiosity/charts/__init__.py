"""Charts."""

import numpy as np

__all__ = ["rectangles"]


def rectangles(patch):
    """K x 4: left, right, upper and lower border of each bar of a patch of `lane_figure`."""
    corners = patch.get_path().vertices.reshape(-1, 5, 2)[:, :4]
    return np.stack([corners[..., 0].min(axis=1), corners[..., 0].max(axis=1),
                     corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)], axis=1)

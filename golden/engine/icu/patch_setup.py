"""Patch setup: the parameters of a patch for the intersection, once per frustum."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.edge_planes import EdgePlanes, edge_planes
from golden.engine.icu.g2r_transform import g2r_transform
from golden.engine.icu.inverse_distance import bound
from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.icu.plane_factor import PlaneFactor, plane_factor
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.icu.window import Window
from golden.engine.scene.patch_geometry import PatchGeometry

__all__ = ["PatchSetup", "Patches"]


@dataclass(frozen=True, eq=False)
class Patches:
    """P patches, set up for a frustum.

    Parameters
    ----------
    exponents
        P x 4 int64, exponents of the vertex directions.
    planes, factor, window
        Edge planes, plane factors and windows; the window of a patch that is not live is empty.
    bound
        P int64: no ray of the window has a larger stored inverse distance to the patch.
    live
        P bool: the patch can be hit. It is false for the rays' source, for a patch whose plane passes through the
        origin, and for one seen edge-on.
    """

    exponents: np.ndarray
    planes: EdgePlanes
    factor: PlaneFactor
    window: Window
    bound: np.ndarray
    live: np.ndarray


class PatchSetup:
    """G2R transform, vertex directions, edge planes, window and plane factor for one frustum.

    Parameters
    ----------
    record, config
        The frustum, and the configuration.

    Raises
    ------
    InputError
        The frustum has more columns or rows, or the scene more patches, than the configuration allows.
    """

    def __init__(self, record: FrustumRecord, config: Config):
        side = 1 << config.icu.side_bits
        if max(record.columns, record.rows) > side:
            raise InputError(f"frustum: Columns and rows must be at most 2^icu.side_bits ({side}), "
                             f"not {record.columns} x {record.rows}")
        self._record, self._config = record, config
        self._windows = (ImagePlaneWindows if record.is_screen else SphericalWindows)(record, config)

    def patches(self, geometry: PatchGeometry) -> Patches:
        """The patches of ``geometry``, all at once."""
        record, numbers = self._record, self._config.numbers
        if len(geometry) > 1 << self._config.icu.patch_bits:
            raise InputError(f"scene: Patches must be at most 2^icu.patch_bits ({1 << self._config.icu.patch_bits}), "
                             f"not {len(geometry)}")
        vertices = g2r_transform(record, geometry.vertices)
        directions, exponents = vertex_direction(vertices, numbers)
        planes, factor = edge_planes(directions, numbers), plane_factor(vertices, numbers)
        own = (geometry.surface == record.source) & (record.source >= 0)
        live = ~factor.dropped & ~own & planes.orientation.any(axis=1)
        window = self._windows.windows(directions, planes).only(live)
        return Patches(exponents, planes, factor, window, bound(factor, window, record, self._config), live)

"""Bundles of rays that leave one point: hemispheres for form factors, screens for images."""

from golden.frustum.frame import frame
from golden.frustum.hemisphere import Hemisphere
from golden.frustum.record import FrustumRecord, hemisphere_record, screen_record
from golden.frustum.screen import Screen

__all__ = ["FrustumRecord", "Hemisphere", "Screen", "frame", "hemisphere_record", "screen_record"]

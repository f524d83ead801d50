"""Bundles of rays that leave one point: hemispheres for form factors, screens for images."""

from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.frustum.record import FrustumRecord, hemisphere_record, screen_record

__all__ = ["FrustumRecord", "Hemisphere", "Screen", "frame", "hemisphere_record", "screen_record"]

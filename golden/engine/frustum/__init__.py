"""Bundles of rays that leave one point, as records of the machine: hemispheres, screens and shadow frusta."""

from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.frustum.record import FrustumRecord, hemisphere_record, screen_record

__all__ = ["FrustumRecord", "Hemisphere", "Screen", "frame", "hemisphere_record", "screen_record"]

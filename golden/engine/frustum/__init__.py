"""Bundles of rays that leave one point, as records of the machine: hemispheres, screens and shadow frusta."""

from golden.engine.frustum.record import FrustumRecord, hemisphere_record, screen_record

__all__ = ["FrustumRecord", "hemisphere_record", "screen_record"]

"""Illuminance of sensors: each one's, and of each work plane mean, extremes and uniformity."""

import numpy as np

from golden.light.photometry.sensors import Sensors

__all__ = ["plane_figures", "sensor_rows"]

_COLUMNS = ("sensor", "plane", "x", "y", "z", "nx", "ny", "nz", "illuminance")


def sensor_rows(sensors: Sensors, illuminance: np.ndarray) -> list[tuple]:
    """A head, then a row for each sensor: its position, its direction and its illuminance in lux (S float64)."""
    rows = np.concatenate([sensors.position, sensors.normal, illuminance[:, None]], axis=1).tolist()
    return [_COLUMNS, *((number, "" if plane < 0 else plane, *row) for number, (plane, row) in
                        enumerate(zip(sensors.plane.tolist(), rows, strict=True)))]


def plane_figures(sensors: Sensors, illuminance: np.ndarray) -> list[dict]:
    """Of each work plane, and of the single sensors if there are any (plane None), the figures of EN 12464.

    ``mean``, ``minimum`` and ``maximum`` illuminance in lux, and ``uniformity``, minimum over mean (0 in the dark).
    """
    figures = []
    for plane in np.unique(sensors.plane).tolist():
        values = illuminance[sensors.plane == plane]
        mean, minimum = float(values.mean()), float(values.min())
        figures.append({"plane": None if plane < 0 else plane, "sensors": len(values), "mean": mean,
                        "minimum": minimum, "maximum": float(values.max()),
                        "uniformity": minimum / mean if mean > 0 else 0.0})
    return figures

"""Photometric results of a render, written to files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.output import beginning_with, check_outputs
from golden.base.plural import counted
from golden.light.image import false_colour, write_png
from golden.light.photometry.light_table import patch_rows, write_table
from golden.light.photometry.quantities import EFFICACY, candela_per_m2, lux
from golden.light.photometry.sensor_file import read_sensors
from golden.light.photometry.sensor_table import plane_figures, sensor_rows
from golden.light.photometry.sensors import Sensors
from golden.render.two_pass import RenderResult
from golden.scene.scene import Scene

__all__ = ["Photometry"]

# Share of the pixels beyond the colour scale: lamps, mostly.
_BEYOND = 0.01


@dataclass(frozen=True, kw_only=True)
class Photometry:
    """What is measured in a render, in photometric units.

    Parameters
    ----------
    illuminance
        A .csv for illuminance and radiosity of each patch, or None.
    false_colour
        The beginning of the names of two pictures, luminance and illuminance of each pixel, or None.
    decades
        Powers of ten of a logarithmic scale of these pictures, or None: it is linear.
    surfaces
        A .glb for the solved light of all surfaces, or None.
    sensors
        A file of points and work planes, see `read_sensors`, or None.
    sensor_table
        A .csv for the illuminance of each sensor, or None.
    efficacy
        Luminous efficacy in lm/W, above 0.

    Raises
    ------
    InputError
        A file cannot be written, or there is a table of sensors without sensors, or a scale without false colours.
    """

    illuminance: Path | None = None
    false_colour: Path | None = None
    decades: float | None = None
    surfaces: Path | None = None
    sensors: Path | None = None
    sensor_table: Path | None = None
    efficacy: float = EFFICACY

    def __post_init__(self):
        check_outputs(self.illuminance, self.sensor_table, suffixes=(".csv",))
        check_outputs(*self.pictures, suffixes=(".png",))
        check_outputs(self.surfaces, suffixes=(".glb",))
        if self.decades and not self.false_colour:
            raise InputError("Decades must have false colours (--false-colour), not be alone", parameter="decades")
        if self.sensor_table and not self.sensors:
            raise InputError("Sensor table must have sensors (--sensors), not be alone", parameter="sensor_table")

    @property
    def pictures(self) -> tuple[Path, ...]:
        """The two pictures, or none."""
        return beginning_with(self.false_colour, "-luminance.png", "-illuminance.png")

    @property
    def outputs(self) -> tuple[Path | None, ...]:
        """All files that are written."""
        return self.illuminance, self.surfaces, self.sensor_table, *self.pictures

    def read(self) -> Sensors | None:
        """The sensors, or None."""
        return read_sensors(self.sensors) if self.sensors else None

    def write(self, scene: Scene, result: RenderResult, sensors: Sensors | None, *,
              exposure: float | None) -> tuple[dict, str]:
        """Write all files; returns the figures of the sensors as values, and as text."""
        if self.illuminance:
            write_table(self.illuminance, patch_rows(scene, result.indirect, self.efficacy))
        if self.surfaces:
            from golden.light.photometry.surface_file import write_surfaces  # slow

            write_surfaces(self.surfaces, scene, result.indirect, efficacy=self.efficacy, exposure=exposure)
        if self.false_colour:
            values = (candela_per_m2(result.image, self.efficacy), np.pi * self.efficacy * result.received)
            for path, value, what in zip(self.pictures, values, ("luminance, cd/m2", "illuminance, lux"), strict=True):
                write_png(path, false_colour(value, what, top=float(np.quantile(value, 1 - _BEYOND)),
                                             decades=self.decades))
        if sensors is None:
            return {}, ""
        illuminance = lux(result.sensors, self.efficacy)
        if self.sensor_table:
            write_table(self.sensor_table, sensor_rows(sensors, illuminance))
        figures = plane_figures(sensors, illuminance)
        lines = [f"{'illuminance, lux':18} {'mean':>10} {'minimum':>10} {'maximum':>10} {'uniformity':>10}"]
        for row in figures:
            what = f"plane {row['plane']}" if row["plane"] is not None else counted(row["sensors"], "sensor")
            lines.append(f"{what:18} {row['mean']:10.5g} {row['minimum']:10.5g} {row['maximum']:10.5g} "
                         f"{row['uniformity']:10.3f}")
        return {"sensors": figures}, "\n".join(lines)

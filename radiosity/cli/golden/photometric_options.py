"""Options of ``render`` that measure light."""

import click

from radiosity.cli.parameters import FILE, Positive

__all__ = ["PHOTOMETRIC", "PHOTOMETRIC_NAMES"]

PHOTOMETRIC = (
    click.option("--illuminance", type=FILE, help="Write illuminance (lux) and radiosity (lm/m2) of each patch to this "
                 ".csv."),
    click.option("--false-colour", type=FILE, metavar="PREFIX", help="Write luminance (cd/m2) and illuminance (lux) of "
                 "each pixel to PREFIX-luminance.png and PREFIX-illuminance.png, with a legend."),
    click.option("--decades", type=Positive(), help="Make the scale of --false-colour logarithmic, over so many powers "
                 "of ten.  [default: linear]"),
    click.option("--surfaces", type=FILE, help="Write all surfaces in the colours of their radiosity to this .glb."),
    click.option("--sensors", type=FILE, help="Measure illuminance at the points and on the work planes of this file: "
                 "lines x y z nx ny nz, and plane x y z ux uy uz vx vy vz m n."),
    click.option("--sensor-table", type=FILE, help="Write the illuminance of each sensor to this .csv."),
    click.option("--efficacy", type=Positive(), default=179.0, help="Set the luminous efficacy in lm/W; 1 if the "
                 "scene's values are candela, lux and cd/m2."))
"""The options: each sets the field of its name of `radiosity.tasks.photometry.Photometry`."""

PHOTOMETRIC_NAMES = ("illuminance", "false_colour", "decades", "surfaces", "sensors", "sensor_table", "efficacy")
"""The fields."""

"""Options of ``formfactors`` for factors of other kinds than those between all patches of a scene alone."""

import click

from radiosity.cli.parameters import FILE, Numbers, Positive

__all__ = ["FACTOR_OUTPUTS", "FACTOR_OUTPUT_NAMES"]

FACTOR_OUTPUTS = (
    click.option("--period", type=Numbers("EAST,NORTH", least=0), help="Repeat the scene without end after these "
                 "distances: a patch counts with all of its copies."),
    click.option("--by-surface", "surfaces", type=FILE, help="Also write the factors between surfaces, all patches of "
                 "a name together, to this .csv, .nc or .npz."),
    click.option("--receivers", type=(FILE, FILE), metavar="POINTS FILE.csv", help="Also write the factors from points "
                 "to surfaces: lines x y z nx ny nz, or planes as of `render --sensors`."),
    click.option("--drop-below", type=Positive(), help="Leave out the factors of pairs that are smaller in both "
                 "directions; each row adds them to its diagonal, so that it closes."))
"""The options: each sets the parameter of its name of `radiosity.tasks.view_factors.ViewFactorTask`."""

FACTOR_OUTPUT_NAMES = ("period", "surfaces", "receivers", "drop_below")
"""The parameters."""

"""Options of ``formfactors`` for what it writes beside the factors between patches, and what it leaves out of these."""

import click

from golden.commands.parameters import FILE, Positive

__all__ = ["FACTOR_OUTPUTS", "FACTOR_OUTPUT_NAMES"]

FACTOR_OUTPUTS = (
    click.option("--by-surface", "surfaces", type=FILE, help="Also write the factors between surfaces, all patches of "
                 "a name together, to this .csv, .nc or .npz."),
    click.option("--receivers", type=(FILE, FILE), metavar="POINTS FILE.csv", help="Also write the factors from points "
                 "to surfaces: lines x y z nx ny nz, or planes as of `render --sensors`."),
    click.option("--drop-below", type=Positive(), help="Leave out the factors of pairs that are smaller in both "
                 "directions; each row adds them to its diagonal, so that it closes."))
"""The options: each sets the parameter of its name of `golden.tasks.view_factors.ViewFactorTask`."""

FACTOR_OUTPUT_NAMES = ("surfaces", "receivers", "drop_below")
"""The parameters."""

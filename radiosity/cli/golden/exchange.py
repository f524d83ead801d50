"""``exchange``: net radiative heat fluxes from view factors."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.parameters import FILE

__all__ = ["exchange_command"]


@click.command("exchange", cls=Task, named={"sky_temperature": "--sky-temperature"},
               short_help="Compute net radiative heat fluxes.")
@click.argument("factors", type=FILE)
@click.argument("table", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Write temperature, radiosity, irradiance and net flux "
              "of each patch to this .csv.")
@click.option("--sky-temperature", type=float, default=0.0, help="Set the temperature of the sky, a black body, in K.")
@click.option("--script-f", type=FILE, help="Write Hottel's script-F between surfaces to this .csv.")
def exchange_command(factors, table, output, sky_temperature, script_f):
    """Compute net radiative heat fluxes between grey, diffuse patches.

    FACTORS is a .npz or .nc of `formfactors`. TABLE is a .csv with the columns surface (or patch, from 0), temperature
    in K, emissivity, and flux: each row has either a temperature or a net flux in W/m2, 0 if the surface is adiabatic.
    """
    from radiosity.tasks.exchange import exchange

    report, text = exchange(factors, table, output, sky_temperature=sky_temperature, script=script_f)
    console().report(report, text)

"""Options of ``render`` that stand for several others."""

import click

__all__ = ["QUALITIES", "QUALITY"]

QUALITIES = {
    "draft": {"samples": "1", "light_samples": "4", "depth": "2", "rays": "32x8"},
    "normal": {},
    "high": {"samples": "16", "light_samples": "64", "rays": "256x64"},
}
"""By name the values of the options that are not given."""


def _apply(ctx, param, value):
    if value is None:
        return
    if ctx.default_map is not None:
        raise click.UsageError("--quick and --quality exclude each other.", ctx)
    ctx.default_map = dict(QUALITIES[value])


# Eager: other options look for their defaults after these have been read.
QUALITY = (
    click.option("--quality", type=click.Choice(tuple(QUALITIES)), is_eager=True, expose_value=False, callback=_apply,
                 help="Choose --spp, --light-samples, --depth and --rays, as far as they are not given.  "
                 "[default: normal]"),
    click.option("--quick", is_flag=True, flag_value="draft", default=None, is_eager=True, expose_value=False,
                 callback=_apply, help="Choose --quality draft."))
"""The options."""

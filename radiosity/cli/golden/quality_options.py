"""Options of ``render`` that stand for several others."""

import click
from click.core import ParameterSource

__all__ = ["QUALITIES", "quality_options"]

QUALITIES = {
    "sketch": {"light_samples": "1", "depth": "2", "rays": "32x8", "elements": "300"},
    "draft": {"samples": "1", "light_samples": "4", "depth": "2", "rays": "32x8"},
    "normal": {},
    "high": {"samples": "16", "light_samples": "16", "rays": "256x64"},
}
"""By name the values of the options that are not given."""


def _apply(ctx, param, value):
    if value is None:
        return
    if ctx.default_map is not None:
        if ctx.get_parameter_source(param.name) is ParameterSource.DEFAULT:
            return
        raise click.UsageError("--quick and --quality exclude each other.", ctx)
    ctx.default_map = dict(QUALITIES[value])


def quality_options(default: str) -> tuple:
    """The options; ``default`` is the name of the quality without them."""
    # Eager: other options look for their defaults after these have been read.
    return (
        click.option("--quality", type=click.Choice(tuple(QUALITIES)), default=default, is_eager=True,
                     expose_value=False, callback=_apply,
                     help="Choose --spp, --light-samples, --depth, --rays and --elements, as far as they are not "
                     "given."),
        click.option("--quick", is_flag=True, flag_value="draft", default=None, is_eager=True, expose_value=False,
                     callback=_apply, help="Choose --quality draft."))

"""``--method`` and the options of the simulated machine, which ``radiosity`` adds to commands of ``python -m golden``.

The functions take a `radiosity.cli.machine_method.MachineMethod`, or None for a command line without it.
"""

from collections.abc import Callable

import click

from radiosity.cli.console import console
from radiosity.cli.parameters import is_given

__all__ = ["add_options", "machine_options", "method_of", "method_option", "options_of", "work_options"]


def add_options(decorators) -> Callable:
    """A decorator that applies several of `click.option`, the first of them on top."""
    def decorate(function):
        for decorator in reversed(tuple(decorators)):
            function = decorator(function)
        return function
    return decorate


def machine_options(machine, *, kind: str = "options") -> tuple[Callable, ...]:
    """The machine's own options, or none: its ``options``, or its ``frustum_options``."""
    return () if machine is None else getattr(machine, kind)


def method_option(names: tuple[str, ...], machine, *, default: str | None, about: str) -> Callable:
    """The option ``--method``; without a default see `method_of`."""
    unless = [] if default else [" [default: embree where it is installed, else grid]"]
    added = [] if machine is None else [machine]
    return click.option("--method", type=click.Choice([*names, *(one.name for one in added)]), default=default,
                        help=" ".join([about, *(one.about for one in added), *unless]))


def method_of(given: str | None, *, counts_cells: bool) -> str:
    """The method that an option names, or the default one; a line says so if Embree is not installed.

    Parameters
    ----------
    given
        What the option names, or None.
    counts_cells
        Whether another option concerns the cells, which grid alone has.
    """
    if given is not None:
        return given
    if counts_cells:
        return "grid"
    from golden.cast.shared_caster import default_method

    method = default_method()
    if method == "grid":
        console().announce("grid casts, at a fraction of Embree's speed: `pip install radiosity-engine[embree]` "
                           "installs Embree")
    return method


def options_of(machine, chosen: str, given: dict, *, kind: str = "options") -> tuple:
    """The machine if it is the chosen method, else None; and its options, which are taken out of ``given``.

    Raises
    ------
    click.UsageError
        An option of the machine is given, but it is not chosen.
    """
    names = {parameter.name: parameter for parameter in _parameters(machine_options(machine, kind=kind))}
    values = {name: given.pop(name) for name in names if name in given}
    if machine is not None and machine.name == chosen:
        return machine, values
    for name in values:
        if is_given(name):
            raise click.UsageError(f"{names[name].opts[-1]} needs --method {machine.name}.")
    return None, {}


def work_options(machine) -> set[str]:
    """Names of the options that the machine adds to ``cast`` alone, of one hemisphere or screen."""
    work, shared = ({parameter.name for parameter in _parameters(machine_options(machine, kind=kind))}
                    for kind in ("frustum_options", "options"))
    return work - shared


def _parameters(decorators):
    def nothing():
        """No command."""

    return getattr(add_options(decorators)(nothing), "__click_params__", [])

"""Ways to cast frusta that ``radiosity`` adds to the commands of ``python -m golden``."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

import click
from click.core import ParameterSource

from radiosity.cli.console import console

__all__ = ["CastOutcome", "CastingMethod", "add_options", "method_of", "method_option", "options_of", "work_options"]


@dataclass(frozen=True, kw_only=True, eq=False)
class CastOutcome:
    """What a method found for one frustum.

    Parameters
    ----------
    hits
        The frustum's `golden.engine.cast.fixed_hits.FixedHits`.
    report
        More entries of the command's report.
    text
        The same as lines of text.
    agrees
        False if the method's results differ from golden's: the command then exits with code 1.
    """

    hits: object
    report: dict = field(default_factory=dict)
    text: str = ""
    agrees: bool = True


class CastingMethod(ABC):
    """A value of ``--method``, with options of its own.

    Members
    -------
    name
        The value.
    about
        Sentences for the help of ``--method``.
    default_clusters
        The default of ``--clusters`` in words, if it is not always 1.
    options
        Decorators that add the method's options to every command that casts.
    frustum_options
        Those that it adds to ``cast`` in place of ``options``. ``cast`` has ``--clusters``, ``--preset`` and ``-P``
        itself, and gives the method their values.
    """

    name: str
    about: str
    default_clusters: str = ""
    options: tuple[Callable, ...]
    frustum_options: tuple[Callable, ...]

    @abstractmethod
    def check(self, **options) -> None:
        """Refuse options that cannot be used, before the work starts.

        Parameters
        ----------
        options
            Those of the method; ``frustum``, where it is known: columns and rows of the largest frustum.

        Raises
        ------
        InputError
            An option is out of range.
        """

    @abstractmethod
    def frusta(self, scene, *, cell: float | None, shadows: bool = False, **options) -> AbstractContextManager:
        """A caster of frusta with ``counts()`` for the report, ``summary()`` for people, ``ray_kinds``, the kinds of
        rays of an image that it casts, and ``specular_rays``, how many of the others it has cast.

        Parameters
        ----------
        scene
            The patches.
        cell
            Cell size, or None for the method's own.
        shadows
            Whether it must cast shadow frusta.
        """

    @abstractmethod
    def cast(self, record, geometry, config, *, cell: float | None, weights, title: str, **options) -> CastOutcome:
        """Cast one frustum.

        Parameters
        ----------
        record, geometry, config
            The frustum, the patches in its coordinates, and the machine's configuration.
        cell
            Cell size, or None for the method's own.
        weights
            The weights of a hemisphere's rows; None of a screen.
        title
            What is cast into what, for charts.
        """


def add_options(decorators) -> Callable:
    """A decorator that applies several of `click.option`, the first of them on top."""
    def decorate(function):
        for decorator in reversed(tuple(decorators)):
            function = decorator(function)
        return function
    return decorate


def method_option(names: tuple[str, ...], methods: tuple[CastingMethod, ...], *, default: str | None,
                  about: str) -> Callable:
    """The option ``--method``; without a default see `method_of`."""
    unless = [] if default else [" [default: embree where it is installed, else grid]"]
    return click.option("--method", type=click.Choice([*names, *(method.name for method in methods)]), default=default,
                        help=" ".join([about, *(method.about for method in methods), *unless]))


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


def options_of(methods: tuple[CastingMethod, ...], chosen: str, given: dict, *,
               kind: str = "options") -> tuple[CastingMethod | None, dict]:
    """The chosen method if it is one of ``methods``, and its options, which are taken out of ``given``.

    Raises
    ------
    click.UsageError
        An option of a method that was not chosen is given.
    """
    context, found, kept = click.get_current_context(), None, {}
    for method in methods:
        names = {parameter.name: parameter for parameter in _parameters(getattr(method, kind))}
        values = {name: given.pop(name) for name in names if name in given}
        if method.name == chosen:
            found, kept = method, values
            continue
        for name in values:
            if context.get_parameter_source(name) not in (ParameterSource.DEFAULT, None):
                raise click.UsageError(f"{names[name].opts[-1]} needs --method {method.name}.", context)
    return found, kept


def work_options(methods: tuple[CastingMethod, ...]) -> set[str]:
    """Names of the options that the methods add to ``cast`` alone, of one hemisphere or screen."""
    return {parameter.name for method in methods for parameter in _parameters(method.frustum_options)} - {
        parameter.name for method in methods for parameter in _parameters(method.options)}


def _parameters(decorators):
    def nothing():
        """No command."""

    return add_options(decorators)(nothing).__click_params__

"""Configurations of simulated machines."""

from golden.base.errors import InputError
from golden.base.plural import counted
from golden.engine.config import Config
from golden.engine.config.noc import MOST_NODES
from golden.engine.noc.topology import grid_shape

__all__ = ["SIMULATION_DEFAULTS", "overridden", "overridden_text", "simulation_config"]

# Unless a run says otherwise: few rays, memories that are seldom cleared, and shells that do not wait for each other:
# at least this run-ahead depth.
SIMULATION_DEFAULTS = {"icu.rays": 1 << 14, "icu.generation_bits": 8, "ctu.run_ahead": 6}


# Rays of the longest list of a machine that must cast shadow frusta, as a power of two, unless a run says otherwise.
_SHADOW_BITS = 12


def simulation_config(config: Config, *, clusters: int | None, topology: str | None, given: tuple[str, ...] = (),
                      rays: int = 0, shadows: bool = False) -> Config:
    """A configuration for so many clusters, with `SIMULATION_DEFAULTS`.

    Parameters
    ----------
    clusters, topology
        None: those of ``config``.
    given
        Parameters, by path, that the user has chosen and that stay.
    rays
        Rays of a frustum; the capacity suffices however they are distributed.
    shadows
        Whether it must cast shadow frusta (``icu.shadow_bits``).

    Raises
    ------
    InputError
        The topology does not allow this number of clusters, or ``given`` has what ``clusters`` or ``topology`` set.
    """
    for option, value, names in (("--topology", topology, {"noc.topology"}),
                                 ("--clusters", clusters, {"noc.columns", "noc.rows"})):
        if value is not None and (both := names & set(given)):
            name = min(both)
            raise InputError(f"machine: {option} sets {name} ({option} {value} here), so -P {name} cannot be given")
    defaults = SIMULATION_DEFAULTS | {
        "icu.rays": max(SIMULATION_DEFAULTS["icu.rays"], rays),
        "ctu.run_ahead": max(SIMULATION_DEFAULTS["ctu.run_ahead"], config.ctu.run_ahead)}
    if shadows and not config.icu.shadow_bits:
        defaults["icu.shadow_bits"] = _SHADOW_BITS
    changes = {name: value for name, value in defaults.items() if name not in given}
    if topology is not None:
        changes["noc.topology"] = topology
    if clusters is not None:
        most = MOST_NODES - config.noc.patch_nodes
        if config.noc.patch_nodes and clusters > most:
            raise InputError(f"machine: --clusters must be at most {most} beside "
                             f"{counted(config.noc.patch_nodes, 'patch node')} (noc.patch_nodes), not {clusters}")
        changes["noc.columns"], changes["noc.rows"] = grid_shape(max(1, clusters) + config.noc.patch_nodes)
    return config.replace(changes)


def overridden(simulated: Config, config: Config) -> dict[str, dict[str, int]]:
    """What `simulation_config` sets and ``config`` has otherwise, each with both values: ``simulated``, ``given``."""
    values, given = simulated.parameters(), config.parameters()
    return {name: {"simulated": values[name], "given": given[name]}
            for name in (*SIMULATION_DEFAULTS, "icu.shadow_bits") if values[name] != given[name]}


def overridden_text(changes: dict[str, dict[str, int]]) -> str:
    """The result of `overridden` as the end of a line; nothing if it is empty."""
    named = ", ".join(f"{name} {one['simulated']} instead of {one['given']}" for name, one in changes.items())
    return f"; simulated with {named}" if named else ""

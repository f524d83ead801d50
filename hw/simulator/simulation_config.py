"""Configurations of simulated machines."""

from golden.config import Config
from golden.noc.topology import grid_shape

__all__ = ["SIMULATION_DEFAULTS", "simulation_config"]

# Unless a run says otherwise: few rays, memories that are seldom cleared, and shells that do not wait for each other:
# at least this run-ahead depth.
SIMULATION_DEFAULTS = {"icu.rays": 1 << 14, "icu.generation_bits": 8, "ctu.run_ahead": 6}


def simulation_config(config: Config, *, clusters: int, topology: str, given: tuple[str, ...] = (),
                      rays: int = 0) -> Config:
    """A configuration for so many clusters, with `SIMULATION_DEFAULTS`.

    Parameters
    ----------
    given
        Parameters, by path, that the user has chosen and that stay.
    rays
        Rays of a frustum; the capacity suffices however they are distributed.

    Raises
    ------
    InputError
        The topology does not allow this number of clusters.
    """
    columns, rows = grid_shape(max(1, clusters))
    defaults = SIMULATION_DEFAULTS | {
        "icu.rays": max(SIMULATION_DEFAULTS["icu.rays"], rays),
        "ctu.run_ahead": max(SIMULATION_DEFAULTS["ctu.run_ahead"], config.ctu.run_ahead)}
    changes = {name: value for name, value in defaults.items() if name not in given}
    return config.replace({**changes, "noc.topology": topology, "noc.columns": columns, "noc.rows": rows})

"""Options of all commands that run the machine."""

import json
from collections.abc import Callable
from pathlib import Path

import click

from golden.commands.parameters import ASSIGNMENTS, FILE, PRESET
from golden.config import PRESETS, Config
from golden.errors import InputError
from golden.noc.topology import TOPOLOGIES
from golden.output import whole_file
from hw.memsys.cache_policy import CachePolicy
from hw.simulator.simulated_machine import SimulatedMachine
from hw.simulator.simulation_config import simulation_config

__all__ = ["cell_option", "machine_config", "machine_options", "open_rig", "write_json"]

_OPTIONS = (
    click.option("--clusters", type=int, default=1, help="Of the machine, a power of two up to 64."),
    click.option("--topology", type=click.Choice(TOPOLOGIES), default="mesh", help="Of its network."),
    click.option("--policy", type=click.Choice([one.name.lower() for one in CachePolicy]), help="Of its caches.  "
                 "[default: the configuration's]"),
    click.option("--latency", type=click.IntRange(1, 10_000), default=10, help="Cycles to main memory."),
    click.option("--spread", type=click.IntRange(0, 10_000), default=0, help="Up to so many more, by chance, and "
                 "replies in any order."),
    click.option("--memory-seed", type=click.IntRange(0, 1 << 32), default=1, help="Of that chance."),
    PRESET, ASSIGNMENTS)
cell_option = click.option("--cell", type=click.FloatRange(1 / 256, 1), default=0.0625,
                           help="Cell size, share of the scene's longest side.")


def machine_options(function: Callable) -> Callable:
    """Adds them to a command; they are ``machine`` in its arguments."""
    for option in reversed(_OPTIONS):
        function = option(function)
    return function


def machine_config(*, clusters: int, topology: str, preset: str, assignments: tuple[str, ...], **_) -> Config:
    """The configuration that they ask for.

    Errors
    ------
    InputError
        Clusters are no power of two up to 64, or as `Config.with_parameters`.
    """
    if not 1 <= clusters <= 64 or clusters & (clusters - 1):
        raise InputError(f"machine: Clusters must be a power of two up to 64, not {clusters}")
    return simulation_config(PRESETS[preset].with_parameters(assignments), clusters=clusters, topology=topology,
                         given=tuple(one.partition("=")[0] for one in assignments))


def open_rig(config: Config, *, policy: str | None, latency: int, spread: int, memory_seed: int,
             traced: bool = False, **_) -> SimulatedMachine:
    """The machine that they ask for."""
    return SimulatedMachine(config, policy=CachePolicy[policy.upper()] if policy else None, latency=latency,
                            spread=spread, shuffles=spread > 0, seed=memory_seed, traced=traced)


def write_json(path: Path, values: dict) -> None:
    """Write them whole or not at all."""
    with whole_file(path) as part:
        part.write_text(json.dumps(values, indent=1) + "\n")


stats_option = click.option("--stats", type=FILE, help="Write counts. (.json)")

"""Simulated machines as commands and the public interface choose them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from golden.base.errors import InputError, is_whole

if TYPE_CHECKING:  # commands that only print their help import this
    from golden.engine.config import Config
    from radiosity.flow.simulator.simulated_machine import SimulatedMachine

__all__ = ["MOST_CLUSTERS", "checked_clusters", "opened_machine"]

MOST_CLUSTERS = 64
"""Most clusters of a simulated machine."""


def checked_clusters(clusters: int | None) -> int | None:
    """The number as int, if a machine may have so many clusters; None is the preset's number.

    Raises
    ------
    InputError
        It may not.
    """
    if clusters is not None and (not is_whole(clusters) or not 1 <= clusters <= MOST_CLUSTERS
                                 or clusters & (clusters - 1)):
        raise InputError(f"machine: Clusters must be a power of two up to {MOST_CLUSTERS}, not {clusters}",
                         parameter="clusters")
    return None if clusters is None else int(clusters)


@contextmanager
def opened_machine(config: "Config", *, policy: str | None, latency: int, spread: int = 0, memory_seed: int = 1,
                   traced: bool = False, progress: bool = False) -> "Iterator[SimulatedMachine]":
    """The `radiosity.flow.simulator.simulated_machine.SimulatedMachine`; what goes wrong in it is an error of one line.

    Parameters
    ----------
    config
        Of the machine.
    policy
        Of its caches: direct, lru or lfu. None: the configuration's.
    latency, spread, memory_seed
        Of main memory, in cycles: of each read, of a random delay on top, and the seed of that.
    traced
        Whether its signals can be written.
    progress
        Shows bars while it is compiled.

    Raises
    ------
    InputError
        Main memory is so slow that reads time out, or it cannot be compiled, or ends with a fault.
    """
    most = (1 << config.memory.timeout_bits) - 1
    if latency + spread > most:
        raise InputError(f"machine: Latency and spread must be at most {most} cycles together, after which reads time "
                         f"out (-P memory.timeout_bits), not {latency} and {spread}", parameter="latency")
    from hw.memsys.bus.cache_policy import CachePolicy
    from radiosity.flow.host import EngineError, EngineTimeoutError
    from radiosity.flow.simulator.simulated_machine import SimulatedMachine

    try:
        with SimulatedMachine(config, policy=CachePolicy[policy.upper()] if policy else None, latency=latency,
                              spread=spread, shuffles=spread > 0, seed=memory_seed, traced=traced,
                              progress=progress) as machine:
            yield machine
    except (EngineError, EngineTimeoutError, RuntimeError) as error:
        raise InputError(f"machine: {error}") from error

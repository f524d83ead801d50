"""Frusta on the simulated machine."""

from collections.abc import Mapping

from golden.base.errors import check_choice, whole_number
from golden.engine.config import PRESETS
from golden.engine.frustum.frustum_choice import FrustumChoice
from golden.scene.scene import Scene
from radiosity.cli.golden.choices import TOPOLOGIES
from radiosity.cli.hw.choices import POLICIES
from radiosity.flow.simulator.simulated_machines import checked_clusters, opened_machine
from radiosity.flow.simulator.simulation_config import overridden, simulation_config
from radiosity.tasks.machine_cast import CastOptions, MachineCast, MachineCastResult

__all__ = ["machine"]


def machine(scene: Scene, *, origin: tuple[float, float, float] | None = None,
            normal: tuple[float, float, float] | None = None, patch: int | None = None,
            screen: tuple[int, int] | None = None, rays: tuple[int, int] = (256, 64), clusters: int | None = None,
            preset: str = "paper", parameters: Mapping[str, int | str] | None = None, cell: float | None = None,
            casts: int = 3, topology: str | None = None, policy: str | None = None, latency: int = 10,
            progress: bool = False) -> MachineCastResult:
    """Cast one frustum on the simulated machine: its RTL, which is compiled when it is first used.

    Needs the extra ``sim``, a C++ compiler and make.

    Parameters
    ----------
    scene
        The patches.
    origin, normal
        Where the rays of a hemisphere start, and the direction of its middle.
    patch
        In place of both, the middle of this patch's front.
    screen
        In place of a hemisphere, columns and rows of rays through the scene's view.
    rays
        Azimuths and polars of a hemisphere, powers of two.
    clusters
        Clusters that share the frustum, a power of two up to 64. Default: the preset's.
    preset, parameters
        The machine's configuration: a preset, and values of parameters by path, such as ``{"icu.rays": 4096}``.
    cell
        Cell size as a share of the scene's longest side. Default: the one with the fewest predicted cycles.
    casts
        How many times the frustum is cast; the first cast loads the tables.
    topology, policy
        The network (mesh, torus, ring, illiac, hypercube), and the caches' policy (direct, lru, lfu). Default: the
        preset's.
    latency
        Of main memory, in cycles.
    progress
        Shows bars for what takes more than two seconds.

    Returns
    -------
    `MachineCastResult`: ``patch`` (rows x columns), ``counters`` (arrays of casts x clusters), ``cycles``, ``agrees``
    with the golden model, and more.

    Raises
    ------
    InputError
        A value cannot be used, or the machine is too small for the frustum.
    """
    for name, value, known in (("preset", preset, PRESETS), ("topology", topology, TOPOLOGIES),
                               ("policy", policy, POLICIES)):
        if value is not None:
            check_choice(f"machine: {name.capitalize()}", value, known, parameter=name)
    casts, latency = (whole_number(f"machine: {name.capitalize()}", count, 1, 10_000, parameter=name)
                      for name, count in (("casts", casts), ("latency", latency)))
    clusters = checked_clusters(clusters)
    given = parameters or {}
    config = PRESETS[preset].with_parameters(f"{path}={value}" for path, value in given.items())
    simulated = simulation_config(config, clusters=clusters, topology=topology, given=tuple(given))
    choice = FrustumChoice(origin=origin, normal=normal, patch=patch, rays=rays, screen=screen)
    record, geometry, weights = choice.record(scene, config)
    prepared = MachineCast(record, geometry, weights, simulated,
                           CastOptions(cell=cell, casts=casts, changes=overridden(simulated, config)))
    with opened_machine(simulated, policy=policy, latency=latency, progress=progress) as opened:
        return prepared.run(opened, title=scene.name, progress=progress)

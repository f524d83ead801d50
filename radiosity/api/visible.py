"""Whether points see a point of a light."""

from collections.abc import Mapping

import numpy as np

from golden.base.errors import InputError, check_choice
from golden.cast.methods import check_cell
from golden.engine.cast.methods import FIXED_METHODS
from golden.engine.config import PRESETS
from golden.light.photometry.sensors import Sensors
from golden.scene.scene import Scene
from radiosity.flow.simulator.machine_caster import MachineCaster
from radiosity.flow.simulator.simulated_machines import checked_clusters, opened_machine
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.tasks.shadows import shadow_rays

__all__ = ["visible"]


def visible(scene: Scene, *, origin: tuple[float, float, float] | None = None, patch: int | None = None,
            targets: Sensors | None = None, method: str = "shelling", cell: float | None = None,
            clusters: int | None = None, preset: str = "paper", parameters: Mapping[str, int | str] | None = None,
            progress: bool = False) -> np.ndarray:
    """Whether nothing is between a point of a light and each of some points, by the machine's shadow frusta.

    What is in the plane of a point, or in the last share 2^-16 / h of a ray, does not count: h is the light's height
    over that plane, the side of a cube around scene and light being 1. So a point whose plane passes through the light,
    which does not light it, is visible whatever is between.

    Parameters
    ----------
    scene
        The patches.
    origin, patch
        The point of the light, or the patch in whose middle it is.
    targets
        The points, and the directions that their surfaces face. Default: the middles of all patches.
    method
        How rays are cast: shelling, naive-fixed or machine (the simulated one), with the same answers.
    cell
        Cell size as a share of the scene's longest side; naive-fixed has none. Default: that of the method.
    clusters, preset, parameters
        The simulated machine, see `radiosity.machine`; of method machine alone. Its ``icu.shadow_bits`` is 12 by
        default.
    progress
        Shows bars for what takes more than two seconds.

    Returns
    -------
    Bool, one for each target.

    Raises
    ------
    InputError
        A value cannot be used.
    """
    for name, value, known in ("method", method, [*FIXED_METHODS, "machine"]), ("preset", preset, PRESETS):
        check_choice(f"visible: {name.capitalize()}", value, known, parameter=name)
    check_cell(method, cell)
    rays = shadow_rays(scene, origin=origin, patch=patch, targets=targets)
    if method in FIXED_METHODS:
        for name, option in ("clusters", clusters), ("parameters", parameters):
            if option is not None:
                raise InputError(f"visible: {name.capitalize()} must be left out with method {method}, not {option!r}",
                                 parameter=name)
        frusta = FIXED_METHODS[method](scene, *([cell] if method == "shelling" else []))
        return ~frusta.shadows(rays, least=1).blocked
    clusters = checked_clusters(clusters)
    given = parameters or {}
    config = simulation_config(PRESETS[preset].with_parameters(f"{path}={value}" for path, value in given.items()),
                               clusters=clusters, topology=None, given=tuple(given), shadows=True)
    MachineCaster.check(config)
    with opened_machine(config, policy=None, latency=10, progress=progress) as machine:
        return ~MachineCaster(scene, machine, cell=cell, progress=progress).shadows(rays, least=1).blocked

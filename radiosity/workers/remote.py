"""What runs in a worker process."""

import threading
from functools import lru_cache

from golden.cast.methods import RAY_METHODS
from golden.cast.shared_caster import shared_caster
from golden.engine.cast.methods import frustum_caster
from golden.scene.scene import Scene
from radiosity.workers.parcel import Parcel
from radiosity.workers.proof import Proof

__all__ = ["known_objects", "run_span"]

# The work of each thread: what counts rays must not be shared.
_work = threading.local()


def known_objects(scene: Scene, frusta, rays) -> dict[str, object]:
    """The objects that a client and its workers have, by their names in parcels."""
    return {"scene": scene, "rays": rays, "frusta": frusta}


def run_span(proof: Proof, cell: float | None, scene: Parcel, work: Parcel, first: int, last: int):
    """What a function of ``first`` and ``last`` returns.

    Parameters
    ----------
    proof
        That of the client; its method casts.
    cell
        Cell size, or None for the method's own.
    scene, work
        The scene, and the function, which refers to the scene and its casters.

    Raises
    ------
    InputError
        See `Proof.check`.
    """
    proof.check()
    key = proof.method, cell, scene, work
    if getattr(_work, "key", None) != key:
        _work.function = work.open(_known(proof.method, cell, scene))
        _work.key = key
    return _work.function(first, last)


@lru_cache(maxsize=1)
def _known(method, cell, scene):
    opened = scene.open({})
    frusta = frustum_caster(opened, method, cell=cell, jobs=1)
    return known_objects(opened, frusta, frusta if method in RAY_METHODS else shared_caster(opened, "grid", 1))

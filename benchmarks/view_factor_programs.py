"""View factors of facets by this package, by pyViewFactor and by raystrack, each in a process of its own."""

import multiprocessing
import time
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from benchmarks.view_factor_cases import plate_between_plates
from golden.base.peak_memory import peak_memory
from golden.light.factors.interface import view_factors

__all__ = ["PROGRAMS", "Computation", "compute", "in_own_process"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Computation:
    """What a program gave for N facets.

    Parameters
    ----------
    F, sky
        N x N float64 from row to column, and N float64, or None where the program has no sky.
    rest
        N float64: radiation that neither F nor the sky has, such as that which black backs take.
    seconds, memory
        Of a run whose code was compiled before, and the most bytes that its process had.
    """

    F: np.ndarray
    sky: np.ndarray | None
    rest: np.ndarray
    seconds: float
    memory: int


def in_own_process(function, *arguments, seconds: float | None = None):
    """What a function of a module gives in a new process, whose peak memory is then its own.

    Raises
    ------
    TimeoutError
        It took more than ``seconds``; the process is stopped.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(sender, function, arguments))
    process.start()
    sender.close()
    try:
        if not receiver.poll(seconds):
            raise TimeoutError(f"{function.__name__} took more than {seconds:g} s")
        result, error = receiver.recv()
    finally:
        process.kill()
        process.join()
    if error is not None:
        raise error
    return result


def _send(sender, function, arguments):
    try:
        sender.send((function(*arguments), None))
    except Exception as error:  # it is raised in the process that waits
        sender.send((None, error))


def compute(program: str, facets: np.ndarray, error: float) -> Computation | None:
    """Run a program of `PROGRAMS` on N x 4 x 3 facets; None if it is not installed."""
    module, function = PROGRAMS[program]
    if find_spec(module) is None:
        return None
    # A few facets, some of which hide others, have all code compiled.
    function(plate_between_plates().facets, error)
    begin = time.perf_counter()
    F, sky, rest = function(facets, error)
    return Computation(F=F, sky=sky, rest=rest, seconds=time.perf_counter() - begin, memory=peak_memory())


def _radiosity(facets, error):
    found = view_factors(facets, error=error)
    return found.F.toarray(), found.sky, found.back


def _pyviewfactor(facets, error):
    """It has no error to set."""
    import pyvista
    from pyviewfactor import compute_viewfactor_matrix

    corners = [facet[:3] if (facet[2] == facet[3]).all() else facet for facet in facets]
    sizes = np.array([len(corner) for corner in corners])
    starts = np.cumsum(sizes) - sizes
    faces = np.concatenate([[size, *range(start, start + size)] for size, start in zip(sizes, starts, strict=True)])
    mesh = pyvista.PolyData(np.concatenate(corners), faces)
    # Its rows are the receivers.
    return compute_viewfactor_matrix(mesh, obstacles=mesh).T, None, np.zeros(len(facets))


def _raystrack(facets, error):
    from raystrack import Accuracy, Mesh, Query, Sampling, Scene, SolveOptions, Solver

    quads = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    scene = Scene.from_meshes({
        str(number): Mesh(facet.astype(np.float32), quads[:1] if (facet[2] == facet[3]).all() else quads)
        for number, facet in enumerate(facets)})
    options = SolveOptions(sampling=Sampling(seed=1), accuracy=Accuracy(tolerance=error / 2))
    with Solver(scene, device="cpu", bvh="builtin") as solver:
        result = solver.solve(Query.matrix(), options)
    F, rest = np.zeros((len(facets),) * 2), np.zeros(len(facets))
    sky = np.zeros(len(facets))
    for row in range(len(facets)):
        for channel, value in result.row(str(row)).items():
            if channel.kind != "surface":
                sky[row] += value
            elif channel.side == "front":
                F[row, int(channel.surface_id)] = value
            else:
                rest[row] += value
    return F, sky, rest


# Names, modules and functions.
PROGRAMS = {"this package": ("golden", _radiosity), "pyViewFactor": ("pyviewfactor", _pyviewfactor),
            "raystrack": ("raystrack", _raystrack)}

"""Pass 1: the indirect light of a scene, by radiosity."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.frustum import Hemisphere
from golden.light.direct import DirectLight
from golden.light.form_factors import hemisphere_sums
from golden.light.nodes import Nodes
from golden.light.sampling import mix, uniform
from golden.light.solvers import SOLVERS, RadiositySystem, Solution
from golden.light.surface_points import SurfacePoints, bilinear
from golden.light.tally import Tally
from golden.scene.refine import Refinement
from golden.scene.scene import Scene

__all__ = ["IndirectLight", "indirect_light"]

# Points on each element at which pass 1 samples the direct light.
POINTS = 4
# A node that sees more than this share of its hemisphere filled with backs of one-sided patches is inside a body.
BURIED = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class IndirectLight:
    """The indirect light at the nodes of a scene.

    Parameters
    ----------
    nodes
        The nodes.
    irradiance
        M x 3, irradiance over pi in units of radiance; light that comes straight from light sources not included.
    elements
        How many elements there are, backs of two-sided ones included.
    solution
        The radiosity solver's report.
    """

    nodes: Nodes
    irradiance: np.ndarray
    elements: int
    solution: Solution

    def at(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray, front: np.ndarray) -> np.ndarray:
        """Interpolated irradiance over pi at K points of patches (see `Nodes.at`), K x 3."""
        nodes, weights = self.nodes.at(patch, u, v, front)
        return np.einsum("kn,knc->kc", weights, self.irradiance[nodes])


def indirect_light(scene: Scene, refinement: Refinement, caster, tally: Tally, *, hemisphere: Hemisphere, solver: str,
                   light_samples: int, seed: int, progress: bool = False) -> IndirectLight:
    """Solve the radiosity system of a scene's elements for the light that they reflect.

    The light sources are not part of the system: what arrives straight from them at an element is sampled by shadow
    rays and takes the place of the element's emission. Form factors are cast at the nodes; an element's row is the mean
    of its corners' rows. The same rows then give the irradiance at the nodes from the solution. Specular and
    transparent shares count as diffuse in this pass. The background lights a node through the rays that hit nothing.

    Parameters
    ----------
    scene, refinement
        The patches and their elements.
    caster, tally
        What casts rays, and their account.
    hemisphere
        The grid of rays at each node.
    solver
        A name of `SOLVERS`.
    light_samples
        Shadow rays per element to area lights, rounded up to a multiple of 4.
    seed
        Of the samples.
    progress
        Shows a bar once two seconds have passed.

    Source: Shen 1993, section 2.4.
    """
    with tally.stage("nodes"):
        nodes = Nodes(scene, refinement)
    columns = nodes.of_elements.shape[0]
    with tally.stage("form factors"):
        sums = hemisphere_sums(tally.counting("hemisphere", caster), hemisphere, nodes.position, nodes.normal,
                               nodes.source, columns=columns, column_of=_element_columns(scene, refinement, nodes),
                               progress=progress)
        unit = 2.0**-sums.weight_bits
        rows = sums.weights.astype(np.float64) * unit
        missed = 1 - sums.row_sums * unit
        buried = sums.row_sums * unit - rows.sum(axis=1) > BURIED
        sky = missed[:, None] * np.asarray(scene.background)
        mean = _mean_of_open(nodes.of_elements, buried)
    with tally.stage("direct light of elements"):
        direct = _direct(scene, refinement, nodes, DirectLight(scene, caster, tally, -(-light_samples // POINTS)), seed)
    with tally.stage("solver"):
        element = nodes.elements
        parent = refinement.parent[element]
        reflectance = sum(scene.channels(name)[parent] for name in ("diffuse", "specular", "transparent"))
        system = RadiositySystem(form_factors=(mean @ rows).tocsr(), reflectance=np.minimum(reflectance, 1),
                                 emission=reflectance * (direct + mean @ sky), area=refinement.scene.areas[element],
                                 centre=refinement.scene.vertices[element].mean(axis=1),
                                 normal=nodes.sides[:, None] * scene.normals[parent])
        solution = SOLVERS[solver](system, progress=progress)
        irradiance = _fill(nodes.of_elements, rows @ solution.display + sky, buried)
    return IndirectLight(nodes=nodes, irradiance=irradiance, elements=columns, solution=solution)


def _element_columns(scene, refinement, nodes):
    """The rule that counts a ray for the side of the element it hit."""

    def column_of(rays, hits):
        element = refinement.locate(hits.patch, hits.u, hits.v)
        front = np.einsum("rj,rj->r", rays.direction, scene.normals[hits.patch]) < 0
        return np.where(front, element, nodes.back[element])

    return column_of


def _direct(scene, refinement, nodes, light, seed):
    """Direct irradiance over pi of each side of each element: the mean of a few points on it."""
    column = np.repeat(np.arange(len(nodes.elements)), POINTS)
    element, side = nodes.elements[column], nodes.sides[column]
    keys = mix(seed, 1, column, np.tile(np.arange(POINTS), len(column) // POINTS))
    # One point in each quarter of the element.
    quarter = np.arange(len(column)) % POINTS
    u, v = (quarter % 2 + uniform(keys, 2)) / 2, (quarter // 2 + uniform(keys, 3)) / 2
    v = np.where(refinement.scene.is_triangle[element], 1 - np.sqrt(1 - v), v)
    patch = refinement.parent[element]
    points = SurfacePoints(bilinear(refinement.scene.vertices[element], u, v),
                           side[:, None] * scene.normals[patch], patch)
    return light.irradiance(points, keys).reshape(-1, POINTS, 3).mean(axis=1)


def _mean_of_open(of_elements, buried):
    """The mean over an element's corners that are not inside a body."""
    mean = of_elements @ sparse.diags_array(np.where(buried, 0.0, 1.0))
    total = mean.sum(axis=1)
    return sparse.diags_array(1 / np.where(total > 0, total, 1)) @ mean


def _fill(of_elements, values, buried):
    """Give nodes inside bodies the mean of their neighbours outside, and theirs in turn, so that no dark creeps out."""
    values, known = np.where(buried[:, None], 0.0, values), ~buried
    touch = (of_elements.T @ of_elements).tocsr()
    while not known.all():
        share = touch @ known.astype(np.float64)
        fresh = np.flatnonzero(~known & (share > 0))
        if not len(fresh):
            break
        values[fresh] = (touch[fresh] @ (values * known[:, None])) / share[fresh, None]
        known[fresh] = True
    return values

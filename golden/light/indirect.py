"""Pass 1: the indirect light of a scene, by radiosity."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import isqrt

import numpy as np
from scipy import sparse

from golden.base.compiled import compiled
from golden.base.spread import Spread, in_turn
from golden.cast.casters import CastsFrusta, CastsRays
from golden.cast.density import Density
from golden.cast.hemisphere import Hemisphere
from golden.cast.methods import shadow_caster
from golden.light.contacts import PARTS, Contacts
from golden.light.direct import DirectLight
from golden.light.elements import Elements
from golden.light.glass import Glass
from golden.light.lattice import Lattice
from golden.light.node_rows import NodeRows, joined
from golden.light.piece_rows import PieceRows
from golden.light.pieces import MIDDLES, Pieces
from golden.light.preview import Preview
from golden.light.sampling import mix, uniform
from golden.light.solvers import SOLVERS, RadiositySystem, Solution
from golden.light.solvers.on_demand import Shooting, shoot
from golden.light.surface_points import SurfacePoints, bilinear
from golden.light.tally import Tally
from golden.scene.refine import Refinement
from golden.scene.scene import Scene

__all__ = ["IndirectLight", "indirect_light"]

# Points on each element at which pass 1 samples the direct light.
POINTS = 4
# Adaptive refinement: elements whose corners differ by more than this share of the scene's mean are cut CUTS times
# along each side; at most one element in EVERY.
CONTRAST, CUTS, EVERY = 0.05, 4, 40
# Pieces whose direct light differs by more than this share of the mean of all pieces are uneven.
UNEVEN = 0.2
# Least reflectance of a piece in shooting.
BLACK = 1e-6
# Nodes whose hemispheres are timed for an estimate.
TIMED = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class IndirectLight:
    """The indirect light on the surfaces of a scene.

    Parameters
    ----------
    elements
        The elements of the radiosity system, with the lattice of nodes at their corners.
    irradiance
        M x 3 float64 for the M nodes: irradiance over pi in units of radiance, without direct light.
    refined, refined_irradiance
        The same for a lattice with a sheet for each element that adaptive refinement cut.
    sheet
        For each cell of the elements' lattice its sheet in ``refined``, or -1.
    contacts, usable
        Where surfaces touch, and for their cells T x `PARTS`^2 x 4 bool: the corners that parts see, outside bodies.
    pieces, display
        The unknowns of the radiosity system, and their solution, P x 3.
    uneven
        P bool: whether direct light differs within a piece.
    reflectance
        C x 3: of the light that rays do not carry on from elements, the shares that these reflect.
    reflected
        C x 3: the shares of all arriving light that elements reflect, mirrors and glass included.
    of_nodes
        Sparse C x M: the mean over each element of what its nodes have.
    received, radiosity
        C x 3 each: irradiance over pi of the elements, direct light included, and what they emit and reflect, in units
        of radiance; what mirrors and glass reflect counts as diffuse.
    rows
        Casts hemispheres at further points.
    solution
        The radiosity solver's report.
    nodes
        Number of the hemispheres cast.
    buried, refined_buried
        Bool for each node: whether it is inside a body.
    """

    elements: Elements
    irradiance: np.ndarray
    refined: Lattice
    refined_irradiance: np.ndarray
    sheet: np.ndarray
    contacts: Contacts
    usable: np.ndarray
    pieces: Pieces
    display: np.ndarray
    uneven: np.ndarray
    reflectance: np.ndarray
    reflected: np.ndarray
    of_nodes: sparse.csr_array
    received: np.ndarray
    radiosity: np.ndarray
    rows: NodeRows
    solution: Solution
    nodes: int
    buried: np.ndarray
    refined_buried: np.ndarray

    def at(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray, front: np.ndarray) -> np.ndarray:
        """Interpolated irradiance over pi at K points of patches, K x 3; ``front``: on the front side."""
        position = self.elements.at(patch, u, v, front)
        result = _interpolated(self._open(position), self.irradiance)
        sheet = self.sheet[position.cell]
        some = np.flatnonzero(sheet >= 0)
        fine = self.refined.at(sheet[some], position.a[some], position.b[some])
        result[some] = _interpolated(fine, self.refined_irradiance)
        return result

    def touched(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray, front: np.ndarray) -> np.ndarray:
        """K bool: whether light at K points of patches is not to be interpolated."""
        position = self.elements.at(patch, u, v, front)
        row, part = self.contacts.row[position.cell], Contacts.part(position)
        some = np.flatnonzero(row >= 0)
        result = np.zeros(len(row), dtype=bool)
        place = row[some], part[some]
        result[some] = self.contacts.close[place] | ~self.usable[place].all(axis=1)
        return result

    def _open(self, position):
        """Positions with weights for corners that they see and that are outside bodies alone, if there are any."""
        place = self.contacts.places(position)
        some = np.flatnonzero(place >= 0)
        row, part = np.divmod(place[some], PARTS**2)
        own, nodes, weights = position[some], position.nodes.copy(), position.weights.copy()
        # Beyond a border light is that of the middle of the part there.
        moved = (row != self.contacts.row[own.cell]) | (part != Contacts.part(own))
        nodes[some[moved]] = self.contacts.nodes[row[moved]]
        shares = np.where(moved[:, None], MIDDLES[part], own.weights)
        seen = shares * self.usable[row, part]
        total = seen.sum(axis=1, keepdims=True)
        weights[some] = np.where(total > 0, seen / np.where(total > 0, total, 1), shares)
        return replace(position, nodes=nodes, weights=weights)

    def changed(self, change: np.ndarray, refined_change: np.ndarray) -> "IndirectLight":
        """With other irradiance over pi at nodes, of ``refined`` too; never below zero, and as before inside bodies.

        What elements receive and reflect follows.
        """
        def filled(lattice, values, change, buried):
            return _fill(lattice.neighbours, np.maximum(values + change, 0), buried)

        irradiance = filled(self.elements.lattice, self.irradiance, change, self.buried)
        more = self.of_nodes @ (irradiance - self.irradiance)
        return replace(
            self, irradiance=irradiance, received=np.maximum(self.received + more, 0),
            radiosity=np.maximum(self.radiosity + self.reflected * more, 0),
            refined_irradiance=filled(self.refined, self.refined_irradiance, refined_change, self.refined_buried))


def indirect_light(scene: Scene, refinement: Refinement, frusta: CastsFrusta, caster: CastsRays, tally: Tally, *,
                   hemisphere: Hemisphere, solver: str, light_samples: int, seed: int, density: Density | None = None,
                   shooting: Shooting | None = None, preview: Preview | None = None, spread: Spread = in_turn,
                   progress: bool = False, estimate: Callable[[int, float], None] | None = None) -> IndirectLight:
    """Solve the radiosity system of a scene's elements for the light that they reflect.

    The light sources are not part of the system: shadow rays sample their irradiance at an element, and its reflection
    replaces the element's emission. Form factors are cast at the nodes; an element's row is the mean of its corners'
    rows. The same rows give the irradiance at the nodes from the solution. Adaptive refinement adds nodes where the
    irradiance changes most, next to bodies on a surface. What clear patches let pass goes straight on; `Glass` says
    which patches mirror. Other specular shares, and what other clear patches mirror, count as diffuse in this pass. The
    background illuminates a node through the rays that hit nothing. Channels that see coloured glass or mirrors
    differently have systems of their own.

    With ``shooting`` bright pieces of elements shoot their light through a hemisphere from their middles, and nodes
    have the mean of the light around them: nothing is cast there or refined. Light of a background is not found, and
    no patch may be clear or a flat mirror: reciprocity holds where rays end alone.

    Parameters
    ----------
    frusta, caster, tally
        Caster of hemispheres, caster of shadow rays, and their counts.
    hemisphere, density
        The grid of rays at each node, and where finer rays are cast, see `golden.light.form_factors.hemisphere_sums`.
    solver
        A name of `SOLVERS`.
    light_samples
        Shadow rays per element to area lights, rounded up to a multiple of 4.
    seed
        Seed of the samples.
    shooting
        Casts rows when they are needed, in place of ``solver``.
    preview
        Draws pictures between the steps of ``shooting``.
    spread
        Casts spans of the hemispheres. Default: one after the other.
    progress
        Shows a progress bar after two seconds.
    estimate
        Is called with the number of nodes, at most, and the seconds that the hemispheres of one take, before they are
        cast.

    Source: Shen 1993, section 2.4.
    """
    elements = Elements(scene, refinement)
    with tally.stage("elements"):
        contacts = Contacts(scene, elements.lattice, caster)
        pieces = Pieces(elements, contacts)
    glass = Glass(scene)
    made = partial(NodeRows, scene, pieces, glass, frusta=frusta, caster=caster, density=density)
    rows = made(tally=tally, progress=progress)
    if estimate:
        _estimate(estimate, made(tally=Tally()), elements, hemisphere, len(pieces) if shooting else None)
    with tally.stage("form factors"):
        nodes = (PieceRows(scene, elements, pieces, rows, hemisphere, spread) if shooting
                 else rows.cast(*elements.lattice.nodes, hemisphere, spread))
        mean = _mean_of_open(pieces.of_corners, nodes.buried)
        of_elements = pieces.of_elements(~pieces.is_blind & (mean.sum(axis=1) > 0))
    with tally.stage("direct light of elements"):
        points, keys, of_points = _points(scene, elements, pieces, nodes.buried, seed)
        samples = -(-light_samples // POINTS)
        light = DirectLight(scene, caster, tally, samples, frusta=shadow_caster(frusta), rays=samples * len(points))
        direct = of_points @ (arriving := light.irradiance(points, keys))
        thrown = of_points @ light.thrown(points)
    with tally.stage("solver"):
        shares = _shares(scene, elements)
        reflectance, own = _reflectance(shares, glass, elements.patch), pieces.element
        # What arrives at black pieces follows from what they reflect: in shooting none is quite black.
        reflects = np.maximum(reflectance[own], BLACK if shooting else 0.0)
        emission = reflectance[own] * (direct + mean @ nodes.sky) + thrown
        systems = [RadiositySystem(form_factors=factors, reflectance=reflects, emission=emission, area=pieces.area,
                                   centre=elements.centre[own], normal=elements.normal[own])
                   for factors in nodes.of_pieces(mean)]
        solutions = [_solution(system, solver, shooting, preview and preview.watch(pieces), progress)
                     for system in systems]
        radiosity, ambient, display = (joined(rows.groups, [getattr(one, name) for one in solutions])
                                       for name in ("radiosity", "ambient", "display"))
        solution = replace(max(solutions, key=lambda one: one.steps), radiosity=of_elements @ radiosity,
                           ambient=of_elements @ ambient, converged=all(one.converged for one in solutions))
        irradiance = nodes.settle((display - emission) / reflects, (radiosity > emission).any(axis=1)) \
            if shooting else nodes.gathered(display)
        received = of_elements @ (direct + mean @ irradiance)
        reflected = shares - glass.mean_passed[elements.patch]
    with tally.stage("adaptive refinement"):
        usable = contacts.sees & ~nodes.buried[contacts.nodes][:, None]
        chosen = np.zeros(0, dtype=int) if shooting else _contrasting(
            elements, irradiance, nodes.buried, usable, contacts.row[elements.position.cell])
        refined = elements.refined(chosen, CUTS)
        fine_nodes = rows.cast(*refined.nodes, hemisphere, spread)
        fine = _fill(refined.neighbours, fine_nodes.gathered(display), fine_nodes.buried)
        sheet = np.full(elements.lattice.cells, -1)
        sheet[elements.position.cell[chosen]] = np.arange(len(chosen))
    return IndirectLight(elements=elements, irradiance=_fill(elements.lattice.neighbours, irradiance, nodes.buried),
                         refined=refined, refined_irradiance=fine, sheet=sheet, contacts=contacts,
                         usable=usable, pieces=pieces, display=display, reflectance=reflectance, reflected=reflected,
                         of_nodes=of_elements @ mean, received=received, uneven=_uneven(of_points, arriving, direct),
                         radiosity=scene.channels("emission")[elements.patch] + np.where(
                             glass.goes_on[elements.patch][:, None], reflected * received, solution.display), rows=rows,
                         solution=solution, nodes=nodes.cast if shooting else len(irradiance) + len(fine),
                         buried=nodes.buried, refined_buried=fine_nodes.buried)


def _solution(system, solver, shooting, watch, progress):
    if shooting:
        return shoot(system, shooting, watch=watch, progress=progress)
    return SOLVERS[solver](system, progress=progress)


def _estimate(estimate, rows, elements, hemisphere, shooters):
    """Call ``estimate``; adaptive refinement cuts some elements, each into a sheet of nodes of its own."""
    most = len(elements.lattice) + len(elements) // EVERY * (CUTS + 1)**2 if shooters is None else shooters
    estimate(most, _seconds_each(rows, elements.lattice.nodes, hemisphere))


def _seconds_each(rows, nodes, hemisphere):
    """How long the hemispheres of a node take: the mean of some nodes evenly spread, after one that compiles."""
    numbers = np.linspace(0, len(nodes[0]) - 1, TIMED + 1, dtype=int)
    rows.cast(*(part[numbers[:1]] for part in nodes), hemisphere)
    begin = time.perf_counter()
    rows.cast(*(part[numbers[1:]] for part in nodes), hemisphere)
    return (time.perf_counter() - begin) / TIMED


def _shares(scene, elements):
    """C x 3: the shares of light that leave elements again."""
    diffuse = scene.channels("diffuse")[elements.patch]
    others = (scene.channels("specular") + scene.channels("transparent"))[elements.patch]
    if scene.textures is not None:
        diffuse = np.minimum(diffuse * scene.textures.mean_ratio(elements.patch, elements.vertices), 1 - others)
    return diffuse + others


def _reflectance(shares, glass, patch):
    """C x 3: what stays of the light at an element and leaves it again, over what stays; the shares without glass.

    It is 0 to 1, however the shares and what goes on are rounded.
    """
    onward = (glass.mean_passed + glass.mean_thrown)[patch]
    stays = np.maximum(1 - onward, 1e-12)
    return np.clip(np.where(glass.goes_on[patch, None], (shares - onward) / stays, shares), 0, 1)


def _interpolated(position, values):
    result = np.zeros((len(position.nodes), 3))
    _interpolate(position.nodes, position.weights, values, result)
    return result


@compiled
def _interpolate(nodes, weights, values, result):
    for k in range(len(nodes)):
        for corner in range(4):
            for channel in range(3):
                result[k, channel] += weights[k, corner] * values[nodes[k, corner], channel]


def _points(scene, elements, pieces, buried, seed):
    """One point in each field of each element, the keys of their samples, and the sparse means of pieces over them.

    In a part of a cut element it is in the middle, of which `Contacts` knows what it sees.
    """
    element, piece, column, row, across, inside = pieces.points(isqrt(POINTS))
    field = row * across + column
    keys = mix(seed, 1, element, field)
    quarter = across == isqrt(POINTS)
    u, v = ((cell + np.where(quarter, uniform(keys, axis), 0.5)) / across for axis, cell in ((2, column), (3, row)))
    v = np.where(scene.is_triangle[elements.patch[element]], 1 - np.sqrt(1 - v), v)
    # A quarter of a whole quadrilateral is inside a body if its corner is: it is not visible.
    corner = elements.position.nodes[element, np.where(quarter, field, 0)]
    inside |= quarter & ~elements.triangle[element] & buried[corner]
    share = sparse.csr_array((np.where(inside, 0.0, 1.0), (piece, np.arange(len(piece)))),
                             shape=(len(pieces), len(piece)))
    mean = sparse.diags_array(1 / np.maximum(share.sum(axis=1), 1)) @ share
    return SurfacePoints(bilinear(elements.vertices[element], u, v), elements.normal[element],
                         elements.patch[element]), keys, mean


def _uneven(of_points, arriving, direct):
    """P bool: whether the light that arrives at a piece's points differs, its means being ``direct``."""
    return np.sqrt(np.maximum(of_points @ arriving**2 - direct**2, 0)).mean(axis=1) > UNEVEN * direct.mean()


def _mean_of_open(of_corners, buried):
    """The mean over an element's corners that are not inside a body."""
    mean = of_corners @ sparse.diags_array(np.where(buried, 0.0, 1.0))
    total = mean.sum(axis=1)
    return sparse.diags_array(1 / np.where(total > 0, total, 1)) @ mean


def _contrasting(elements, irradiance, buried, usable, row):
    """The elements whose corners differ most, as numbers: only quadrilaterals with a corner outside bodies.

    Where a corner is hidden or buried, light is gathered rather than interpolated: not those whose ``row`` of contacts
    is not all ``usable``.
    """
    hidden = np.append(~usable.all(axis=(1, 2)), False)[row]
    corners = irradiance.mean(axis=1)[elements.position.nodes]
    inside = buried[elements.position.nodes]
    # A corner inside a body carries no information on the light outside: it counts as dark.
    corners = np.where(inside, 0, corners)
    never = elements.triangle | inside.all(axis=1) | hidden
    contrast = np.where(never, 0, corners.max(axis=1) - corners.min(axis=1))
    order = np.argsort(-contrast, kind="stable")[:len(elements) // EVERY]
    return order[contrast[order] > CONTRAST * irradiance[~buried].mean()] if not buried.all() else order[:0]


def _fill(neighbours, values, buried):
    """Give nodes inside bodies the mean of their neighbours outside, repeatedly, so that interpolation stays bright."""
    values, known = np.where(buried[:, None], 0.0, values), ~buried
    while not known.all():
        share = neighbours @ known.astype(np.float64)
        fresh = np.flatnonzero(~known & (share > 0))
        if not len(fresh):
            break
        values[fresh] = (neighbours[fresh] @ (values * known[:, None])) / share[fresh, None]
        known[fresh] = True
    return values

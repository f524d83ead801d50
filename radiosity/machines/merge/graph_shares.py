"""Graph shares: the cells of a mesh as a graph, bisected on several levels of coarseness."""

import numpy as np
from scipy import sparse

from golden.base.compiled import compiled

__all__ = ["graph_shares"]

# As in the source: vertices of the coarsest graph. Ours: trials of its bisection, passes of a refinement, moves that
# may not improve a cut, and the share by which a side may exceed its half.
_COARSEST = 100
_TRIALS, _PASSES, _MOVES, _SLACK = 8, 4, 50, 0.01
_WHOLE = 1 << 24


def graph_shares(loads: np.ndarray, edges: np.ndarray, levels: int) -> list[np.ndarray]:
    """The owners of the cells after each level: mesh x mesh int64; regions need not be connected.

    Each part is bisected: vertices are matched along their heaviest edges until about 100 are left, these are divided
    by growing one side, and the cut is refined along its boundary on each finer graph. The source's Metis is not part
    of this project; the steps are those that it states.

    Parameters
    ----------
    loads
        Mesh x mesh float64: weights of the cells.
    edges
        2 x mesh x mesh float64: weights of the edges to the cell on the right and below.
    levels
        Levels of bisection.

    Source: Kurc 1997, section 6.1.6.
    """
    mesh = len(loads)
    # Weights become integers.
    scale = _WHOLE / max(loads.sum(), 1e-300)
    vertex = np.rint(loads.ravel() * scale).astype(np.int64)
    weights = np.rint(edges * scale).astype(np.int64)
    links = _mesh_links(weights, mesh)
    # Of the order in which vertices are matched.
    rng = np.random.default_rng(0)
    owner = np.zeros(mesh * mesh, dtype=np.int64)
    found = [owner.reshape(mesh, mesh)]
    for level in range(levels):
        halves = np.empty_like(owner)
        for part in range(1 << level):
            own = np.flatnonzero(owner == part)
            if len(own):
                halves[own] = 2 * part + _bisected(vertex[own], links[own][:, own], rng)
        owner = halves
        found.append(owner.reshape(mesh, mesh))
    return found


def _mesh_links(weights, mesh):
    """Weights of the edges between neighbours."""
    cell = np.arange(mesh * mesh).reshape(mesh, mesh)
    one = np.concatenate([cell[:, :-1].ravel(), cell[:-1].ravel()])
    other = np.concatenate([cell[:, 1:].ravel(), cell[1:].ravel()])
    both = np.concatenate([weights[0, :, :-1].ravel(), weights[1, :-1].ravel()])
    return _links(np.append(one, other), np.append(other, one), np.append(both, both), mesh * mesh)


def _links(source, target, weight, count):
    """Edges as a matrix, rows sorted by target; weights of the same edge are added, and may be 0."""
    return sparse.coo_array((weight, (source, target)), shape=(count, count)).tocsr()


def _bisected(vertex, links, rng):
    """The side, 0 or 1, of each vertex of a graph with weights of vertices and edges."""
    levels = []
    while len(vertex) > _COARSEST:
        coarse = _matched(links.indptr, links.indices, links.data, rng.permutation(len(vertex)))
        count = int(coarse.max()) + 1
        if count > 0.95 * len(vertex):
            break
        levels.append((vertex, links, coarse))
        vertex, links = _contracted(vertex, links, coarse, count)
    best = None
    for start in rng.integers(0, len(vertex), _TRIALS):
        side = _grown(vertex, links.indptr, links.indices, links.data, start)
        cut = _refined(vertex, links.indptr, links.indices, links.data, side, _PASSES, _MOVES, _SLACK)
        if best is None or cut < best[0]:
            best = cut, side
    side = best[1]
    for vertex, links, coarse in reversed(levels):
        side = side[coarse]
        _refined(vertex, links.indptr, links.indices, links.data, side, _PASSES, _MOVES, _SLACK)
    return side


def _contracted(vertex, links, coarse, count):
    """The graph of matched vertices: weights are added, and edges within a pair disappear."""
    source, target = np.repeat(coarse, np.diff(links.indptr)), coarse[links.indices]
    is_between = source != target
    total = np.zeros(count, dtype=np.int64)
    np.add.at(total, coarse, vertex)
    return total, _links(source[is_between], target[is_between], links.data[is_between], count)


@compiled
def _matched(start, target, weight, order):
    """The number of each vertex after each has been matched with its unmatched neighbour over the heaviest edge."""
    coarse = np.full(len(order), -1, dtype=np.int64)
    count = 0
    for vertex in order:
        if coarse[vertex] >= 0:
            continue
        best, heaviest = vertex, -1
        for edge in range(start[vertex], start[vertex + 1]):
            if coarse[target[edge]] < 0 and weight[edge] > heaviest:
                best, heaviest = target[edge], weight[edge]
        coarse[vertex] = count
        coarse[best] = count
        count += 1
    return coarse


@compiled
def _grown(vertex, start, target, weight, seed):
    """Side 0 grows from a vertex, by the neighbour whose edges into it are heaviest, up to half of the weight."""
    side, inward = np.ones(len(vertex), dtype=np.int64), np.zeros(len(vertex), dtype=np.int64)
    half, held, at = vertex.sum() / 2, 0, seed
    while held + vertex[at] / 2 <= half:
        side[at] = 0
        held += vertex[at]
        inward[at] = -1
        for edge in range(start[at], start[at + 1]):
            if side[target[edge]]:
                inward[target[edge]] += weight[edge] + 1
        at = np.argmax(inward)
        if inward[at] <= 0:
            # What has been grown is a component of its own.
            at = -1
            for other in range(len(vertex)):
                if side[other]:
                    at = other
                    break
            if at < 0:
                break
    return side


@compiled
def _move(at, side, held, gain, degree, start, target, weight, vertex):
    """A vertex changes sides; weights of both sides, gains and numbers of cut edges follow."""
    held[side[at]] -= vertex[at]
    side[at] = 1 - side[at]
    held[side[at]] += vertex[at]
    gain[at] = -gain[at]
    for edge in range(start[at], start[at + 1]):
        other = target[edge]
        if side[other] == side[at]:
            gain[other] -= 2 * weight[edge]
            degree[other] -= 1
            degree[at] -= 1
        else:
            gain[other] += 2 * weight[edge]
            degree[other] += 1
            degree[at] += 1


@compiled
def _refined(vertex, start, target, weight, side, passes, moves, slack):
    """Boundary Kernighan-Lin: vertices change sides by their gain, and the best cut of a pass is kept; its weight."""
    count, total = len(vertex), vertex.sum()
    limit = total * (0.5 + slack)
    held = np.zeros(2, dtype=np.int64)
    gain, degree = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    moved = np.empty(count, dtype=np.int64)
    cut = 0
    for at in range(count):
        held[side[at]] += vertex[at]
        for edge in range(start[at], start[at + 1]):
            is_cut = side[target[edge]] != side[at]
            gain[at] += weight[edge] if is_cut else -weight[edge]
            degree[at] += is_cut
            cut += weight[edge] if is_cut else 0
    cut //= 2
    for _ in range(passes):
        is_locked = np.zeros(count, dtype=np.bool_)
        best_cut, best_worst, best_moves, done = cut, max(held[0], held[1]), 0, 0
        first = best_cut, best_worst
        while done < count and done - best_moves < moves:
            # From the heavier side while it is too heavy, else from any side that does not make the other so.
            chosen = -1
            for at in range(count):
                if is_locked[at] or degree[at] == 0:
                    continue
                own, after = held[side[at]], held[1 - side[at]] + vertex[at]
                if after > limit and after >= own:
                    continue
                if own <= limit and held[1 - side[at]] > limit:
                    continue
                if chosen < 0 or gain[at] > gain[chosen]:
                    chosen = at
            if chosen < 0:
                break
            cut -= gain[chosen]
            is_locked[chosen] = True
            _move(chosen, side, held, gain, degree, start, target, weight, vertex)
            moved[done] = chosen
            done += 1
            worst = max(held[0], held[1])
            is_better = cut < best_cut if worst <= limit and best_worst <= limit else worst < best_worst
            if is_better or (cut == best_cut and worst < best_worst):
                best_cut, best_worst, best_moves = cut, worst, done
        for back in range(done - 1, best_moves - 1, -1):
            _move(moved[back], side, held, gain, degree, start, target, weight, vertex)
        cut = best_cut
        if best_cut == first[0] and best_worst == first[1]:
            break
    return cut

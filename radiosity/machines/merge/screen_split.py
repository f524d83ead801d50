"""Screen split: the regions of the nodes by one of six splitters, and the faces that each node needs."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError, check_choice
from radiosity.machines.merge.box_cuts import axes_of, cut_boxes
from radiosity.machines.merge.graph_shares import graph_shares
from radiosity.machines.merge.mesh_load import check_mesh, edge_loads, halve_mesh, hilbert_shares, mesh_loads
from radiosity.machines.merge.work_weights import WorkWeights

__all__ = ["MESHES", "SPLITTERS", "NodeFaces", "ScreenSplit", "faces_of_cells", "faces_of_rectangles", "mesh_of",
           "split_screen"]

MESHES = {"mahd": 512, "hcs": 128, "gs": 128}
"""Splitters that count by a mesh, with the one by which each is balanced best in the source."""

SPLITTERS = ("hs", "rs", "rrs", *MESHES)


class NodeFaces(NamedTuple):
    """Which faces each of P nodes has.

    Parameters
    ----------
    start
        P + 1 int64: the first of each node in ``face``, and how many there are.
    face
        K int64.
    """

    start: np.ndarray
    face: np.ndarray


class ScreenSplit(NamedTuple):
    """Who owns which pixel.

    Parameters
    ----------
    levels
        L x H x W int64: the owners after each level of the splitter, of which the last ones are the nodes.
    faces
        Of each node those whose boxes meet its region.
    """

    levels: np.ndarray
    faces: NodeFaces

    @property
    def owner(self) -> np.ndarray:
        """H x W int64: the node of each pixel."""
        return self.levels[-1]


def split_screen(splitter: str, boxes: np.ndarray, weights: WorkWeights, *, nodes: int, width: int, height: int,
                 mesh: int | None = None) -> ScreenSplit:
    """Split a screen among nodes by the boxes on it.

    Parameters
    ----------
    splitter
        A name of `SPLITTERS`.
    boxes
        N x 4 int64: first x, first y, last x and last y.
    weights
        Of a box, its spans and its pixels.
    nodes
        P, a power of two.
    width, height
        Pixels of the screen.
    mesh
        Cells along each side, for splitters that have some. Default: the source's best, or what fits the screen.

    Raises
    ------
    InputError
        The splitter is none, or the screen cannot be split so often.

    Source: Kurc 1997, section 6.1.
    """
    check_choice("volume: Splitter", splitter, SPLITTERS)
    levels = nodes.bit_length() - 1
    if splitter not in MESHES:
        if mesh is not None:
            raise InputError(f"volume: Mesh must be given for the splitters {', '.join(MESHES)} alone, "
                             f"not for {splitter}", parameter="mesh")
        found = cut_boxes(boxes, weights, axes_of(splitter, levels), width, height)
        owners = np.stack([_painted(regions, width, height) for regions in found])
        return ScreenSplit(owners, faces_of_rectangles(boxes, found[-1]))
    mesh = mesh_of(splitter, mesh, width, height)
    check_mesh(mesh, width, height)
    loads = mesh_loads(boxes, weights, mesh, width, height)
    if splitter == "mahd":
        cells = halve_mesh(loads, levels)
    elif splitter == "gs":
        cells = graph_shares(loads, edge_loads(boxes, weights, mesh, width, height), levels)
    else:
        cells = [hilbert_shares(loads, 1 << level) for level in range(levels + 1)]
    owners = np.stack([each.repeat(height // mesh, axis=0).repeat(width // mesh, axis=1) for each in cells])
    return ScreenSplit(owners, faces_of_cells(boxes, cells[-1], nodes, width, height))


def mesh_of(splitter: str, mesh: int | None, width: int, height: int) -> int:
    """Cells along each side: the given ones, or as many as the source's best mesh has and the screen allows."""
    if mesh is not None:
        return mesh
    both = int(np.gcd(width, height))
    return min(MESHES[splitter], both & -both)


def _painted(regions, width, height):
    owner = np.empty((height, width), dtype=np.int64)
    for node, (left, top, right, bottom) in enumerate(regions):
        owner[top:bottom + 1, left:right + 1] = node
    return owner


def faces_of_rectangles(boxes: np.ndarray, regions: np.ndarray) -> NodeFaces:
    """Each box goes to all rectangles that it meets.

    Source: Kurc 1997, section 6.1.7, Fig. 6.8.
    """
    own = [np.flatnonzero((boxes[:, :2] <= region[2:]).all(axis=1) & (boxes[:, 2:] >= region[:2]).all(axis=1))
           for region in regions]
    return NodeFaces(np.cumsum([0, *map(len, own)]), np.concatenate(own))


def faces_of_cells(boxes: np.ndarray, owner: np.ndarray, nodes: int, width: int, height: int) -> NodeFaces:
    """Each box goes once to all owners of the cells that it meets.

    Source: Kurc 1997, section 6.1.7, Fig. 6.9.
    """
    sizes = np.array([width // owner.shape[1], height // owner.shape[0]])
    start = np.zeros(nodes + 1, dtype=np.int64)
    _mark(boxes, owner, sizes, start[1:], start[:0])
    start = np.cumsum(start)
    face = np.empty(start[-1], dtype=np.int64)
    _mark(boxes, owner, sizes, start[:-1].copy(), face)
    return NodeFaces(start, face)


@compiled
def _mark(boxes, owner, sizes, at, face):
    """Count the boxes of each node in ``at`` if ``face`` is empty, else write them from there."""
    stored = np.full(len(at), -1, dtype=np.int64)
    for box in range(len(boxes)):
        for row in range(boxes[box, 1] // sizes[1], boxes[box, 3] // sizes[1] + 1):
            for column in range(boxes[box, 0] // sizes[0], boxes[box, 2] // sizes[0] + 1):
                node = owner[row, column]
                if stored[node] < box:
                    stored[node] = box
                    if len(face):
                        face[at[node]] = box
                    at[node] += 1

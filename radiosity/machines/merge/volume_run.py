"""Volume run: the picture of a volume whose screen is split among nodes."""

from dataclasses import dataclass

import numpy as np

from radiosity.machines.common.content_hash import content_hash
from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.common.nodes import spread_over_nodes
from radiosity.machines.merge.merge_run import check_machine
from radiosity.machines.merge.screen_split import MESHES, ScreenSplit, mesh_of, split_screen
from radiosity.machines.merge.screen_volume import ScreenVolume
from radiosity.machines.merge.split_programs import face_moves, split_ends
from radiosity.machines.merge.work_weights import TRIANGLES_ALONE, WorkWeights
from radiosity.machines.merge.z_list import RegionWork, render_regions

__all__ = ["PARSYTEC", "STEP", "VolumeRun", "simulate_volume"]

PARSYTEC = NodeTiming(operation=48, setup=500_000, word=100)
"""A node of the Parsytec CC: 4 bytes at its 40 MB/s; 53.09 s of a sequential picture over our operations of `blunt_fin`
with seed 0. The source has no time to set a message up; 0.5 ms is ours."""

STEP = 3
"""Operations by which an entry of a z-list passes another."""


@dataclass(frozen=True, kw_only=True, eq=False)
class VolumeRun:
    """A volume's picture, made by simulated nodes.

    Parameters
    ----------
    splitter, is_weighted
        How the screen was split: whether spans and pixels counted beside faces.
    count
        N faces.
    split, work
        The regions, and what nodes drew in them.
    operations
        P int64: of each node, to draw.
    alone
        Operations of one node that has the whole screen.
    split_ends
        P int64: ns in which each node has its faces.
    sent
        P x 2 int64: messages and words that each node has sent.
    """

    splitter: str
    is_weighted: bool
    count: int
    split: ScreenSplit
    work: RegionWork
    operations: np.ndarray
    alone: int
    split_ends: np.ndarray
    sent: np.ndarray

    @property
    def faces(self) -> np.ndarray:
        """P int64: the faces that each node has."""
        return np.diff(self.split.faces.start)

    @property
    def balance(self) -> float:
        """Most faces of a node over the mean before they are sent to regions."""
        return int(self.faces.max()) * len(self.faces) / self.count

    @property
    def growth(self) -> float:
        """Faces of all nodes over those of the volume, less 1."""
        return int(self.faces.sum()) / self.count - 1

    @property
    def speedup(self) -> float:
        """Time of one node over that of the slowest, without the split."""
        return self.alone / int(self.operations.max())

    @property
    def time(self) -> int:
        """Ns until the last node has drawn its region."""
        return int((self.split_ends + self.operations * PARSYTEC.operation).max())

    def report(self) -> dict:
        """Times, traffic and hashes, ready for JSON."""
        nodes = len(self.faces)
        alone = self.alone * PARSYTEC.operation
        return {
            "nodes": nodes, "splitter": self.splitter, "weighted": self.is_weighted, "faces": self.count,
            "width": self.split.owner.shape[1], "height": self.split.owner.shape[0],
            "pixels_of_the_picture": int(np.count_nonzero(self.work.picture[..., 3])),
            "seconds": self.time / 1e9, "alone_seconds": alone / 1e9, "speedup": alone / self.time,
            "drawing": {"seconds": int(self.operations.max()) * PARSYTEC.operation / 1e9, "speedup": self.speedup},
            "splitting_seconds": int(self.split_ends.max()) / 1e9,
            "balance": self.balance, "growth": self.growth,
            "traffic": {"messages": int(self.sent[:, MESSAGES].sum()), "words": int(self.sent[:, WORDS].sum())},
            "of_a_node": spread_over_nodes(
                faces=self.faces, spans=self.work.spans, pixels=self.work.pixels, operations=self.operations),
            "picture": content_hash(self.work.picture)}


def simulate_volume(volume: ScreenVolume, splitter: str, *, nodes: int, is_weighted: bool = True,
                    mesh: int | None = None, is_sampled: bool = True, alone: int | None = None) -> VolumeRun:
    """Simulate all phases: boxes are made, the screen is split, faces are sent, and each node draws its region alone.

    Times are those of a `PARSYTEC`.

    Parameters
    ----------
    volume
        On the screen.
    splitter, mesh
        See `split_screen`.
    nodes
        P, a power of two up to 1024.
    is_weighted
        Whether spans and pixels count beside faces, by the operations that they take.
    is_sampled
        See `render_regions`.
    alone
        Operations of one node that has the whole screen, if they are known.

    Raises
    ------
    InputError
        The nodes are no power of two, or the screen cannot be split so often.

    Source: Kurc 1997, section 6.4.
    """
    check_machine(nodes, volume.width, volume.height)
    weights, size = WorkWeights(), {"width": volume.width, "height": volume.height}
    split = split_screen(splitter, volume.boxes, weights if is_weighted else TRIANGLES_ALONE, nodes=nodes, mesh=mesh,
                         **size)
    work = render_regions(volume, split, is_sampled=is_sampled)
    operations = _operations(weights, split, work)
    if alone is None:
        whole = split_screen("hs", volume.boxes, weights, nodes=1, **size)
        alone = int(_operations(weights, whole, render_regions(volume, whole, is_sampled=False))[0])
    cube, shape, tallied = hypercube(nodes, PARSYTEC), (volume.height, volume.width), 0
    if splitter in MESHES:
        shape = (mesh_of(splitter, mesh, **size),) * 2
        cells = volume.boxes // np.tile(np.array([volume.width, volume.height]) // shape, 2)
        tallied = int(np.prod(cells[:, 2:] - cells[:, :2] + 1, axis=1).sum())
    count = len(volume.faces)
    ends = split_ends(splitter, face_moves(split.faces, count), count, tallied, cube, PARSYTEC, shape=shape)
    return VolumeRun(splitter=splitter, is_weighted=is_weighted, count=count, split=split, work=work,
                     operations=operations, alone=alone, split_ends=ends, sent=cube.sent)


def _operations(weights, split, work):
    """P int64: operations of each node to draw what it has."""
    return (weights.triangle * np.diff(split.faces.start) + weights.span * work.spans + weights.pixel * work.pixels
            + STEP * work.steps)

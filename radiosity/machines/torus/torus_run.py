"""Torus run: a picture of a scene, made by the simulated nodes of a torus."""

from dataclasses import dataclass, field

import numpy as np

from golden.base.errors import InputError, check_choice, check_int
from radiosity.machines.common.content_hash import content_hash
from radiosity.machines.common.event_heap import event_heap
from radiosity.machines.common.nodes import MOST_NODES, spread_over_nodes
from radiosity.machines.torus import torus_state as ts
from radiosity.machines.torus.columns import Count, Item, Link, Node, Tally, Walk
from radiosity.machines.torus.node_boxes import GROWTHS, NodeBoxes, node_boxes
from radiosity.machines.torus.node_grids import NodeGrids, node_grids
from radiosity.machines.torus.ray_shading import spawned
from radiosity.machines.torus.ray_timing import RayTiming
from radiosity.machines.torus.state_packet import PHASES, RAYTRACE
from radiosity.machines.torus.torus_scene import TorusScene
from radiosity.machines.torus.torus_turns import DONE, FULL, SCALE, Machine, run_turns, start_turns

__all__ = ["STORAGES", "TorusRun", "TorusSetup", "simulate_torus"]

STORAGES = ("array", "hash")
_DELAYS, _LOG_COLUMNS = 4096, 6


@dataclass(frozen=True, kw_only=True)
class TorusSetup:
    """The machine and its picture.

    Parameters
    ----------
    nodes
        P, a square number up to 1024.
    size
        Rows and columns of pixels.
    subdivisions
        v: voxels of a node along each axis, 1 to 128.
    storage
        A name of `STORAGES`.
    entries
        Heads of a hash table, a power of two.
    growth, growth_by
        See `radiosity.machines.torus.node_boxes.node_boxes`.
    has_shadows, is_stealing
        Whether shadow rays are cast, and whether idle nodes request rows.
    deepest, least
        Largest level of a ray, and the contribution below which none is made: the source has 8 as an example, and no
        least contribution.
    buffer
        Bytes of a link's buffer; the largest message has 340.
    delay, seed
        Most us by which a message is late, and the seed by which it is drawn.
    timing
        Of the nodes.

    Raises
    ------
    TypeError
        A number is no int.
    InputError
        A number is out of range, or a name is none.
    """

    nodes: int = 4
    size: tuple[int, int] = (150, 150)
    subdivisions: int = 16
    storage: str = "array"
    entries: int = 4096
    growth: float = 0.02
    growth_by: str = "axis"
    has_shadows: bool = True
    is_stealing: bool = True
    deepest: int = 8
    least: float = 1 / 256
    buffer: int = 2048
    delay: int = 0
    seed: int = 0
    timing: RayTiming = field(default_factory=RayTiming)

    def __post_init__(self):
        for label, value, least, most in (
                ("Nodes", self.nodes, 1, MOST_NODES), ("Rows", self.size[0], 1, 1 << 14),
                ("Columns", self.size[1], 1, 1 << 14), ("Subdivisions", self.subdivisions, 1, 128),
                ("Entries", self.entries, 1, 1 << 20), ("Level", self.deepest, 0, 64),
                ("Buffer", self.buffer, 340, 1 << 30), ("Delay", self.delay, 0, 10 ** 9),
                ("Seed", self.seed, 0, 1 << 62)):
            check_int(label, value)
            if not least <= value <= most:
                raise InputError(f"torus: {label} must be {least} to {most}, not {value!r}", parameter=label)
        if self.side ** 2 != self.nodes:
            raise InputError(f"torus: Nodes must be a square number up to {MOST_NODES}, not {self.nodes!r}",
                             parameter="nodes")
        if self.entries & (self.entries - 1):
            raise InputError(f"torus: Entries must be a power of two, not {self.entries!r}")
        if not 0 <= self.least < 1:
            raise InputError(f"torus: Least must be at least 0 and below 1, not {self.least!r}")
        for label, value, known in (("Storage", self.storage, STORAGES), ("Growth-by", self.growth_by, GROWTHS)):
            check_choice(f"torus: {label}", value, known, parameter=label)

    @property
    def side(self) -> int:
        """k: nodes of a row."""
        return round(self.nodes ** 0.5)


@dataclass(frozen=True, kw_only=True, eq=False)
class TorusRun:
    """A picture, and what making it took.

    Parameters
    ----------
    scene, setup
        What, and how.
    boxes, grids
        Of the nodes.
    state
        After the last turn.
    time
        us until all nodes were at the end.
    log
        W x 6 int64: of the first walks begin and us, node, pixel, level, and whether it is a shadow ray.
    """

    scene: TorusScene
    setup: TorusSetup
    boxes: NodeBoxes
    grids: NodeGrids
    state: ts.TorusState
    time: int
    log: np.ndarray

    @property
    def sums(self) -> np.ndarray:
        """R x C x 3 int64: colours in 1 / 65536, the upper row first."""
        return self.state.picture[::-1]

    @property
    def picture(self) -> np.ndarray:
        """R x C x 3 uint8, the upper row first."""
        return ((np.clip(self.sums, 0, SCALE) * 255 + SCALE // 2) // SCALE).astype(np.uint8)

    @property
    def tracing(self) -> np.ndarray:
        """P int64: us in which each node was busy in the phase of tracing, as the source's times of nodes."""
        return self.state.busy[:, RAYTRACE]

    def walked(self, *columns: int) -> int:
        """Sum over all nodes of counts of walks, see `Walk`."""
        return int(self.state.walked[:, columns].sum())

    @property
    def rays(self) -> int:
        """Rays of all kinds."""
        return int(self.state.tallies[:, Tally.MADE].sum())

    @property
    def tests(self) -> float:
        """Tests of objects for each ray."""
        return self.walked(Walk.SPHERE_TESTS, Walk.POLYGON_TESTS) / self.rays

    def report(self) -> dict:
        """Times, traffic, memory and a hash of the picture, ready for JSON."""
        tallies, setup, busy = self.state.tallies, self.setup, self.tracing
        links = self.state.links[:, Link.MESSAGES]
        return {
            "scene": self.scene.name, "objects": len(self.scene), "lights": len(self.scene.lights),
            "nodes": setup.nodes, "rows": setup.size[0], "columns": setup.size[1],
            "subdivisions": setup.subdivisions, "storage": setup.storage, "growth": setup.growth,
            "growth_by": setup.growth_by, "rays": self.rays, "shadow_rays": int(tallies[:, Tally.SHADOWS_MADE].sum()),
            "seconds": self.time / 1e6, "busiest_seconds": int(busy.max()) / 1e6,
            "efficiency": int(busy.sum()) / (setup.nodes * self.time) if self.time else 1.0,
            "per_ray": {"tests": self.tests, "steps": self.walked(Walk.STEPS) / self.rays,
                        "compared": self.walked(Walk.CHAINED) / self.rays},
            "traffic": {"passed": int(tallies[:, Tally.PASSED].sum()), "packets": int(tallies[:, Tally.PACKETS].sum()),
                        "values": int(tallies[:, Tally.VALUES].sum()), "messages": int(links.sum()),
                        "busiest_link": int(links.max()), "rows_given": int(tallies[:, Tally.GIVEN].sum())},
            "visits": {name: int(most) for name, most in zip(PHASES, self.state.visits.max(axis=0), strict=True)},
            "of_a_node": spread_over_nodes(
                milliseconds=busy // 1000, walks=tallies[:, Tally.TRACED], passed=tallies[:, Tally.PASSED],
                objects=self.grids.held, references=self.grids.counts[:, 0], held_rays=tallies[:, Tally.MOST_HELD]),
            "picture": content_hash(self.sums)}


def spiral_order(boxes: NodeBoxes, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Pixels in the order in which nodes begin them, and where each node's begin, with their number at the end.

    From the middle of a node's pixels outwards, ring by ring, around each ring from the left. The source has no more
    than a spiral.
    """
    row, column = (axis.reshape(-1) for axis in np.indices(size))
    keys = []
    owner = np.zeros(len(row), dtype=np.int64)
    for value, edges, weight in ((row, boxes.rows, boxes.side), (column, boxes.columns, 1)):
        part = np.searchsorted(edges, value, side="right") - 1
        owner += weight * part
        keys.append(2 * value + 1 - edges[part] - edges[part + 1])
    ring, angle = np.maximum(np.abs(keys[0]), np.abs(keys[1])), np.arctan2(keys[0], keys[1])
    order = np.lexsort((angle, ring, owner))
    return order, np.append(0, np.cumsum(np.bincount(owner, minlength=boxes.side ** 2)))


def simulate_torus(scene: TorusScene, setup: TorusSetup, *, log: int = 0) -> TorusRun:
    """Simulate the machine until its picture is finished.

    Parameters
    ----------
    scene
        Objects and lights.
    setup
        The machine and its picture.
    log
        Walks that are recorded, from the first on.

    Raises
    ------
    InputError
        See `radiosity.machines.torus.node_boxes.node_boxes`; or the buffers are so small that the nodes are in a
        deadlock.
    RuntimeError
        The state packet began a phase while there was work.
    """
    boxes = node_boxes(scene, side=setup.side, size=setup.size, growth=setup.growth, growth_by=setup.growth_by)
    objects, bounds = scene.objects, scene.bounds
    is_hash = setup.storage == "hash"
    grids = node_grids(objects, bounds, boxes, subdivisions=setup.subdivisions, entries=setup.entries * is_hash)
    order, starts = spiral_order(boxes, setup.size)
    timing = setup.timing
    walking = [timing.hash_step if is_hash else timing.array_step, timing.sphere_test, timing.polygon_test,
               timing.sphere_hit, timing.polygon_hit]
    delays = np.random.default_rng(setup.seed).integers(0, setup.delay + 1, _DELAYS)
    machine = Machine(
        side=setup.side, size=setup.size, deepest=setup.deepest, least=float(setup.least),
        has_shadows=setup.has_shadows, steals=setup.is_stealing, buffer=setup.buffer,
        setup=timing.hash_setup if is_hash else timing.array_setup, walking=np.array(walking, dtype=np.int64),
        rest=timing.rest, call=timing.call, slopes=(setup.size[1] / setup.size[0] * scene.slope, scene.slope),
        front=float(boxes.front), grids=grids, objects=objects, bounds=bounds, grown=boxes.grown,
        rows=boxes.rows, columns=boxes.columns, order=order, delays=delays,
        mail=np.zeros(len(scene), dtype=np.int64), walked=np.zeros(len(Walk), dtype=np.int64),
        out=spawned(len(scene.lights)), log=np.zeros((log, _LOG_COLUMNS), dtype=np.int64))
    state = ts.torus_state(setup.side, setup.size, starts, items=4096 + len(scene))
    for number in range(len(scene)):
        item = ts.new_item(state, ts.OBJECT)
        state.items[item, Item.PIXEL] = number
        ts.append(state, 0, Node.OBJECTS, item)
    # Turns and messages of each node, and what is on the links.
    heap = event_heap(4 * setup.nodes + len(state.items))
    start_turns(heap, state)
    while True:
        ended, time = run_turns(heap, machine, state)
        if ended != FULL:
            break
        state = ts.enlarged(state)
        heap = heap._replace(entries=np.resize(heap.entries, (4 * setup.nodes + len(state.items), 4)))
    if ended == DONE:
        return TorusRun(scene=scene, setup=setup, boxes=boxes, grids=grids, state=state, time=int(time),
                        log=machine.log[:state.counts[Count.LOGGED]])
    if state.counts[Count.LIVE] and (state.nodes[:, Node.BLOCKED_LINK] != ts.NONE).any():
        raise InputError(f"torus: Buffer must be larger than {setup.buffer} bytes: the nodes are in a deadlock",
                         parameter="buffer")
    raise RuntimeError("The state packet must begin no phase while there is work")

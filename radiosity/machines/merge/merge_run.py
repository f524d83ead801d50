"""Merge run: the picture of a scene whose polygons are dealt to nodes, and whose pixels are merged."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, check_choice
from radiosity.machines.common.assignment import Assignment
from radiosity.machines.common.content_hash import content_hash
from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_programs import run_program, work_step
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.common.nodes import check_power_of_two, spread_over_nodes
from radiosity.machines.merge.exchange_steps import SCHEMES, dimensions_of, mesh_steps
from radiosity.machines.merge.line_shares import DIVISIONS, divide_lines
from radiosity.machines.merge.merge_programs import all_to_all_ends, division_program, exchange_program
from radiosity.machines.merge.merge_work import CELL_WORDS, PIXEL_WORDS, MergeWork
from radiosity.machines.merge.pixel_exchange import MET, SENT, TOUCHED, exchange, received_by_owners, scattered
from radiosity.machines.merge.screen_triangles import ScreenTriangles
from radiosity.machines.merge.span_lists import extended_counts, pixel_counts, span_lists
from radiosity.machines.merge.winning_pixels import Pixels, pixels_of_spans

__all__ = ["MergeRun", "MergeScheme", "check_machine", "simulate_merge"]


@dataclass(frozen=True, kw_only=True)
class MergeScheme:
    """How pixels are merged.

    Parameters
    ----------
    name
        A name of `SCHEMES`.
    division
        A name of `DIVISIONS`.
    is_full
        Whether cells of all locations are sent, instead of the pixels that won in their node.

    Raises
    ------
    InputError
        A name is none.
    """

    name: str = "aapc"
    division: str = "packed"
    is_full: bool = False

    def __post_init__(self):
        for label, value, known in (("Scheme", self.name, SCHEMES), ("Division", self.division, DIVISIONS)):
            check_choice(f"merge: {label}", value, known, parameter=label)


@dataclass(frozen=True, kw_only=True, eq=False)
class MergeRun:
    """A picture, made by simulated nodes.

    Parameters
    ----------
    scheme
        How.
    triangles, generated
        P int64: triangles that each node has, and pixels that it generates.
    held
        P int64: pixels that win in each node.
    span_ends, drawn_ends, ends
        P int64: ns in which each node has its span lists, its pixels, and its part of the picture.
    alone
        ns of one node with all polygons.
    concurrent_words
        The sum over all steps of the most words that a node sends.
    merges
        P int64: pixels or cells that each node merges.
    sent
        P x 2 int64: messages and words that each node has sent.
    picture
        H x W x 3 uint8.
    active
        Locations of the picture that have a pixel.
    """

    scheme: MergeScheme
    triangles: np.ndarray
    generated: np.ndarray
    held: np.ndarray
    span_ends: np.ndarray
    drawn_ends: np.ndarray
    ends: np.ndarray
    alone: int
    concurrent_words: int
    merges: np.ndarray
    sent: np.ndarray
    picture: np.ndarray
    active: int

    @property
    def time(self) -> int:
        """Ns of all phases."""
        return int(self.ends.max())

    @property
    def phases(self) -> dict[str, float]:
        """Seconds of each phase, until the last node ends it."""
        ends = [0, *(int(each.max()) for each in (self.span_ends, self.drawn_ends, self.ends))]
        return dict(zip(("span_lists", "local_pixels", "merge"), (np.diff(ends) / 1e9).tolist(), strict=True))

    def report(self) -> dict:
        """Times, traffic and hashes, ready for JSON."""
        nodes, mean = len(self.ends), float(self.merges.mean())
        height, width = self.picture.shape[:2]
        return {
            "nodes": nodes, "scheme": self.scheme.name, "division": self.scheme.division,
            "full": self.scheme.is_full, "width": width, "height": height, "triangles": int(self.triangles.sum()),
            "pixels_generated": int(self.generated.sum()), "pixels_sent_and_kept": int(self.held.sum()),
            "pixels_of_the_picture": self.active, "seconds": self.time / 1e9,
            "phases": self.phases, "alone_seconds": self.alone / 1e9,
            "efficiency": self.alone / (nodes * self.time) if self.time else 1.0,
            "imbalance": float(np.ptp(self.merges)) / mean if mean else 0.0,
            "traffic": {"messages": int(self.sent[:, MESSAGES].sum()), "words": int(self.sent[:, WORDS].sum()),
                        "concurrent_words": self.concurrent_words},
            "of_a_node": spread_over_nodes(
                triangles=self.triangles, pixels_generated=self.generated, pixels_held=self.held,
                pixels_merged=self.merges, words_sent=self.sent[:nodes, WORDS]),
            "picture": content_hash(self.picture)}


def check_machine(nodes: int, width: int, height: int) -> None:
    """Nodes are those of a hypercube, and the screen has pixels.

    Raises
    ------
    InputError
        They are no power of two up to 1024, or the screen is none.
    """
    check_power_of_two("merge", "Nodes", nodes)
    for name, value in (("Width", width), ("Height", height)):
        if not 1 <= value <= 1 << 13:
            raise InputError(f"merge: {name} must be 1 to {1 << 13}, not {value!r}", parameter=name)


def simulate_merge(triangles: ScreenTriangles, number: np.ndarray, scheme: MergeScheme, *, nodes: int, width: int,
                   height: int, timing: NodeTiming | None = None, work: MergeWork | None = None,
                   watch: Callable[[Pixels, Assignment], None] | None = None) -> MergeRun:
    """Simulate all phases: polygons are dealt in turn, drawn on the whole screen by each node, and pixels merged.

    Parameters
    ----------
    triangles, number
        On the screen, and of each its number in the scene.
    scheme
        How pixels are merged.
    nodes
        P, a power of two up to 1024.
    width, height
        Pixels of the screen; a node has a line at least.
    timing, work
        Of a node. Default: the iPSC/2's, and ours.
    watch
        Is given the pixels of all nodes before the exchange and after each step, and the lines of the regions.

    Raises
    ------
    InputError
        The nodes are no hypercube or more than the lines, or the screen has no pixels.

    Source: Kurc 1997, sections 4.2 to 4.5.
    """
    check_machine(nodes, width, height)
    timing, work = timing or NodeTiming(), work or MergeWork()
    cube = hypercube(nodes, timing)
    dealt = np.bincount(np.arange(triangles.dealt) % nodes, minlength=nodes)
    spans = span_lists(triangles, number % nodes, width, height)
    counts = extended_counts(spans, nodes, height).sum(axis=0)
    lines = divide_lines(scheme.division, counts, nodes)
    if scheme.division == "packed":
        spans = span_lists(triangles, number % nodes, width, height, lines.number)
    pixels = pixels_of_spans(spans, nodes, width)
    generated, made = pixel_counts(spans, nodes), np.bincount(spans.node, minlength=nodes)
    cells = width * height if scheme.is_full else 0
    span_ends = run_program(work_step((dealt * work.triangle + made * work.span) * timing.operation), cube,
                            np.zeros(nodes))
    drawing = work_step(generated * work.pixel * timing.operation + cells * work.clearing)
    dividing = division_program(scheme.division, counts, made, timing, counting=work.counting,
                                is_direct=scheme.name == "aapc")
    drawn_ends = span_ends
    # Lines are renumbered before pixels are drawn, or divided by the pixels that have been.
    for program in (dividing, drawing) if scheme.division == "packed" else (drawing, dividing):
        drawn_ends = run_program(program, cube, drawn_ends)
    merge = _merge_all if scheme.name == "aapc" else _merge_steps
    done, ends, concurrent, merges = merge(pixels, lines, scheme, width, cube, drawn_ends, timing, work, watch)
    alone = (triangles.dealt * work.triangle + int(made.sum()) * work.span
             + int(generated.sum()) * work.pixel) * timing.operation + cells * work.clearing
    return MergeRun(scheme=scheme, triangles=dealt, generated=generated, held=np.diff(pixels.start),
                    span_ends=span_ends, drawn_ends=drawn_ends, ends=ends, alone=alone, concurrent_words=concurrent,
                    merges=merges, sent=cube.sent, picture=_picture(done, lines, width, height),
                    active=len(done.location))


def _merge_steps(pixels, lines, scheme, width, cube, start, timing, work, watch):
    """The pixels at the end, when nodes end, the concurrent words, and the merges of each node; on a mesh."""
    nodes, bounds = len(start), lines.bounds * width
    steps = mesh_steps(dimensions_of(scheme.name, nodes))
    shape = len(steps.target), nodes
    words, times, merges = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64), np.zeros(nodes, np.int64)
    if watch:
        watch(pixels, lines)
    for step in range(len(steps.target)):
        pixels, counts = exchange(pixels, steps, step, bounds)
        if scheme.is_full:
            sent = bounds[steps.last[step]] - bounds[steps.first[step]]
            received = sent[steps.source[step]]
            words[step], times[step] = CELL_WORDS * sent, received * work.cell
            merges += received
        else:
            words[step] = PIXEL_WORDS * counts[:, SENT]
            times[step] = (counts[:, TOUCHED] * work.merging + counts[:, MET] * work.deciding) * timing.operation
            merges += counts[:, TOUCHED]
        if watch:
            watch(pixels, lines)
    ends = run_program(exchange_program(steps, words, times), cube, start)
    return pixels, ends, int(words.max(axis=1).sum()), merges


def _merge_all(pixels, lines, scheme, width, cube, start, timing, work, watch):
    """The same from each to all."""
    nodes, bounds = len(start), lines.bounds * width
    counts = received_by_owners(pixels, bounds)
    node = np.arange(nodes)
    cells = np.diff(bounds)
    sent = np.tile(cells, (nodes, 1)) if scheme.is_full else counts
    words = (CELL_WORDS if scheme.is_full else PIXEL_WORDS) * sent
    merges = sent.sum(axis=0) - sent[node, node]
    if scheme.is_full:
        times = merges * work.cell
    else:
        times = (merges * work.comparing + counts[node, node] * work.scattering) * timing.operation * (nodes > 1)
        times += cells * work.clearing * (nodes > 1)
    if watch:
        watch(pixels, lines)
    done = scattered(pixels, bounds)
    if watch:
        watch(done, lines)
    ends = all_to_all_ends(words, cube, start)
    concurrent = sum(int(words[node, node ^ step].max()) for step in range(1, nodes))
    return done, run_program(work_step(times), cube, ends), concurrent, merges


def _picture(pixels, lines, width, height):
    """H x W x 3 uint8 of merged pixels; black without one."""
    shade = np.zeros(width * height, dtype=np.uint32)
    line, x = np.divmod(pixels.location, width)
    shade[lines.order[line] * width + x] = pixels.shade
    return (shade[:, None] >> np.array([16, 8, 0], dtype=np.uint32) & 255).astype(np.uint8).reshape(height, width, 3)

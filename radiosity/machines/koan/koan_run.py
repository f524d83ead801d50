"""KOAN run: a picture of a scene in shared pages, on simulated nodes."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, check_int
from radiosity.machines.common.content_hash import content_hash
from radiosity.machines.common.hypercube import MESSAGES, WORDS
from radiosity.machines.common.nodes import check_power_of_two, spread_over_nodes
from radiosity.machines.koan.page_run import Items, ItemTimes, run_items
from radiosity.machines.koan.page_state import PageState, References, page_state
from radiosity.machines.koan.page_timing import PageTiming
from radiosity.machines.koan.pixel_items import PixelItems, pixel_items
from radiosity.machines.koan.ray_pages import PageString
from radiosity.machines.koan.scene_pages import ScenePages

__all__ = ["KoanRun", "check_machine", "simulate_picture"]


@dataclass(frozen=True, kw_only=True, eq=False)
class KoanRun:
    """A picture that simulated nodes have made.

    Parameters
    ----------
    layout, frames
        The pages, and the frames of each node's cache.
    items, times
        The items of pixels, and who worked on them.
    work
        ns of all items without faults.
    touches
        References of all items.
    picture
        H x W x 3 uint8, put together from the items.
    state
        Pages, links and counts at the end.
    """

    layout: ScenePages
    frames: int
    items: PixelItems
    times: ItemTimes
    work: int
    touches: int
    picture: np.ndarray
    state: PageState

    @property
    def nodes(self) -> int:
        """N."""
        return len(self.times.stops)

    @property
    def time(self) -> int:
        """Ns until the last item is done."""
        return int(self.times.ends.max())

    @property
    def efficiency(self) -> float:
        """The time of one node without faults over that of all nodes."""
        return self.work / (self.nodes * self.time)

    def report(self) -> dict:
        """Times, faults, traffic and a hash of the picture, ready for JSON."""
        counts, sent = self.state.counted, self.state.cube.sent
        total = {name: int(each.sum()) for name, each in counts.items()}
        busy = np.bincount(self.times.node, self.times.ends - self.times.begins, self.nodes)
        return {
            "nodes": self.nodes, "pages": len(self.layout), "page_bytes": self.layout.page_bytes,
            "shared_bytes": self.layout.size, "frames": self.frames, "items": len(self.times.node),
            "seconds": self.time / 1e9, "alone_seconds": self.work / 1e9, "efficiency": self.efficiency,
            "faults": total["faults"], "miss_ratio": total["faults"] / max(1, self.touches),
            "fetched_bytes": total["fetches"] * self.layout.page_bytes, "drops": total["drops"],
            "invalidations": total["invalidations"], "recalls": total["recalls"], "write_backs": total["write_backs"],
            "traffic": {"messages": int(sent[:, MESSAGES].sum()), "words": int(sent[:, WORDS].sum()),
                        "ring_requests": total["ring_requests"], "ring_hops": total["ring_hops"]},
            "passed_items": int((self.times.node != np.repeat(np.arange(self.nodes), np.diff(self.items.own))).sum()),
            "of_a_node": spread_over_nodes(
                busy_milliseconds=busy // 1_000_000, faults=counts["faults"], pages_sent=counts["pages_sent"],
                interrupted_milliseconds=counts["interrupted"] // 1_000_000),
            "picture": content_hash(self.picture)}


def check_machine(nodes: int, frames: int) -> None:
    """Nodes are those of a hypercube, and have a frame.

    Raises
    ------
    TypeError
        A number is no int.
    InputError
        The nodes are no power of two up to 1024, or there is no frame.
    """
    check_int("koan: Nodes", nodes)
    check_int("koan: Frames", frames)
    check_power_of_two("koan", "Nodes", nodes)
    if frames < 1:
        raise InputError(f"koan: Cache must be at least one page, not {frames!r} pages", parameter="cache")


def simulate_picture(picture: np.ndarray, string: PageString, work: np.ndarray, layout: ScenePages, *, nodes: int,
                     frames: int, side: int = 3, schedule: str = "mixed", timing: PageTiming | None = None,
                     log: int = 0) -> KoanRun:
    """Simulate the nodes.

    Parameters
    ----------
    picture
        H x W x 3 uint8: what a node makes of each pixel.
    string, work
        References and ns of each pixel, row by row.
    layout
        The pages.
    nodes, frames
        N, a power of two up to 1024, and the frames of a node's cache.
    side, schedule
        See `pixel_items`.
    timing
        Of faults and messages.
    log
        Rows of the log of pages.

    Raises
    ------
    InputError
        Nodes, frames, side or schedule are out of range, or tiles are more than columns or rows of pixels.

    Source: Badouel 1991, sections 3 and 4.
    """
    check_machine(nodes, frames)
    timing = timing or PageTiming()
    divided = pixel_items((picture.shape[1], picture.shape[0]), nodes, side=side, schedule=schedule)
    lengths = np.diff(string.first)[divided.pixel]
    first = np.append(0, lengths.cumsum())[divided.first]
    # References of pixels one after the other, each of which reads.
    place = np.repeat(string.first[divided.pixel] - lengths.cumsum() + lengths, lengths) + np.arange(first[-1])
    pages = 2 * string.page[place]
    touches = np.add.reduceat(string.touches[divided.pixel], divided.first[:-1])
    works = np.add.reduceat(np.asarray(work, dtype=np.int64)[divided.pixel], divided.first[:-1])
    check = timing.access * touches // np.maximum(np.diff(first), 1)
    state = page_state(nodes=nodes, pages=len(layout), frames=frames, page_bytes=layout.page_bytes, timing=timing,
                       log=log)
    times = run_items(state, Items(first, works, check, divided.own),
                      References(pages, np.empty(0, dtype=np.int64), np.empty(0)), np.zeros(nodes, dtype=np.int64),
                      is_shared=schedule != "static")
    made = divided.pixel[np.repeat(times.node >= 0, np.diff(divided.first))]
    found = np.zeros_like(picture)
    found.reshape(-1, 3)[made] = picture.reshape(-1, 3)[made]
    return KoanRun(layout=layout, frames=frames, items=divided, times=times, work=int(works.sum()),
                   touches=int(touches.sum()), picture=found, state=state)

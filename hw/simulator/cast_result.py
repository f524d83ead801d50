"""What a cast on the simulated machine returns: results, cycles, counters."""

from dataclasses import dataclass

from golden.config import Config
from golden.memory_map import MemoryImage
from golden.noc.packing import reply_flits, request_flits
from hw.ctu.ctu_formats import GRID_GROUP

__all__ = ["SHARED_COUNTERS", "SINCE_RESET", "CastResult"]

# Registers that count for the whole machine, beside the counters of each cluster.
SHARED_COUNTERS = ("flits", "flit_stalls", "cell_hits", "cell_misses", "patch_hits", "patch_misses")

# Counters of a cluster that the machine does not clear when a cast begins.
SINCE_RESET = ("memory_answered", "memory_stalls")


@dataclass(frozen=True, kw_only=True, eq=False)
class CastResult:
    """The result of one frustum.

    Parameters
    ----------
    image
        The memory image with hits, and with sums if they were requested.
    cycles, load_cycles, result_cycles
        Cycles of the cast, of the load before it, and of the writing of results.
    counters
        `hw.cluster.COUNTERS` of each cluster, all of this cast.
    shared
        `SHARED_COUNTERS` of this cast.
    """

    image: MemoryImage
    cycles: int
    load_cycles: int
    result_cycles: int
    counters: list[dict[str, int]]
    shared: dict[str, int]

    def total(self, name: str) -> int:
        """A counter, summed over all clusters."""
        return sum(one[name] for one in self.counters)

    def bound(self, config: Config) -> dict[str, int]:
        """Lower bounds of the cycles, by unit: what the unit of the busiest cluster needs at its full rate.

        Traversal takes the largest of four: steps divided by the pipelines, cells met, grid rays sent, and grid rays
        requested divided by the size of a group. Intersection takes a cycle for each test, a patch four cycles.
        """
        pipelines = config.ctu.traversal_pipelines(config.noc.nodes)
        return {"traversal": max(max(
                    -(-one["traversal_steps"] // pipelines), one["traversal_cells"], one["traversal_rays"],
                    -(-one["traversal_requests"] // GRID_GROUP)) for one in self.counters),
                "intersection": max(one["intersection_tested"] for one in self.counters),
                "patches": max(4 * one["intersection_patches"] for one in self.counters)}

    def links(self, config: Config) -> float:
        """Mean number of links that a flit passes; 0 if none was sent."""
        least = {"source": 0, "destination": 0, "patch": 0}
        flits = len(request_flits(config, **least)) + len(reply_flits(
            config, **least, surface=0, vertices=[(0, 0, 0)] * 4))
        sent = flits * self.total("memory_remote")
        return max(0.0, self.shared["flits"] / sent - 1) if sent else 0.0

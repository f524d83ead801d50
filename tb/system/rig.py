"""A simulated machine and its host: images of frusta in, hits and what they took out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.config import Config
from golden.memory_map import MemoryImage
from golden.noc.packing import reply_flits, request_flits
from golden.noc.topology import grid_shape
from golden.output import whole_file
from hw.formats import GRID_GROUP
from hw.host import LIVES, Host
from hw.memsys.cache_policy import CachePolicy
from tb.system.fast_port import FastPort, complete

__all__ = ["Cast", "Rig", "Waves", "engine_config"]

# What a simulation needs, unless a run says otherwise: little room for rays, memories that are cleared seldom, and
# shells that do not wait for the ones before.
USUAL = {"icu.rays": 1 << 14, "icu.generation_bits": 8, "ctu.run_ahead": 6}
# Registers beside the counters.
SHARED = ("flits", "flit_stalls", "cell_hits", "cell_misses", "patch_hits", "patch_misses")
# Cycles between two looks at the counters for a timeline.
LOOK = 200


def engine_config(config: Config, *, clusters: int, topology: str, given: tuple[str, ...] = (),
                  rays: int = 0) -> Config:
    """A configuration for so many clusters, with room for what is simulated usually.

    Parameters
    ----------
    given
        Parameters, by path, that the user has chosen and that stay.
    rays
        A frustum's, for which there is room however they are shared out.

    Errors
    ------
    InputError
        The topology cannot have so many.
    """
    columns, rows = grid_shape(max(1, clusters))
    usual = USUAL | {"icu.rays": max(USUAL["icu.rays"], rays)}
    changes = {name: value for name, value in usual.items() if name not in given}
    return config.replace({**changes, "noc.topology": topology, "noc.columns": columns, "noc.rows": rows})


@dataclass(frozen=True, kw_only=True)
class Waves:
    """Signals of some cycles, as VCD, from so many cycles after the start of a cast on."""

    path: Path
    begin: int
    cycles: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Cast:
    """What came of a frustum.

    Parameters
    ----------
    image
        With hits, and sums if they were asked for.
    cycles, load_cycles, result_cycles
        Of the cast, of what was loaded before, and of the writing of results.
    counters
        `hw.cluster.COUNTERS` of each cluster.
    shared
        `SHARED`, of this cast.
    """

    image: MemoryImage
    cycles: int
    load_cycles: int
    result_cycles: int
    counters: list[dict[str, int]]
    shared: dict[str, int]

    def total(self, name: str) -> int:
        """A counter, of all clusters together."""
        return sum(one[name] for one in self.counters)

    def bound(self, config: Config) -> dict[str, int]:
        """Cycles below which no cluster can be by what its traversal, its intersection and its patches take.

        Traversal is steps over pipelines, cells that are met and grid rays that are sent, one in a cycle each, or those
        that are looked at, a group in a cycle; intersection is tests.
        """
        pipelines = config.ctu.traversal_pipelines(config.noc.nodes)
        return {"traversal": max(max(
                    -(-one["traversal_steps"] // pipelines), one["traversal_cells"], one["traversal_rays"],
                    -(-one["traversal_requests"] // GRID_GROUP)) for one in self.counters),
                "intersection": max(one["intersection_tested"] for one in self.counters),
                "patches": max(4 * one["intersection_patches"] for one in self.counters)}

    def links(self, config: Config) -> float:
        """Links that a flit passes on average; 0 if none was sent."""
        least = {"source": 0, "destination": 0, "patch": 0}
        flits = len(request_flits(config, **least)) + len(reply_flits(
            config, **least, surface=0, vertices=[(0, 0, 0)] * 4))
        sent = flits * self.total("memory_remote")
        return max(0.0, self.shared["flits"] / sent - 1) if sent else 0.0


class Rig:
    """A machine in the fast simulation.

    Parameters
    ----------
    config
        The configuration.
    policy
        Of its caches. Default: the configuration's.
    memory
        Of `FastPort`: latency, spread, shuffles, seed, traced.
    """

    def __init__(self, config: Config, *, policy: CachePolicy | None = None, **memory):
        self.config, self._policy = config, policy
        self.port = FastPort(config, size=0, **memory)
        self._host, self._before = Host(self.port, config), None
        complete(self._host.identify())

    def close(self) -> None:
        """Give its memory back."""
        self.port.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def cast(self, image: MemoryImage, *, total: int = 0, sums: bool = False, again: bool = False,
             timeline: list | None = None, waves: Waves | None = None) -> Cast:
        """Cast a frustum.

        Parameters
        ----------
        image
            Of the frustum; what is the same as in the image before is not loaded again.
        total, sums
            What the weights add up to, and whether sums are written.
        again
            It is the one that was cast before: nothing is loaded.
        timeline
            To which cycle and counters of each cluster are appended now and then.
        waves
            Written of this cast; the rig is ``traced``.

        Errors
        ------
        InputError
            See `hw.host.check_image`.
        EngineError
            See `Host`.
        """
        begin = self.port.cycles
        if not again:
            self._load(image)
        loaded = self.port.cycles
        shared = self._shared()
        complete(self._host.start())
        if waves:
            complete(self.port.wait(waves.begin))
            with whole_file(waves.path) as part:
                self.port.trace(part)
                complete(self.port.wait(waves.cycles))
                self.port.trace(None)
        while timeline is not None and complete(self._host.status())["casts"]:
            timeline.append((self.port.cycles - loaded, complete(self._host.counters())))
            complete(self.port.wait(LOOK))
        complete(self._host.finish("casts", timeout=1 << 26))
        cycles = complete(self._host.read("cycles"))
        counters, after = complete(self._host.counters()), self._shared()
        cast = self.port.cycles
        result = complete(self._host.results(total=total, sums=sums))
        return Cast(image=result, cycles=cycles, load_cycles=loaded - begin, result_cycles=self.port.cycles - cast,
                    counters=counters, shared={name: after[name] - shared[name] for name in SHARED})

    def _load(self, image):
        before = self._before
        self._before = None
        lives = tuple(life for life, names in LIVES.items() if life == "frustum" or before is None or any(
            not np.array_equal(image[name], before[name]) for name in names))
        if "scene" in lives:
            lives = tuple(LIVES)
        size = len(image.to_bytes())
        if size > self.port.size:
            self.port.resize(size)
        complete(self._host.load(image, lives=lives, policy=self._policy))
        self._before = image

    def _shared(self):
        return {name: complete(self._host.read(name)) for name in SHARED}

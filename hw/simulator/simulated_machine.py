"""A simulated machine with its host: memory images of frusta in, results and counters out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.config import Config
from golden.memory_map import MemoryImage
from golden.output import whole_file
from hw.host import LIVES, Host
from hw.memsys.cache_policy import CachePolicy
from hw.registers.register import WORD_BYTES
from hw.simulator.cast_result import SHARED_COUNTERS, SINCE_RESET, CastResult
from hw.simulator.simulated_port import SimulatedPort, complete
from hw.simulator.utilization import SAMPLED
from hw.simulator.wave_view import write_wave_view

__all__ = ["SAMPLE_CYCLES", "SimulatedMachine", "WaveformWindow"]

# Cycles between two samples of the counters for a timeline.
SAMPLE_CYCLES = 200


@dataclass(frozen=True, kw_only=True)
class WaveformWindow:
    """The cycles whose signals are written as VCD.

    Parameters
    ----------
    path
        The file. A save file for GTKWave with the ports of the units is written beside it (.gtkw).
    begin
        First cycle, counted from the start of the cast.
    cycles
        Number of cycles.
    """

    path: Path
    begin: int
    cycles: int


class SimulatedMachine:
    """The compiled RTL of an engine, its main memory and its host.

    Parameters
    ----------
    config
        The configuration.
    policy
        The caches' policy. Default: the configuration's.
    memory
        Parameters of `SimulatedPort`: latency, spread, shuffles, seed, traced, library, progress.
    """

    def __init__(self, config: Config, *, policy: CachePolicy | None = None, **memory):
        self.config, self._policy = config, policy
        self.port = SimulatedPort(config, size=0, **memory)
        self._host = Host(self.port, config)
        # The tables that the machine holds, by region; None if that is not known.
        self._held: dict[str, np.ndarray] | None = None
        # Registers count on after a cast; known values need no reads, whose cycles clear memories before the next cast.
        self._counted = [dict.fromkeys(SINCE_RESET, 0)] * config.noc.nodes
        complete(self._host.identify())

    def close(self) -> None:
        """Free the machine's memory."""
        self.port.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def cast(self, image: MemoryImage, *, total: int = 0, sums: bool = False, again: bool = False,
             timeline: list | None = None, waves: WaveformWindow | None = None) -> CastResult:
        """Cast a frustum.

        Parameters
        ----------
        image
            The frustum's memory image. Of `LIVES` only what differs from the tables that the machine holds is loaded.
        total
            The sum of all weights.
        sums
            Have sums written.
        again
            The frustum is the one that was cast before: nothing is loaded.
        timeline
            A list to which samples are appended: the cycle, and the counters `SAMPLED` of each cluster. The last
            sample is of the end of the cast, with all counters.
        waves
            The signals to write; needs ``traced``.

        Raises
        ------
        InputError
            See `hw.host.check_image`.
        EngineError
            See `Host`.
        """
        begin = self.port.cycles
        # An error in between resets the machine: then the registers are read again.
        earlier, self._counted = self._counted, None
        if not again:
            self._load(image)
        loaded = self.port.cycles
        shared, earlier = self._shared_counters(), earlier or complete(self._host.counters(SINCE_RESET))
        complete(self._host.start())
        if waves:
            complete(self.port.wait(waves.begin))
            with whole_file(waves.path) as part:
                self.port.trace(part)
                complete(self.port.wait(waves.cycles))
                self.port.trace(None)
            write_wave_view(waves.path, waves.path.with_suffix(".gtkw"))
        while timeline is not None and complete(self._host.status())["casts"]:
            timeline.append((self.port.cycles - loaded, complete(self._host.counters(SAMPLED))))
            complete(self.port.wait(SAMPLE_CYCLES))
        complete(self._host.finish("casts", timeout=1 << 26))
        cycles = complete(self._host.read("cycles"))
        counters, after = self._counters_since(earlier), self._shared_counters()
        if timeline is not None:
            self._end_timeline(timeline, cycles, counters)
        cast = self.port.cycles
        result = complete(self._host.results(total=total, sums=sums))
        return CastResult(image=result, cycles=cycles, load_cycles=loaded - begin,
                          result_cycles=self.port.cycles - cast, counters=counters,
                          shared={name: after[name] - shared[name] for name in SHARED_COUNTERS})

    def _counters_since(self, earlier):
        """The counters of the cast: those `SINCE_RESET` are differences, modulo a register's range."""
        self._counted = complete(self._host.counters())
        return [now | {name: now[name] - before[name] & (1 << 8 * WORD_BYTES) - 1 for name in SINCE_RESET}
                for now, before in zip(self._counted, earlier, strict=True)]

    @staticmethod
    def _end_timeline(timeline, cycles, counters):
        """The sample of the end; the counters of a sample that was being read at the end are the same."""
        while timeline and timeline[-1][0] >= cycles:
            timeline.pop()
        timeline.append((cycles, counters))

    def _load(self, image):
        held, self._held = self._held, None
        lives = tuple(life for life in LIVES if life == "frustum" or held is None or not _holds(held, image, life))
        if "scene" in lives:
            lives = tuple(LIVES)
        size = len(image.to_bytes())
        if size > self.port.size:
            self.port.resize(size)
        complete(self._host.load(image, lives=lives, policy=self._policy))
        self._held = {name: image[name] if life in lives else held[name] for life in LIVES for name in LIVES[life]}

    def _shared_counters(self):
        return {name: complete(self._host.read(name)) for name in SHARED_COUNTERS}


def _holds(held, image, life):
    """Whether the tables ``held`` serve as the image's of one of `LIVES`: grid rays of more shells do for fewer."""
    return all(np.array_equal(image[name], held[name][:len(image[name])] if life == "rays" else held[name])
               for name in LIVES[life])

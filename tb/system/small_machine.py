"""Small machines of one and two clusters, which a commit's tests share: each is compiled once."""

from dataclasses import replace

import numpy as np
import pytest

from golden.memory_map import MemoryImage
from golden.memory_map.layout import NONE
from hw.host import LIVES, EngineError, Host
from hw.registers.error_code import ErrorCode
from hw.simulator.simulated_port import SimulatedPort, complete
from tb.lib.configurations import config_of
from tb.system.scenes import Frustum

__all__ = ["BASE", "CLUSTERS", "CONFIGS", "LISTS", "ONE_CLUSTER", "SMALL", "Driven", "cut", "resident"]

BASE = 0x1_0000_4000
# Capacities for small frusta only: resident sets, lists and caches are too small for the scene.
SMALL = {"icu.rays": 1024, "icu.side_bits": 6, "icu.patch_bits": 9, "icu.generation_bits": 2,
         "memsys.scene_cells": 1024, "memsys.own_cells": 64, "memsys.own_entries": 128, "memsys.own_patches": 16,
         "memsys.cell_lines": 8, "memsys.patch_lines": 8, "memsys.lfu_lines": 4, "memsys.cache_fetches": 2,
         "memsys.filter_generation_bits": 2, "memory.timeout_bits": 9, "ctu.ray_slots": 256, "ctu.grid_row_bits": 7,
         "ctu.grid_column_bits": 9, "ctu.shell_bits": 4, "ctu.near_cell_bits": 5, "noc.rows": 1}
# With subshell lists.
LISTS = {"ctu.subshell_bits": 6}
CONFIGS = {clusters: config_of(SMALL | {"noc.columns": clusters}) for clusters in (1, 2)}
# For `pytest.mark.parametrize`: pytest-xdist runs the tests of one machine in one process, so that none waits for the
# compiler in another one.
CLUSTERS = [pytest.param(clusters, marks=pytest.mark.xdist_group(f"machine {clusters}")) for clusters in CONFIGS]
ONE_CLUSTER = CLUSTERS[0].marks[0]
# Around the images: bytes that may not be written.
_MARGIN = 256


def _with(frustum, **regions):
    return replace(frustum, image=MemoryImage({**frustum.image.regions, **regions}))


def cut(frustum: Frustum, *columns: int) -> Frustum:
    """The frustum with sections of other widths: cluster k has the columns from ``columns[k]`` on."""
    clusters = frustum.image["clusters"].copy()
    clusters["first_column"], clusters["end_column"] = columns, (*columns[1:], len(frustum.image["columns"]))
    return _with(frustum, clusters=clusters)


def resident(frustum: Frustum, cluster: int | None) -> Frustum:
    """The frustum with the first patches of the scene in the memory of one cluster, as many as it can hold, or with all
    patches in main memory alone.
    """
    clusters, residence = frustum.image["clusters"].copy(), frustum.image["residence"].copy()
    count = 0 if cluster is None else min(SMALL["memsys.own_patches"], len(residence))
    residence["cluster"], residence["address"] = NONE, NONE
    residence["cluster"][:count], residence["address"][:count] = cluster or 0, np.arange(count)
    residents = np.zeros(count, frustum.image["residents"].dtype)
    residents["patch"] = np.arange(count)
    clusters["first_resident"], clusters["residents"] = 0, 0
    if count:
        clusters["residents"][cluster], clusters["first_resident"][cluster + 1:] = count, count
    return _with(frustum, clusters=clusters, residence=residence, residents=residents)


class Driven:
    """A simulated machine with its host. Main memory holds images, and around them bytes that must not change.

    Parameters
    ----------
    frusta
        Main memory can hold an image of each of them.
    images
        The number of images at the same time.
    memory
        Parameters of `SimulatedPort`.
    """

    def __init__(self, frusta: list[Frustum], *, images: int = 1, **memory):
        self._size = max(len(one.image.to_bytes()) for one in frusta)
        self.config = CONFIGS[len(frusta[0].image["clusters"])]
        self.port = SimulatedPort(self.config, size=2 * _MARGIN + images * self._size, base=BASE - _MARGIN, **memory)
        self.host = Host(self.port, self.config, base=BASE)
        self._expected = bytearray(b"\xa5" * self.port.size)
        complete(self.port.write_memory(BASE - _MARGIN, self._expected))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.port.close()

    def __call__(self, coroutine):
        """The result of one of the host's coroutines."""
        return complete(coroutine)

    def _write_bytes(self, data, number, offset=0):
        first = _MARGIN + number * self._size + offset
        self._expected[first:first + len(data)] = data

    def put(self, data: bytes) -> None:
        """Put bytes where image 0 is."""
        self._write_bytes(data, 0)
        complete(self.host.write_image(data))

    def load(self, frustum: Frustum, *lives: str, at: int = 0, **given) -> None:
        """Load a frustum's image, all tables unless ``lives`` are named, which is image ``at`` of main memory."""
        self._write_bytes(frustum.image.to_bytes(), at)
        complete(self.host.load(frustum.image, lives=lives or tuple(LIVES), base=BASE + at * self._size, **given))

    def cast(self, *, timeout: int = 1 << 18) -> int:
        """Cycles of a cast of what has been loaded."""
        return complete(self.host.cast(timeout=timeout))

    def results(self, frustum: Frustum, *, at: int = 0, hits: bool = True, sums: np.ndarray | bool = True, total=None,
                earlier: bool = False) -> None:
        """Have results written. They must be golden's, or the ``sums`` given; no other byte of memory may change."""
        total = frustum.total if total is None else total
        complete(self.host.results(total=total, hits=hits, sums=sums is not False, earlier=earlier))
        written, offsets = frustum.written, frustum.image.offsets
        if sums is not True and sums is not False:
            written["sums"]["sum"] = sums
        for name, is_written in (("hits", hits), ("sums", sums is not False)):
            if is_written:
                self._write_bytes(written[name].tobytes(), at, offsets[name])
        self.is_as_expected()

    def is_as_expected(self) -> None:
        """All of main memory is what the host and golden's results have written."""
        found = complete(self.port.read_memory(BASE - _MARGIN, self.port.size))
        wrong = np.flatnonzero(np.frombuffer(found, np.uint8) != np.frombuffer(self._expected, np.uint8))
        assert not len(wrong), f"{len(wrong)} bytes of main memory are wrong, the first at {wrong[0] - _MARGIN:#x}"
        assert self.port.outside == 0

    def stops_with_results_of(self, frustum: Frustum) -> None:
        """Each byte of the results is golden's or the one that was there before: then it is taken as it is."""
        found = complete(self.port.read_memory(BASE, self._size))
        written, before = frustum.written.to_bytes(), frustum.image.to_bytes()
        assert all(now in both for now, *both in zip(found, written, before, strict=False))
        self._write_bytes(found[:len(before)], 0)

    def check(self, frustum: Frustum, *lives: str, **given) -> None:
        """Load, cast and compare a frustum."""
        self.load(frustum, *lives, **given)
        self.cast()
        self.results(frustum)

    def fails(self, codes: ErrorCode | tuple[ErrorCode, ...], coroutine) -> EngineError:
        """A coroutine of the host must end in an error of these."""
        with pytest.raises(EngineError) as raised:
            complete(coroutine)
        assert raised.value.code in (codes if isinstance(codes, tuple) else (codes,)), raised.value
        return raised.value

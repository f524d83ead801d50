"""Cast store: casts in a folder, so that a simulation of other machines need not explore them again."""

import hashlib
import json
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from golden.base.library_versions import library_versions
from golden.base.output import whole_file
from golden.base.source_digest import source_digest
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.ray_list import pack_rays
from golden.engine.schedule.subshells import SubshellList
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.section_trace import CastTimes, SectionTrace
from radiosity.machines.engine.simulated_cast import SimulatedCast, cast_section

__all__ = ["CastStore"]

_COUNTS = ("tests", "cells", "grid_rays", "hit")
_NUMBERS = ("free", "cycles")


class CastStore:
    """Casts of sections in cells of one scene, each explored once.

    Parameters
    ----------
    shelling, config
        Shelling by settle codes, and its configuration.
    timing
        Latencies and capacities of a cluster.
    folder
        A file for each cast, of these sources and libraries alone. Default: casts are kept in memory alone.
    """

    def __init__(self, shelling: Shelling, config: Config, timing: ClusterTiming, *, folder: Path | None = None):
        self._shelling, self._config, self._timing, self._folder, self._kept = shelling, config, timing, folder, {}
        digest, table = hashlib.sha256(source_digest().encode()), shelling.table
        for array in (shelling.geometry.vertices, table.count, table.patches.read(
                table.entries(np.arange(len(table.count))))):
            digest.update(np.ascontiguousarray(array).tobytes())
        # Of the network a cast has the number of pipelines alone.
        parameters = {name: value for name, value in config.parameters().items() if not name.startswith("noc.")}
        digest.update(json.dumps([library_versions(), parameters, config.ctu.traversal_pipelines(config.noc.clusters),
                                  asdict(timing)], sort_keys=True).encode())
        self._scene = digest.digest()

    def cast(self, record: FrustumRecord, section: Sector, subshells: SubshellList | None = None, *,
             others: np.ndarray | None = None, ahead: int = 0) -> SimulatedCast:
        """The cast of a section, see `cast_section`."""
        if others is not None and not others.any():
            others, ahead = None, 0
        name = self._name(record, section, subshells, others, ahead)
        if name not in self._kept:
            path = self._folder / f"{name}.npz" if self._folder else None
            cast = _read(path) if path and path.exists() else None
            if cast is None:
                cast = cast_section(self._shelling, record, self._config, self._timing, section=section,
                                    subshells=subshells, others=others, ahead=ahead)
                if path:
                    _write(path, cast)
            self._kept[name] = cast
        return self._kept[name]

    def _name(self, record, section, subshells, others, ahead):
        """What a cast follows from, as the name of its file."""
        digest = hashlib.sha256(self._scene)
        for value in (record.origin, record.matrix, record.bundle, record.source, *asdict(section).values()):
            digest.update(np.asarray(value, dtype=np.int64).tobytes())
        digest.update(record.all_directions().tobytes())
        if record.bundle == Bundle.SHADOW:
            digest.update(pack_rays(record, record.listed).tobytes())
        if subshells is not None:
            digest.update(np.stack([subshells.patches, subshells.shell]).tobytes())
        if others is not None:
            digest.update(np.append(np.flatnonzero(others), ahead).tobytes())
        return digest.hexdigest()[:32]


def _write(path, cast):
    trace = {field.name: getattr(cast.trace, field.name) for field in fields(SectionTrace)}
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part, part.open("wb") as file:
        np.savez_compressed(file, begins=cast.times.begins, ends=cast.times.ends, numbers=np.array(
            [getattr(cast.times, name) for name in _NUMBERS] + [getattr(cast, name) for name in _COUNTS]), **trace)


def _read(path):
    """The cast of a file; None of one that lacks some of it or cannot be read, which is written anew."""
    try:
        return _cast_of(path)
    except Exception:  # numpy raises errors of any type for bad content
        return None


def _cast_of(path):
    # Of a torn file numpy leaves open what it has opened itself.
    with path.open("rb") as file, np.load(file) as stored:
        numbers = stored["numbers"].tolist()
        times = CastTimes(begins=stored["begins"], ends=stored["ends"], **dict(zip(_NUMBERS, numbers, strict=False)))
        trace = SectionTrace(**{field.name: stored[field.name][()] for field in fields(SectionTrace)})
    return SimulatedCast(trace=trace, times=times, **dict(zip(_COUNTS, numbers[len(_NUMBERS):], strict=True)))

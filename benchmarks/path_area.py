"""Area of what is between a cluster and the patches that it does not hold, from the history of recorded figures."""

from functools import cache

from benchmarks.report import table
from benchmarks.shared_scene import Access
from radiosity.flow.synthesis.history import Record, last_records, read_history

__all__ = ["area_table", "equal_area_table", "in_blocks", "path_area"]

# Requests that a store has in flight with one request at a time: the least that its hardware has.
_LEAST, _REQUESTS, _ROUTERS = 2, 16, 2
# An ECP5-85 has so many LUTs and block RAMs.
_LUTS, _BLOCKS = 83640, 208
# Of the machines that are compared: patches of a scene, clusters, and patches of a store.
_PATCHES, _CLUSTERS, _FRAMES = (256, 512, 1024, 2048, 4096, 8192), 8, 128


@cache
def _records():
    return last_records(read_history())


def _record(block, unit, parameters="") -> Record | None:
    return _records().get(("ecp5", "paper", parameters, block, unit))


def _own(patches):
    """The memory of a resident set: the least power of two that suffices."""
    return _record("memsys", "LocalPatchGeometry", f"memsys.own_patches={max(16, 1 << (patches - 1).bit_length())}")


def _store(frames, requests):
    return _record("memsys", "PatchStore", f"memsys.store_patches={frames} memsys.store_requests={requests}")


def path_area(own: int, *, frames: int, access: Access, clusters: int) -> tuple[int, int] | None:
    """LUTs and block RAMs of a cluster's resident set, patch store, network interface and routers.

    Parameters
    ----------
    own, frames
        Patches of the resident set, and of the store.
    access
        The parts that there are.
    clusters
        Clusters; one has no network.

    Returns
    -------
    tuple or None
        None where a part has not been recorded or does not exist.
    """
    parts, without = [_own(own)], []
    if access.has_store:
        parts.append(_store(frames, _LEAST if access is Access.SINGLE else _REQUESTS))
    if access is Access.BLOCKING:
        without.append(_record("memsys", "DeferredStore"))
    if clusters > 1 and access is not Access.MEMORY:
        parts += [_record("noc", "NetworkInterface"), *[_record("noc", "Router-72-2")] * _ROUTERS]
    if None in parts or None in without:
        return None
    return tuple(sum(getattr(one, name) for one in parts) - sum(getattr(one, name) for one in without)
                 for name in ("lut", "bram"))


def area_table() -> list[str]:
    """Lines: the units that differ, as they were recorded."""
    rows = [[f"`{record.unit}`", record.parameters.replace("memsys.", "") or "paper", record.lut, record.bram,
             record.commit]
            for record in _records().values()
            if record.family == "ecp5" and record.preset == "paper" and record.unit in (
                "LocalPatchGeometry", "PatchStore", "DeferredStore", "NetworkInterface", "Router-72-2")]
    return table(["unit", "parameters", "LUT", "block RAM", "commit"], rows)


def in_blocks(area: tuple[int, int]) -> float:
    """LUTs and block RAMs as block RAMs: a LUT is as scarce as on an ECP5-85."""
    lut, bram = area
    return bram + lut * _BLOCKS / _LUTS


def equal_area_table() -> list[str]:
    """Lines: area of a cluster's memory for all patches, and for a share of them with what fetches the others."""
    rows = []
    for patches in _PATCHES:
        everywhere = path_area(patches, frames=0, access=Access.MEMORY, clusters=1)
        dealt, stored = (path_area(patches // _CLUSTERS, frames=_FRAMES, access=access, clusters=_CLUSTERS)
                         for access in (Access.NETWORK, Access.DEFERRAL))
        rows.append([patches, *everywhere, *dealt, *stored,
                     *(f"{in_blocks(one):.0f}" for one in (everywhere, dealt, stored))])
    share = f"1/{_CLUSTERS} and network"
    return table(["patches", *(f"{memory}: {what}" for memory in ("all", share, "with a store") for what in (
        "LUT", "block RAM")), "all, in block RAMs", share, "with a store"], rows)

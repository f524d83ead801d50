"""Tables of area and clock, unit by unit."""

import importlib
import json
import statistics
from dataclasses import asdict, dataclass
from pathlib import Path

from amaranth.lib import wiring
from amaranth.lib.data import StructLayout

import hw
from golden.engine.config import PRESETS, Config
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from hw.cluster import Cluster
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.survival import Survival
from hw.engine import Engine
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.patches.deferred_store import DeferredStore
from hw.memsys.patches.filter import Filter
from hw.memsys.patches.istructure import IStructure
from hw.memsys.patches.patch_store import PatchStore
from hw.noc.network_interface import NetworkInterface
from hw.noc.router import Router
from hw.registers.engine_registers import ADDRESS_BITS, ENGINE_REGISTERS
from hw.registers.registers import Registers
from radiosity.flow.output import write_text
from radiosity.flow.synthesis.family import FAMILIES, Area
from radiosity.flow.synthesis.flow import (
    OPTIONS,
    Clock,
    place_and_route,
    synthesise,
    synthesise_between_registers,
    tool_versions,
)

__all__ = ["UNITS", "Row", "changed_parameters", "make_unit", "measure", "spread", "table"]


def _router(*, bits, channels, cycles=2):
    """Of an interior node of a mesh, with queues of eight flits."""
    return lambda config: Router(routing=route(Topology("mesh", 8, 8), channels), node=27, bits=bits, depth=8,
                                 router_cycles=cycles)


def _patch_cache(policies):
    """Of records of five beats."""
    return lambda config: Cache(72, beats=5, config=config, lines=config.memsys.patch_lines,
                                key=config.icu.patch_bits, tag=4, policies=policies)


def _filter(config, bits, count):
    """Of numbers of so many bits."""
    return Filter(bits=bits, count=count, generation_bits=config.memsys.filter_generation_bits)


def _survival(config):
    """Of grid rays with nothing else than their stage."""
    formats = CtuFormats(config)
    return Survival(config=config, ray=StructLayout({
        "stage": formats.stage, "ray": formats.grid_number, "shell": formats.shell, "row": formats.grid_row_address,
        "column": formats.grid_column_address}))


HARDWARE = Path(hw.__file__).parent
# The units of each block that are measured alone: what they are made with beside the configuration, if they have the
# name of their class, or else how they are made.
TAG = {"tag": 1}
# Patches of the store where the configuration has none.
STORE = 1024
UNITS = {
    "icu": {
        "IntersectionUnit": {}, "PatchSetup": {}, "G2rTransform": {}, "VertexDirection": {}, "SphericalCoordinates": {},
        "EdgePlanes": {}, "PlaneFactor": {}, "Sbb": {}, "Ipbb": {}, "SectionClip": {}, "InverseDistanceBound": {},
        "PatchSlots": TAG, "IcRayGenerator": {}, "WindowWalk": {}, "RayIssue": {}, "SettleMap": TAG,
        "RayDirection": TAG, "Screening": TAG, "InverseDistance": TAG, "UvAlignment": TAG, "UvSubdivision": TAG,
        "RayMemory": TAG, "ReadOut": {}, "PatchSums": {},
    },
    "ctu": {
        "SubshellGenerator": {}, "CtRayGenerator": {}, "StageRows": {},
        "RowPieces": {}, "RowArcs": {}, "GridDirection": TAG, "TraversalStart": TAG, "CellSteps": TAG,
        "CellNumber": TAG, "CellTraversal": TAG, "Survival": _survival, "NearWindow": TAG, "SettleSweep": {},
        "GridEntries": TAG, "RayTraversal": {}, "TraversalUnit": {},
    },
    "memsys": {
        # A location per grid ray of a shell.
        "IStructure": lambda config: IStructure(18, depth=4096, version_bits=4, deferred=64, tag=20),
        "MainMemoryPort": {"tag": 2}, "PreloadDma": {}, "ResultWriter": {}, "WriteMerge": {"count": 4},
        # Patches, under all placements and without the fully associative one.
        "PatchCache": _patch_cache(tuple(CachePolicy)),
        "PatchCache-sets": _patch_cache((CachePolicy.DIRECT, CachePolicy.LRU)),
        "MemorySystem": {}, "PatchNode": {},
        "CellFilter": lambda config: _filter(config, 24, config.memsys.scene_cells),
        "PatchFilter": lambda config: _filter(config, config.icu.patch_bits + 1, 1 << config.icu.patch_bits),
        "CellTable": {}, "PatchTable": {}, "PatchTypeMemory": {}, "LocalPatchGeometry": {}, "VertexMerge": {"count": 3},
        "LocalBusInterface": {}, "LocalBus": {"clusters": 2}, "CellFetch": {}, "PatchFetch": {},
        "SystemBusInterface": {}, "PatchStore": lambda config: PatchStore(
            config=config, frames=config.memsys.store_patches or STORE, requests=config.memsys.store_requests),
        # That of a patch store, whose I-structure keeps two bits of a patch.
        "DeferredStore": lambda config: DeferredStore(
            2, depth=config.memsys.store_requests, tag=range(config.memsys.store_requests)),
    },
    "control": {
        "JobControl": {}, "DescriptorFetch": {}, "DescriptorCheck": {}, "JobDispatch": {}, "CompletionWriter": {},
        "LoadControl": {}, "FrustumLoad": {}, "FrustumSlot": {}, "NearCellBanks": {}, "SectionCast": {},
        "SectionResults": {},
    },
    "cluster": {"Cluster": lambda config: Cluster(config=config)},
    # All clusters and what is between them and the pins, with the configuration's own cache policy.
    "engine": {"Engine": lambda config: Engine(
        config=config, policies=(CachePolicy[config.memsys.cache_policy.upper()],))},
    "registers": {"Registers": lambda config: Registers(
        ENGINE_REGISTERS, address_bits=ADDRESS_BITS, memory_bits=config.memory.address_bits)},
    # By bits of a flit, channels, and cycles of a router if one.
    "noc": {f"Router-{bits}-{channels}": _router(bits=bits, channels=channels)
            for bits in (32, 72) for channels in (1, 2, 4)} | {
        "Router-32-1-1": _router(bits=32, channels=1, cycles=1), "NetworkInterface": lambda config: NetworkInterface(
            config=config, routing=route(config.noc.network(), config.noc.virtual_channels), node=0),
        # Routers, links and interfaces of all clusters.
        "PatchNetwork": {}},
}


@dataclass(frozen=True, kw_only=True)
class Row:
    """One unit's figures: a clock for each seed."""

    unit: str
    latency: int | None
    area: Area
    clocks: tuple[Clock, ...]


def make_unit(block: str, unit: str, config: Config) -> wiring.Component:
    """One of `UNITS`."""
    arguments = UNITS[block][unit]
    if callable(arguments):
        return arguments(config)
    module = "".join("_" + letter.lower() if letter.isupper() else letter for letter in unit).lstrip("_")
    path, = (HARDWARE / block).rglob(f"{module}.py")
    name = ".".join(path.relative_to(HARDWARE.parent).with_suffix("").parts)
    return getattr(importlib.import_module(name), unit)(config=config, **arguments)


def measure(block: str, unit: str, config: Config, folder: Path, *, family: str = "ecp5", seeds: tuple[int, ...] = (),
            options: tuple[str, ...] = OPTIONS, routability_driven: bool = False) -> Row:
    """Synthesise one of `UNITS`, and place and route it once for each seed, as `place_and_route` does."""
    folder = folder / unit
    clocks = ()
    if seeds:
        netlist = synthesise_between_registers(make_unit(block, unit, config), folder)
        clocks = tuple(place_and_route(netlist, seed=seed, options=options, routability_driven=routability_driven)
                       for seed in seeds)
    component = make_unit(block, unit, config)
    row = Row(unit=unit, latency=getattr(component, "latency", None),
              area=synthesise(component, folder, family=FAMILIES[family]), clocks=clocks)
    write_text(folder / "row.json", json.dumps(asdict(row), indent=1) + "\n")
    return row


def table(rows: list[Row], *, block: str, preset: str, config: Config, family: str, seeds: tuple[int, ...],
          options: tuple[str, ...], routability_driven: bool = False) -> str:
    """The figures as Markdown, with all that is needed to get them again."""
    several = " least / median / best" if len(seeds) > 1 else ""
    titles = ["unit", "latency", "LUT", "FF", "DSP", "block RAM"]
    titles += ["LUT folded"] if family == "ecp5" else []
    if seeds:
        titles += [f"Fmax (MHz){several}", f"Fmax on grade 8 (MHz){several}",
                   "critical path" + (" of the best" if several else "")]
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    for row in rows:
        area = row.area
        cells = [row.unit, "" if row.latency is None else row.latency, area.lut, area.ff, area.dsp, area.bram]
        cells += [area.folded] if family == "ecp5" else []
        if row.clocks:
            best = max(row.clocks, key=lambda clock: clock.mhz)
            whose = f" (seed {best.seed})" if several else ""
            cells += [spread(clock.mhz for clock in row.clocks), spread(clock.mhz_grade_8 for clock in row.clocks),
                      best.path + whose]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    about = [tool_versions(clock=FAMILIES[family].has_clock)]
    about += [f"placer seed{'s' if several else ''} {', '.join(map(str, seeds))}, "
              f"{' '.join(options) or 'no options'}"] if seeds else []
    about += ["routability-driven routing"] if routability_driven else []
    return "\n".join([f"# {block}: {FAMILIES[family].title}", "", *lines, "", FAMILIES[family].counted, "",
                      f"{'; '.join(about)}; preset {preset}{changed_parameters(config, PRESETS[preset])}.", ""])


def changed_parameters(config: Config, usual: Config) -> str:
    """The parameters that differ from the usual ones as `` PATH=VALUE`` each."""
    expected = usual.parameters()
    return "".join(f" {path}={value}" for path, value in config.parameters().items() if value != expected[path])


def spread(clocks, *, digits: int = 0) -> str:
    """Clocks of several seeds in MHz, least, median and best; one alone is itself. ``digits`` follow the point."""
    clocks = sorted(clocks)
    shown = clocks if len(clocks) == 1 else [clocks[0], statistics.median(clocks), clocks[-1]]
    return " / ".join(f"{mhz:.{digits}f}" for mhz in shown)

"""A job: loads and sections of frusta in the order of the queue, and where everything is in main memory."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from golden.base.errors import InputError, check_int
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.capacities import check_capacities
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import (
    ANY_CLUSTER,
    DESCRIPTOR,
    check_descriptor,
    frustum_descriptor,
    load_descriptor,
    near_bytes,
)
from golden.engine.jobs.load_regions import region_bits
from golden.engine.jobs.order import long_and_short, longest_first_at_the_end, proximity_order
from golden.engine.jobs.result_formats import (
    HitFormat,
    bit_words,
    check_config,
    scatter_sums,
    unpack_bits,
    unpack_hits,
    unpack_ids,
)
from golden.engine.jobs.tile_sections import halves, tile_sections
from golden.engine.memory_map import MemoryImage, phase_image
from golden.engine.memory_map.image_layout import aligned
from golden.engine.memory_map.layout import REGIONS
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cycle_model import least_cycles
from golden.engine.schedule.phase import Schedule

__all__ = ["HeldTables", "Job", "JobPhase", "JobSection", "PhaseRequest", "Read", "plan_job"]

# The field is of 5 bits; numbers of descriptors are of 32.
_MOST_RING_BITS = 31
# Tables of which those of fewer shells are the beginning.
_GRID = ("shells", "grid_rows", "grid_columns")
_SCENE = tuple(region.name for region in REGIONS if region.life == "scene")
# Sections of less than so many times the cycles of the patches alone are not cut at the end of a phase: each half
# may find all patches.
_CUT_CYCLES = 3
# Reads bytes of main memory: their address and number.
Read = Callable[[int, int], bytes]


@dataclass(frozen=True, kw_only=True, eq=False)
class PhaseRequest:
    """What the host requests of the frusta of a phase.

    Parameters
    ----------
    geometry, table
        Patches and cells of the scene.
    records
        The frusta, all of the same kind and rays.
    weights
        ``rows`` int64, weight of one ray of each row; 0 by default.
    hit_format, sums
        The results; of shadow frusta a bit for each listed ray is written in place of them.
    clusters
        Clusters for each frustum, a power of two: 1 for the shortest job, more for the shortest frustum.
    cycles
        Predicted cycles of each frustum. Default: the same for all.
    workload
        rows x columns float64, the expected work of each ray of a frustum. Default: the same for all.
    plan
        The schedule that resident sets and subshell lists are from, see `phase_image`. With subshell lists
        (``ctu.subshell_bits``) its sections are those of every frustum, each for its own cluster.
    windows
        Of each frustum the sections that are cast, which begin at borders of tiles; hits of its other rays are not
        written. Not with subshell lists. Default: sections of all rays.
    """

    geometry: PatchGeometry
    table: CellTable
    records: Sequence[FrustumRecord]
    weights: np.ndarray | None = None
    hit_format: HitFormat = HitFormat.NONE
    sums: bool = False
    clusters: int = 1
    cycles: Sequence[float] | None = None
    workload: np.ndarray | None = None
    plan: Schedule | None = None
    windows: Sequence[Sequence[Sector]] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class JobPhase:
    """A phase, and where it is in main memory.

    Parameters
    ----------
    request
        What the host requests.
    image, address
        The image of the phase, and its first byte.
    hits, near_cells
        Of each frustum: addresses of its hits (0 without hits) and of its `near_bytes`. None of shadow frusta: each
        section has its own.
    """

    request: PhaseRequest
    image: MemoryImage
    address: int
    hits: tuple[int, ...]
    near_cells: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class JobSection:
    """A section in the queue.

    Parameters
    ----------
    phase, frustum
        Numbers of the phase in the job and of the frustum in the phase.
    section
        Its rays.
    cycles
        Its share of the frustum's predicted cycles.
    cluster
        The cluster that must take it, or `ANY_CLUSTER`.
    """

    phase: int
    frustum: int
    section: Sector
    cycles: float
    cluster: int = ANY_CLUSTER


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldTables:
    """What a machine holds after a job.

    Parameters
    ----------
    tables
        The records loaded, by region.
    begin, end
        Main memory that it reads cells and patches from: begin <= address < end.
    """

    tables: Mapping[str, np.ndarray] = field(default_factory=dict)
    begin: int = 0
    end: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """Descriptors in the order of the queue, and what they need in main memory.

    Parameters
    ----------
    config
        The machine's configuration.
    phases
        The phases in their order.
    descriptors
        D records of `DESCRIPTOR`; the tag of each is its number.
    sections
        Of each descriptor the section, or None of a load.
    ring, completions, ring_bits
        Addresses of the two rings, and the binary logarithm of their entries.
    base, end
        Main memory that the job uses: base <= address < end.
    held
        What the machine holds after the job.
    """

    config: Config
    phases: tuple[JobPhase, ...]
    descriptors: np.ndarray
    sections: tuple[JobSection | None, ...]
    ring: int
    completions: int
    ring_bits: int
    base: int
    end: int
    held: HeldTables

    def entry(self, number: int) -> int:
        """Address of the descriptor ``number``: that of the one 2^``ring_bits`` before, which must have been taken."""
        return self.ring + number % (1 << self.ring_bits) * DESCRIPTOR.dtype.itemsize

    def completion(self, number: int) -> int:
        """Address of the completion record that has ``number`` others before it."""
        return self.completions + number % (1 << self.ring_bits) * COMPLETION.dtype.itemsize

    def tables(self) -> dict[int, bytes]:
        """What the host writes before the first descriptor: bytes by the address of the first of them."""
        written = {}
        for phase in self.phases:
            written[phase.address] = phase.image.to_bytes()
        # Sections of a frustum have the same address, except in shadow frusta; so may what has no bytes.
        near = {(one.phase, one.frustum, address): one.section for one, address in zip(
            self.sections, self.descriptors["near_cells"].tolist(), strict=True) if one is not None}
        for (phase, frustum, address), section in near.items():
            request = self.phases[phase].request
            if data := near_bytes(request.records[frustum], request.table, section):
                written[address] = data
        return written

    def numbers(self, phase: int, frustum: int) -> list[int]:
        """Numbers of the descriptors of a frustum's sections."""
        return [number for number, one in enumerate(self.sections)
                if one is not None and (one.phase, one.frustum) == (phase, frustum)]

    def name(self, number: int) -> str:
        """What a descriptor is, for messages."""
        one = self.sections[number]
        phase = f" of phase {one.phase}" if one and len(self.phases) > 1 else ""
        return "load of tables" if one is None else (
            f"frustum {one.frustum}{phase}, columns {one.section.first_column} to {one.section.end_column - 1}, "
            f"rows {one.section.first_row} to {one.section.end_row - 1}")

    def hits(self, phase: int, frustum: int, read: Read) -> FixedHits | np.ndarray:
        """The hits of a frustum in main memory, when all its sections are complete; of ids, its patches alone."""
        given = self.phases[phase].request
        data = read(self.phases[phase].hits[frustum], len(given.records[frustum]) * given.hit_format.bytes)
        return unpack_ids(data) if given.hit_format == HitFormat.IDS else unpack_hits(data, given.hit_format)

    def blocked(self, phase: int, frustum: int, read: Read, *, numbers: Sequence[int] | None = None) -> np.ndarray:
        """Whether each ray of a shadow frustum is blocked, by main memory, when all its sections are complete: R bool.

        Parameters
        ----------
        phase, frustum, read, numbers
            As of `sums`.
        """
        record = self.phases[phase].request.records[frustum]
        blocked = np.zeros(len(record), dtype=bool)
        for number in self.numbers(phase, frustum) if numbers is None else numbers:
            rays, address = self.sections[number].section.among(record.listed, record), self.descriptors["hits"][number]
            blocked[rays] = unpack_bits(read(int(address), 8 * bit_words(len(rays))), len(rays))
        return blocked

    def sums(self, phase: int, frustum: int, read: Read, words: Mapping[int, int], *,
             numbers: Sequence[int] | None = None) -> np.ndarray:
        """The sums of a frustum in main memory, when all its sections are complete: N int64.

        Parameters
        ----------
        phase, frustum
            Their numbers.
        read
            Reads main memory.
        words
            Words of sums by tag, from the completion records.
        numbers
            `numbers` of the frustum, where they are known.
        """
        numbers = self.numbers(phase, frustum) if numbers is None else numbers
        parts = [np.frombuffer(read(int(self.descriptors["sums_address"][number]), 8 * words[number]), dtype="<u8")
                 for number in numbers]
        return scatter_sums(parts, len(self.phases[phase].request.geometry))


def plan_job(requests: Sequence[PhaseRequest], config: Config, *, ring_bits: int = 6, base: int = 0,
             held: HeldTables | None = None) -> Job:
    """A job of the phases in their order.

    Each phase begins with a load of what the machine does not hold, if there is any: once for all clusters if all of
    them hold the same patches. Of another scene all tables are loaded, since cells and patches are read from one image.
    Its frusta follow in an order in which neighbours are near each other (`proximity_order`), and at its end the
    longest sections are first (`longest_first_at_the_end`). Where every cluster holds all patches and cycles are
    predicted, `long_and_short` sections alternate instead, and the last one for each cluster is cut in two, unless its
    patches take a third of its cycles or more: clusters end closer together, and the results of the last sections need
    half the cycles. Sections of a shadow frustum that have none of its rays are left out.

    Parameters
    ----------
    requests
        The phases.
    config
        The machine's configuration.
    ring_bits
        Binary logarithm of the entries of the rings, 0 to 31.
    base
        First byte of main memory for the job, rounded up to a multiple of 64.
    held
        What the machine holds before the job, `Job.held` of the one before; the job leaves that part of main memory as
        it is. Default: nothing.

    Raises
    ------
    InputError
        The machine cannot cast a frustum or write its results, or its tables do not fit an image.
    TypeError
        ``ring_bits`` or ``base`` is no int.
    """
    for name, value, most in ("Ring bits", ring_bits, _MOST_RING_BITS), ("Base", base, None):
        check_int(f"job: {name}", value)
        if value < 0 or (most is not None and value > most):
            raise InputError(f"job: {name} must be {'at least 0' if most is None else f'0 to {most}'}, not {value}")
    held = held or HeldTables()
    memory = _Memory(base, held)
    ring = memory.take(DESCRIPTOR.dtype.itemsize << ring_bits)
    completions = memory.take(COMPLETION.dtype.itemsize << ring_bits)
    phases, sections, descriptors, first = [], [], [], min(ring, held.begin) if held.tables else ring
    for number, request in enumerate(requests):
        check_config(config, request.hit_format, sums=request.sums)
        phase = _phase(request, config, memory)
        phases.append(phase)
        loaded = _loaded(held.tables, phase.image)
        if loaded:
            held = _held_after(held, phase, loaded)
            sections.append(None)
            descriptors.append(load_descriptor(phase.address, _load_bits(loaded), tag=len(descriptors),
                                               copies=phase.image.has_copies))
        for one in _sections(phase, number, config):
            sections.append(one)
            descriptors.append(_descriptor(one, phase, memory, tag=len(descriptors)))
    for descriptor in descriptors:
        refusal = check_descriptor(descriptor, config)
        if refusal:
            raise InputError(f"job: {refusal.reason}")
    return Job(config=config, phases=tuple(phases), descriptors=np.array(descriptors, dtype=DESCRIPTOR.dtype),
               sections=tuple(sections), ring=ring, completions=completions, ring_bits=ring_bits, base=first,
               end=max(memory.end, held.end), held=held)


class _Memory:
    """Main memory, taken from the bottom up in multiples of 64 bytes, around what is held there."""

    def __init__(self, base, held):
        self.end, self._held = aligned(base), held

    def take(self, size):
        """Address of so many bytes."""
        if self.end < self._held.end and self.end + aligned(size) > self._held.begin:
            self.end = aligned(self._held.end)
        address = self.end
        self.end += aligned(size)
        return address


def _phase(request, config, memory):
    table = request.table
    image = phase_image(request.records, request.geometry, table, config, weights=request.weights, plan=request.plan)
    check_capacities(image, config)
    size, records = request.hit_format.bytes, () if _is_shadow(request) else request.records
    whole = Sector.whole(request.records[0])
    return JobPhase(
        request=request, image=image, address=memory.take(image.size),
        near_cells=tuple(memory.take(len(near_bytes(record, table, whole))) for record in records),
        hits=tuple(memory.take(size * len(record)) if size else 0 for record in records))


def _is_shadow(request):
    return request.records[0].bundle == Bundle.SHADOW


def _listed(request, frustum, section):
    """How many rays of a shadow frustum are in the list of a section."""
    record = request.records[frustum]
    return len(section.among(record.listed, record))


def _has_rays(request, frustum, section):
    return not _is_shadow(request) or _listed(request, frustum, section) > 0


def _loaded(held, image):
    """The regions of an image that have to be loaded; of the scene all or none."""
    missing = [name for name in image.regions if not _holds(held, image, name)]
    return [*image.regions] if {*missing} & {*_SCENE} else missing


def _held_after(held, phase, loaded):
    """What the machine holds after a load."""
    tables = {**held.tables, **{name: phase.image[name] for name in loaded}}
    begin, end = held.begin, held.end
    if {*loaded} & {*_SCENE}:
        begin, end = phase.address, phase.address + phase.image.size
    return HeldTables(tables=tables, begin=begin, end=end)


def _holds(held, image, name):
    """Whether the machine has the region of an image: grid rays of more shells serve for fewer."""
    records = image[name]
    return name in held and np.array_equal(held[name][:len(records)] if name in _GRID else held[name], records)


def _load_bits(names):
    """The bits of a load of these regions: that of `patches` reads the residents of each cluster."""
    names = {"patches" if name in ("residents", "clusters") else name for name in names} | {*names} - {"residents"}
    return region_bits(*names)


def _sections(phase, number, config):
    """The sections of a phase in the order of the queue."""
    request = phase.request
    pinned = config.ctu.subshells > 0 and request.plan is not None
    if request.windows is None:
        cut = request.plan.partition.sections if pinned else tile_sections(
            request.records[0].columns, request.records[0].rows, config, clusters=request.clusters,
            workload=request.workload)
        parts = [[*zip(cut, _shares(cut, request.workload), strict=True)]] * len(request.records)
    else:
        parts = [zip(cut, _shares(cut), strict=True) for cut in request.windows]
    cycles = np.ones(len(request.records)) if request.cycles is None else np.asarray(request.cycles)
    if len(cycles) != len(request.records):
        raise InputError(f"job: Predicted cycles must be one for each of {len(request.records)} frusta, "
                         f"not {len(cycles)}")
    listed = [JobSection(phase=number, frustum=int(frustum), section=section, cycles=float(cycles[frustum] * part),
                         cluster=cluster if pinned else ANY_CLUSTER)
              for frustum in proximity_order(np.array([record.origin for record in request.records]))
              for cluster, (section, part) in enumerate(parts[frustum])
              if _has_rays(request, frustum, section)]
    predicted = np.array([one.cycles for one in listed])
    if request.cycles is None or pinned or not phase.image.has_copies:
        return [listed[one] for one in longest_first_at_the_end(predicted, clusters=config.noc.clusters)]
    ordered = [listed[one] for one in long_and_short(predicted)]
    if config.noc.clusters == 1:
        return ordered
    # The last section for each cluster in halves, the longest ones first.
    first, least = max(0, len(ordered) - config.noc.clusters), _CUT_CYCLES * least_cycles(len(request.geometry))
    end = [half for one in ordered[first:] for half in (_halves(one, config) if one.cycles >= least else [one])
           if _has_rays(request, half.frustum, half.section)]
    return ordered[:first] + sorted(end, key=lambda one: -one.cycles)


def _shares(cut, workload=None):
    """The share of each section in the work of a frustum, whose rays are all the same work by default."""
    work = np.array([one.rays if workload is None else workload[
        one.first_row:one.end_row, one.first_column:one.end_column].sum() for one in cut])
    return work / work.sum() if work.any() else np.full(len(cut), 1 / max(1, len(cut)))


def _halves(one, config):
    return [replace(one, section=part, cycles=one.cycles * part.rays / one.section.rays)
            for part in halves(one.section, config)]


def _descriptor(one, phase, memory, *, tag):
    request = phase.request
    record, section = request.records[one.frustum], one.section
    if _is_shadow(request):
        near = memory.take(len(near_bytes(record, request.table, section)))
        hits = memory.take(8 * bit_words(_listed(request, one.frustum, section)))
    else:
        near, hits = phase.near_cells[one.frustum], phase.hits[one.frustum]
    # A patch has a word only if a ray hits it.
    sums_address = memory.take(8 * min(section.rays, len(request.geometry))) if request.sums else 0
    return frustum_descriptor(
        record, request.table, section=section, tag=tag, hit_format=request.hit_format, sums=request.sums,
        cluster=one.cluster, hits=hits, sums_address=sums_address, near_cells_address=near)

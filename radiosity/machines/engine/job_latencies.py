"""Latencies and capacities of what is between the casts of a job, from the components."""

from golden.engine.config import Config
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.engine.noc.packing import VERTICES, reply_flits, request_flits
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from hw.control.completion_writer import CompletionWriter
from hw.control.frustum_slot import FrustumSlot
from hw.control.job_dispatch import JobDispatch
from hw.control.section_results import SectionResults
from hw.icu.patch_sums import SETTLED, PatchSums
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.lfu_placement import LfuPlacement
from hw.memsys.bus.local_bus import LocalBus
from hw.memsys.bus.patch_fetch import PatchFetch
from hw.memsys.bus.set_placement import SetPlacement
from hw.memsys.load.image_layout import PATCH_WORDS
from hw.memsys.load.patch_extents import PatchExtents
from hw.memsys.load.preload_dma import PreloadDma
from hw.memsys.load.record_extent import RecordExtent
from hw.memsys.patches.local_bus_interface import LocalBusInterface
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from hw.memsys.patches.patch_merge import PatchMerge
from hw.memsys.patches.patch_store import PatchStore
from hw.memsys.patches.patch_type_memory import PatchTypeMemory
from hw.memsys.patches.path_formats import BEATS
from hw.memsys.patches.vertex_merge import VertexMerge
from hw.memsys.port.beat_writer import DEPTH, GROUP_BITS, BeatWriter
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.memsys.port.read_engine import ReadEngine
from hw.memsys.port.read_share import ReadShare
from hw.memsys.port.word_reader import WordReader
from hw.memsys.port.write_engine import WriteEngine
from hw.memsys.port.write_merge import WriteMerge
from hw.memsys.results.result_packer import ResultPacker
from radiosity.machines.engine.bus_path import BusTiming
from radiosity.machines.engine.job_timing import JobTiming
from radiosity.machines.engine.joint_cast import JointTiming
from radiosity.machines.engine.load_cycles import LoadTiming
from radiosity.machines.engine.store_path import StoreTiming

__all__ = ["bus_timing", "job_timing", "joint_options", "joint_timing", "load_timing", "store_timing"]

# Of docstrings that have no attribute: `JobDispatch`'s cycles of a section without near cells, `ReadOut`'s latency,
# `ResultWriter`'s cycles from the last answer to its `o_done`.
_SECTION, _READ_OUT, _DONE = 26, 9, 2
# `SectionCast`: a section begins a cycle after the acceptance of the results before it, whose cast counts no cycle for
# its begin; it is known a cycle after it is in the slot.
_RESTART, _KNOWN = 2, 1
# States of `PreloadDma` before the records of a region and before patches are requested, and of `ImageHeader` for the
# check of a region.
_CHOOSE, _CHECK = 2, 2
# `NetworkInterface`: from a request, or a vertex, to the link, and from the link of a vertex to the vertex.
_TO_LINK, _FROM_LINK = 1, 2
# `Cache`: from a lookup to its answer, and from there to the record; between them a fetch. `SystemBusInterface`: a
# register in front of its fills.
_ANSWER, _RECORD, _FILL = 1, 3, 1
# `PatchStore`: from a request to its fetch, and to the next request; a fetched vertex waits for the entry of its patch;
# from the last one in its frame to the `IStructure`, in there from the write to the answer, and to the first vertex.
# `SkidBuffer`: its entries.
_LOOKUP, _ENTRY, _FILLED, _RELEASED, _FRAME, _SKIDS = 3, 1, 1, 8, 2, 2
_WORD_BITS = 64


def job_timing(config: Config, *, latency: int) -> JobTiming:
    """The timing of the engine of a configuration.

    Parameters
    ----------
    config
        The configuration.
    latency
        Cycles of main memory.
    """
    packer, writer = ResultPacker(config=config, group_bits=GROUP_BITS), BeatWriter(config=config)
    merge, engine = WriteMerge(config=config, count=config.noc.clusters + 1), WriteEngine(config=config, tag=1)
    port = MainMemoryPort(config=config, tag=1)
    return JobTiming(
        first=JobDispatch.latency, dispatch=JobDispatch.latency + _SECTION, slot=FrustumSlot.latency + _KNOWN,
        restart=_RESTART, read_out=_READ_OUT, sums=SETTLED + 1 + PatchSums(config=config).latency,
        answer=packer.latency + writer.latency + merge.latency + port.latency + latency + engine.latency + 1 + _DONE,
        report=SectionResults.latency + CompletionWriter.latency, beats=1 << GROUP_BITS, buffers=DEPTH >> GROUP_BITS)


def load_timing(config: Config, *, latency: int) -> LoadTiming:
    """The timing of the loads of a configuration, see `job_timing`."""
    reader = WordReader(config=config).latency + MainMemoryPort(config=config, tag=1).latency + latency + ReadEngine(
        config=config, tag=1).latency + PreloadDma(config=config).latency
    patches = PatchExtents(config=config)
    return LoadTiming(
        trip=_CHOOSE + RecordExtent(config=config).latency + reader, check=_CHECK,
        extents=_CHOOSE + patches.latency + reader, patch_words=PATCH_WORDS, group=1 << patches.index_bits,
        burst=config.memory.burst_beats * config.memory.data_bits // 8, end=PreloadDma(config=config).latency)


def joint_timing(config: Config) -> JointTiming:
    """The timing of the path to patches of other clusters."""
    merge = VertexMerge(config=config, count=2).latency
    own, served = _own(config), (
        PatchTypeMemory(config=config).latency + LocalPatchGeometry(config=config).latency + _TO_LINK)
    vertices = [(0, 0, 0)] * VERTICES
    return JointTiming(
        request=_TO_LINK, serve=max(1, served - own), port=VERTICES, reply=_FROM_LINK + merge,
        request_flits=len(request_flits(config, source=0, destination=0, patch=0)),
        reply_flits=len(reply_flits(config, source=0, destination=0, patch=0, surface=0, vertices=vertices)),
        outstanding=config.noc.requests)


def joint_options(config: Config) -> dict:
    """What `radiosity.machines.engine.joint_cast.joint_cast` takes of a configuration beside times.

    The network of one cluster carries nothing.
    """
    noc = config.noc
    topology = noc.network() if noc.nodes > 1 else Topology("mesh", 2, 1)
    return {"routing": route(topology, noc.virtual_channels), "buffer_flits": noc.buffer_flits,
            "arbitration": noc.arbitration, "router_cycles": noc.router_cycles, "slots": config.icu.slots,
            "run_ahead": config.ctu.run_ahead, "memsys": config.memsys}


def bus_timing(config: Config, *, latency: int) -> BusTiming:
    """The timing of the path to patches that no cluster holds, see `job_timing`."""
    memsys = config.memsys
    is_lfu = memsys.cache_policy == CachePolicy.LFU.name.lower()
    placement = (LfuPlacement if is_lfu else SetPlacement).latency + _ANSWER
    bus = LocalBus.latency
    # From the record to its last vertex, beyond what an own patch takes.
    reply = BEATS - 1 + bus + LocalBusInterface.latency + VertexMerge(config=config, count=2).latency - _own(config)
    # A burst is read when all of it has come.
    beats = -(-PATCH_WORDS * _WORD_BITS // config.memory.data_bits)
    record = (PatchFetch.latency + ReadShare.latency + WordReader(config=config).latency
              + MainMemoryPort(config=config, tag=1).latency + latency + beats - 1
              + ReadEngine(config=config, tag=1).latency + PATCH_WORDS - 1 + _FILL + _RECORD)
    return BusTiming(
        request=LocalBusInterface.latency, hit=bus + placement + _RECORD + reply,
        fetch=bus + placement + record + reply, next_fetch=record, words=PATCH_WORDS, beats=BEATS,
        outstanding=memsys.bus_requests, fetches=memsys.cache_fetches, requests=Cache.capacity)


def store_timing(config: Config) -> StoreTiming:
    """The timing of the path through a patch store."""
    passed = PatchMerge.latency + _ENTRY
    # The vertices come into the frame, and leave it one after the other.
    return StoreTiming(
        lookup=_LOOKUP, kept=PatchStore.latency - LocalPatchGeometry(config=config).latency, passed=passed,
        stored=passed + _FILLED + _RELEASED + _FRAME + VERTICES - 1, vertices=VERTICES, waiting=_SKIDS,
        requests=config.memsys.store_requests)


def _own(config):
    """What an own patch takes from its lookup on: all of its vertices are there before the first one leaves."""
    return LocalPatchGeometry(config=config).latency + VERTICES + VertexMerge(config=config, count=2).latency

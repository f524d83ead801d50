"""Jobs on the exported engine: every byte of main memory, a completion record for each descriptor, and counters."""

from itertools import combinations

import numpy as np
import pytest

from golden.engine.cast.shelling import Shelling
from golden.engine.jobs.completion import patch_sources
from golden.engine.jobs.descriptor import Kind
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.memory_map.layout import EVERY_CLUSTER, NONE
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.reference_strings import ReferenceStrings
from hw.control.section_results import COUNTS
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.load.image_layout import PATCH_WORDS
from radiosity.flow.host import POLL
from radiosity.machines.engine.store_path import store_after
from tb.system.job_machine import CLUSTERS, CONFIGS, JobMachine, cornell, planned
from tb.system.job_memory import JobMemory
from tb.system.scenes import phase

# Cycles from the end of a cast to the beginning of the next one, of sections that wait.
GAP = 40
CACHES = "cell_hits", "cell_misses", "patch_hits", "patch_misses"


def casts(machine, records):
    """Completion records of sections, in the order in which they began."""
    found = records[machine.job.descriptors["kind"][records["tag"]] == Kind.FRUSTUM]
    return found[np.argsort(found["begin"])]


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_sections_follow_each_other_without_a_gap(clusters):
    with JobMachine(planned(clusters, cornell(clusters, points=(5, 6, 9, 10, 0, 3)))) as machine:
        found = casts(machine, machine.right())
        assert {*found["cluster"]} == {*range(clusters)}, "each cluster takes its share"
        for cluster in range(clusters):
            own = found[found["cluster"] == cluster]
            gaps = own["begin"][1:].astype(int) - own["begin"][:-1] - own["cycles"][:-1]
            assert (gaps <= GAP).all(), f"gaps of cluster {cluster}: {gaps.tolist()}"
            assert (own["end"].astype(int) - own["begin"] >= own["cycles"]).all()


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("memory", [
    pytest.param({"latency": 1}, id="near"),
    pytest.param({"latency": 10, "spread": 30, "shuffles": True, "seed": 5}, id="far"),
    pytest.param({"latency": 4 * POLL}, id="slow", marks=pytest.mark.sim)])
def test_phases_change_in_the_queue(clusters, memory):
    """Scenes, cells, rays, resident sets and formats; in a ring that is shorter than the job."""
    config = CONFIGS[clusters]
    job = planned(
        clusters, cornell(clusters, points=(5, 6, 9)), cornell(clusters, points=(1,), sets="scheduled"),
        cornell(clusters, pixels=(30, 19), sets=()), cornell(clusters, pixels=(9, 33), hit_format=HitFormat.IDS),
        cornell(clusters, points=(3, 4, 2), rays=(16, 8), cell=0.5, hit_format=HitFormat.COMPACT),
        phase("furnace:1", config, cell=0.5, points=(0, 1, 2), rays=(16, 16)),
        cornell(clusters, points=(7, 8), hit_format=HitFormat.NONE), ring_bits=2)
    assert EVERY_CLUSTER in job.phases[5].image["residence"]["cluster"]
    with JobMachine(job, **memory) as machine:
        machine.right()


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_frusta_of_several_sections(clusters):
    """One is cut for four clusters, the other one because it is larger than a ray memory."""
    few, many = cornell(clusters, points=(5, 6), clusters=4), cornell(clusters, points=(5,), rays=(64, 32))
    with JobMachine(planned(clusters, few, many)) as machine:
        job = machine.job
        assert [len(job.numbers(*one)) for one in ((0, 0), (0, 1), (1, 0))] == [4, 4, 2]
        words = {int(one["tag"]): int(one["sums"]) for one in machine.right()}
        for number, request in enumerate((few, many)):
            hits = job.hits(number, 0, machine.read)
            weights = np.repeat(request.weights, request.records[0].columns) * (hits.patch >= 0)
            sums = np.bincount(np.maximum(hits.patch, 0), minlength=len(request.geometry), weights=weights)
            assert job.sums(number, 0, machine.read, words).tolist() == sums.astype(np.int64).tolist()


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_moved_vertex_is_seen(clusters):
    """The comparisons do not pass with anything but the job's results."""
    with JobMachine(planned(clusters, cornell(clusters))) as machine:
        machine.begin()
        moved = machine.job.phases[0].image
        patches = moved["patches"].copy()
        patches["vertex"][:, 0] ^= 1 << 20
        machine.write(machine.job.phases[0].address + moved.offsets["patches"], patches.tobytes())
        records = machine.run()
        with pytest.raises(AssertionError, match=r"words of sums|bytes of main memory are wrong"):
            machine.check(records)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_scene_is_read_where_it_was_loaded_from(clusters):
    """A phase of other rays, from another image, leaves the scene's address and the caches alone."""
    job = planned(clusters, cornell(clusters), cornell(clusters, rays=(16, 8)))
    loads = np.flatnonzero(job.descriptors["kind"] == Kind.LOAD)
    with JobMachine(job) as machine:
        machine.begin()
        image, address = job.phases[1].image, job.phases[1].address
        for region in "cells", "patch_lists", "patches":
            machine.write(address + image.offsets[region], bytes(image[region].nbytes))
        host, first = machine.host, int(loads[1])
        machine(host.submit(job, job.descriptors[:first]))
        machine.until("busy")
        records = [*machine(host.collect(job))]
        counted = [machine(host.read(name)) for name in CACHES]
        assert any(counted)
        machine(host.submit(job, job.descriptors[first:first + 1]))
        machine.until("busy")
        assert [machine(host.read(name)) for name in CACHES] == counted
        machine(host.submit(job, job.descriptors[first + 1:]))
        machine.until("busy")
        machine.check(np.array([*records, *machine(host.collect(job))]))


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_counters_of_each_cluster(clusters):
    """Records agree with the counters, with the shared ones, and with where the patches are."""
    for home in None, *range(clusters):
        held = [range(10) if cluster == home else () for cluster in range(clusters)]
        job = planned(clusters, cornell(clusters, points=(5, 1, 2, 6), cell=0.2, sets=held))
        job.descriptors["cluster"][1:] = np.arange(4) % clusters
        with JobMachine(job, latency=5) as machine:
            found = casts(machine, machine.right())
            counters = machine(machine.host.counters())
            shared = {name: machine(machine.host.read(name)) for name in ("flits", *CACHES)}
        for cluster, one in enumerate(counters):
            mine = found[found["cluster"] == cluster]
            assert len(mine) == 4 // clusters
            names = {"tested": "intersection_tested", "visited": "intersection_visited", "steps": "traversal_steps",
                     **{name: f"memory_{name}" for name in COUNTS[3:]}, "cycles": "cycles"}
            # The counters are those of the last cast.
            assert [mine[-1][name] for name in names] == [one[counter] for counter in names.values()]
            assert one["memory_found"] == one["intersection_patches"] > 0
            assert one["intersection_won"] <= one["intersection_inside"] <= one["intersection_tested"]
            assert one["memory_opened"] > 0
            assert ((mine["own"] > 0) == (cluster == home)).all()
            assert ((mine["remote"] > 0) == (home not in (None, cluster))).all()
            assert one["memory_answered"] == (found["remote"].sum() if cluster == home else 0)
            # The store is empty when the first section begins.
            kept = patch_sources(mine)["kept"]
            assert kept[0] == 0
            assert (kept[1:] > 0).all()
            assert one["memory_deferred"] > 0
        for name in "tested", "visited", "steps", "cycles":
            assert (found[name] > 0).all()
        for name in "hits", "misses":
            assert found[name].sum() == shared[f"patch_{name}"]
        assert shared["cell_misses"] > 0
        assert (shared["flits"] > 0) == (clusters > 1 and home is not None)


class Requests:
    """What golden's clusters request of the caches in a job of one phase."""

    def __init__(self, job):
        request = job.phases[0].request
        self._config, self._memsys, self._table = job.config, job.config.memsys, request.table
        shelling = Shelling.of_cells(request.geometry, request.table, job.config)
        strings = ReferenceStrings.of(shelling, [request.records[one.frustum] for one in job.sections if one])
        pointer, count = self._table.pointer, self._table.count
        own = (np.arange(len(count)) < self._memsys.own_cells) & (pointer + count <= self._memsys.own_entries)
        held = job.phases[0].image["residence"]["cluster"] != NONE
        self.cells = [part << (self._memsys.scene_cells - 1).bit_length() | cell for (one,) in strings.cells
                      for cell in one.tolist() if not own[cell]
                      for part in range(max(1, -(-int(count[cell]) // self._memsys.reply_ids)))]
        self.patches = [patch for (one,) in strings.patches for patch in one.tolist() if not held[patch]]

    def counted(self, policy):
        """Hits and misses of the caches of cells and patches, and hits of the one store in front of them."""
        memsys, found = self._config.replace({"memsys.cache_policy": policy.name.lower()}).memsys, []
        store, fetched = store_after(memsys.store_patches, np.array(self.patches))
        for lines, keys in (memsys.cell_lines, self.cells), (memsys.patch_lines, fetched):
            cache = Cache.of(memsys, lines=lines)
            cache.access(np.array(keys, dtype=np.int64))
            found += [cache.hits, cache.misses]
        return found, store.hits

    def beats(self, key):
        """Of main memory, to read a part of a cell's list: the record, and a word for every two entries."""
        part, cell = divmod(key, self._memsys.scene_cells)
        first = self._table.pointer[cell] + self._memsys.reply_ids * part
        end = min(self._table.pointer[cell] + self._table.count[cell], first + self._memsys.reply_ids)
        return 1 + max(0, -(-end // 2) - first // 2)


# Cell size, patches that the cluster holds, and the numbers of `CACHES` that do not depend on cycles.
PHASES = (0.3, 0, 2), (0.5, 0, 4), (0.5, 6, 4)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_each_policy_hits_and_misses_as_golden(clusters):
    """One cluster opens its cells in golden's order. With large cells it has all lists, so its patches come in golden's
    order, too, and those that neither it nor its store holds are requested of the cache.
    """
    counted = {policy: [] for policy in CachePolicy}
    for cell, held, exact in PHASES:
        sets = (*[()] * (clusters - 1), range(held))
        job = planned(clusters, cornell(clusters, points=(5, 1, 2, 6, 3), cell=cell, rays=(32, 8), sets=sets))
        job.descriptors["cluster"][1:] = clusters - 1
        requests, expected = Requests(job), JobMemory(job)
        assert bool(requests.cells) == (cell < 0.5)
        for policy, before in counted.items():
            with JobMachine(job, expected=expected) as machine:
                kept = patch_sources(casts(machine, machine.right(policy=policy)))["kept"].sum()
                found = [machine(machine.host.read(name)) for name in CACHES]
            golden, hits = requests.counted(policy)
            before.append(golden)
            assert (sum(found[:2]), sum(found[2:]) + kept) == (len(requests.cells), len(requests.patches))
            assert found[:exact] == golden[:exact]
            assert exact < len(CACHES) or kept == hits > 0
    assert all(counted[one] != counted[other] for one, other in combinations(CachePolicy, 2))


@pytest.mark.parametrize("clusters", CLUSTERS[1:])
def test_requests_of_two_clusters_are_goldens(clusters):
    """Their order depends on cycles, and hits on their order. Each request is a hit or a miss, and each miss one read
    of main memory.
    """
    job = planned(clusters, cornell(clusters, points=(5, 1, 2), cell=0.2, rays=(32, 8)))
    requests = Requests(job)
    cells, patches = requests.cells, requests.patches
    for policy in CachePolicy:
        with JobMachine(job) as machine:
            machine.begin(policy=policy)
            machine(machine.host.submit(job, job.descriptors[:1]))
            machine.until("busy")
            beats = -machine.port.read_beats
            machine(machine.host.submit(job, job.descriptors[1:]))
            machine.until("busy")
            # Those of the descriptors and near cells are no part of it.
            beats += machine.port.read_beats - sum(
                24 + -(-int(one["near_count"]) // 2) for one in job.descriptors[1:])
            records = machine(machine.host.collect(job))
            machine.check(records)
            kept = patch_sources(records)["kept"].sum()
            cell_hits, cell_misses, patch_hits, patch_misses = (machine(machine.host.read(name)) for name in CACHES)
        assert (cell_hits + cell_misses, patch_hits + patch_misses + kept) == (len(cells), len(patches))
        assert len(set(cells)) <= cell_misses < len(cells)
        assert len(set(patches)) <= patch_misses < len(patches)
        lists, each = beats - PATCH_WORDS * patch_misses, [requests.beats(key) for key in cells]
        assert min(each) * cell_misses <= lists <= max(each) * cell_misses

"""Whole frusta on small machines of one and two clusters: every byte that they write, and what they count."""

from itertools import combinations, product

import numpy as np
import pytest

from golden.cast.shelling import Shelling
from golden.ctu.sector import Sector
from golden.frustum import Hemisphere, hemisphere_record
from golden.memory_map.layout import NONE
from golden.memsys.cache import Cache
from golden.memsys.reference_strings import ReferenceStrings
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.ceiling_points import ceiling_points
from hw.host import POLL
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.image_layout import PATCH_WORDS
from hw.simulator.cast_result import SHARED_COUNTERS
from tb.system.scenes import frusta
from tb.system.small_machine import CLUSTERS, CONFIGS, Driven, cut, resident

COUNTED = SHARED_COUNTERS[2:]
FRUSTUM, PHASE = ("rays", "frustum"), ("phase", "rays", "frustum")


def cornell(clusters, **given):
    return frusta("cornell", CONFIGS[clusters], **{"cell": 0.5, "points": (5, 1, 2), **given})


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("memory", [{"latency": 1}, {"latency": 10, "spread": 30, "shuffles": True, "seed": 5}],
                         ids=["near", "far"])
def test_hemispheres(clusters, memory):
    given = cornell(clusters)
    with Driven(given, **memory) as machine:
        machine(machine.host.identify())
        for number, frustum in enumerate(given):
            machine.check(frustum, *(FRUSTUM if number else ()))


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_cast_waits_for_the_slowest_patch(clusters):
    """Memory answers later than the host reads the status: a cast that ended before would lack hits."""
    given = [resident(frustum, None) for frustum in cornell(clusters)]
    with Driven(given, latency=4 * POLL) as machine:
        for frustum in given:
            machine.check(frustum)
            assert sum(one["memory_found"] for one in machine(machine.host.counters())) > 0


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("cell", [0.5, 0.3])
def test_screens(clusters, cell):
    (given,) = cornell(clusters, pixels=(30, 20), cell=cell, points=())
    with Driven([given], latency=5) as machine:
        for _ in range(2):
            machine.check(given)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_many_small_cells(clusters):
    """More cells, entries and patches than the clusters' own memories hold."""
    given = cornell(clusters, cell=0.2)
    with Driven(given, latency=10, spread=20, shuffles=True) as machine:
        for number, frustum in enumerate(given):
            machine.check(frustum, *(FRUSTUM if number else ()))


# Where the second cluster's section begins, frustum after frustum.
CUTS = (12, 28, 4, 4, 31, 1, 16)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_results_beside_the_next_frustum_have_their_own_sections(clusters):
    """Sections differ from frustum to frustum; results are those of the frustum before the present one, which has
    other rays.
    """
    made = cornell(clusters)
    given = [cut(made[number % len(made)], *((0, column) if clusters > 1 else (0,)))
             for number, column in enumerate(CUTS)]
    with Driven(given, images=2, latency=5, spread=20) as machine:
        beside = 0
        for number, frustum in enumerate(given):
            machine.load(frustum, *(PHASE if number else ()), at=number % 2)
            machine(machine.host.start())
            if number:
                machine.results(given[number - 1], at=(number - 1) % 2, earlier=True)
                beside += machine(machine.host.status())["casts"]
            machine(machine.host.finish("casts", timeout=1 << 18))
        machine.results(given[-1], at=(len(given) - 1) % 2)
        # Both frusta can be written again, in any order; their sums have been.
        for _ in range(2):
            machine.results(given[-2], at=(len(given) - 2) % 2, earlier=True, sums=False)
            machine.results(given[-1], at=(len(given) - 1) % 2, sums=False)
        assert beside, "no result has been written beside a cast"


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_sums_of_several_frusta_add_up(clusters):
    given = cornell(clusters)
    sums = sum(frustum.written["sums"]["sum"].astype(np.int64) for frustum in given)
    total = 0
    with Driven(given) as machine:
        for number, frustum in enumerate(given):
            machine.load(frustum, *(FRUSTUM if number else ()))
            machine.cast()
            total += frustum.total
            machine.results(frustum, hits=False, sums=sums if frustum is given[-1] else False, total=total)
        machine.check(given[0], *FRUSTUM)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_moved_vertex_is_seen(clusters):
    """The comparisons do not pass with results of an earlier cast."""
    given = cornell(clusters)[0]
    with Driven([given]) as machine:
        machine.check(given)
        moved = resident(given, None)
        patches = moved.image["patches"].copy()
        patches["vertex"][:, 0] ^= 1 << 20
        moved.image.regions["patches"] = patches
        machine.load(moved)
        machine.cast()
        with pytest.raises(AssertionError, match="bytes of main memory are wrong"):
            machine.results(moved)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_scene_is_read_where_it_was_loaded_from(clusters):
    """A phase and a frustum from another address leave its address and the caches alone; only a scene changes both."""
    given, other = (cut(resident(cornell(clusters, cell=cell, points=(5,))[0], None), *range(0, 20 * clusters, 20))
                    for cell in (0.2, 0.3))
    with Driven([given], images=2, latency=5) as machine:
        machine.load(given, at=1)
        machine.cast()
        machine.results(given, at=1)
        counted = [machine(machine.host.read(name)) for name in COUNTED]
        assert any(counted)
        machine.load(given, *PHASE)
        assert [machine(machine.host.read(name)) for name in COUNTED] == counted
        broken = bytearray(given.image.to_bytes())
        for region in "cells", "patch_lists", "patches":
            first, size = given.image.offsets[region], given.image[region].nbytes
            broken[first:first + size] = bytes(size)
        machine.put(bytes(broken))
        machine.cast()
        machine.results(given)
        machine.load(other, "scene", "frustum")
        machine.cast()
        machine.results(other)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_counters_of_each_cluster(clusters):
    """They agree with each other, with the shared ones, and with where the patches are."""
    made = cornell(clusters, cell=0.2)[0]
    wide = {"intersection_visited": [], "memory_found": []}
    homes = [None, *range(clusters)]
    with Driven([made], latency=5) as machine:
        for home in homes:
            given = resident(made, home)
            answered = [one["memory_answered"] for one in machine(machine.host.counters())]
            flits = machine(machine.host.read("flits"))
            machine.load(given)
            cycles = machine.cast()
            machine.results(given)
            counters = machine(machine.host.counters())
            answered = [one["memory_answered"] - before for one, before in zip(counters, answered, strict=True)]
            shared = {name: machine(machine.host.read(name)) for name in COUNTED}
            # Patches of the home's memory: its own ones there, remote ones for the other cluster.
            for number, one in enumerate(counters):
                assert one["memory_found"] == one["intersection_patches"] > 0
                assert one["memory_opened"] > 0
                assert (one["memory_own"] > 0) == (number == home)
                assert (one["memory_remote"] > 0) == (home not in (None, number))
                assert 0 < one["cycles"] <= cycles
                assert one["traversal_steps"] > 0
                assert one["intersection_won"] <= one["intersection_inside"] <= one["intersection_tested"]
            assert sum(one["intersection_won"] for one in counters) >= (given.hits.patch >= 0).sum()
            assert answered == [sum(one["memory_remote"] for one in counters) if number == home else 0
                                for number in range(clusters)]
            assert max(one["cycles"] for one in counters) >= cycles - 20
            assert shared["cell_misses"] > 0
            for name in "hits", "misses":
                assert sum(one[f"memory_{name}"] for one in counters) == shared[f"patch_{name}"]
            assert (machine(machine.host.read("flits")) > flits) == (clusters > 1 and home is not None)
        if clusters > 1:
            for column in 4, 28:
                given = cut(made, 0, column)
                machine.check(given)
                for name, found in wide.items():
                    found.append([one[name] for one in machine(machine.host.counters())])
            # The cluster with more columns has more rays.
            (few, many), (more, less) = wide["intersection_visited"]
            assert few < more
            assert less < many


class Requests:
    """What golden's clusters request, frustum after frustum, of the frusta of `cornell`."""

    def __init__(self, clusters, *, points, cell, rays, sectors=()):
        self.config, scene = CONFIGS[clusters], open_scene("cornell")
        ceiling, down = ceiling_points(scene)
        geometry = PatchGeometry.of(scene, self.config.numbers, [*ceiling, scene.camera.eye])
        shelling = Shelling(geometry, self.config, cell=cell, by_code=True)
        records = [hemisphere_record(Hemisphere(*rays), geometry.coordinates, ceiling[point], down) for point in points]
        self._strings, self._table = ReferenceStrings.of(shelling, records, sectors), shelling.table

    def cached(self, frustum):
        """Keys of cells and of patches: requests to the caches, where the residents are those of an image."""
        memsys, pointer, count = self.config.memsys, self._table.pointer, self._table.count
        own = (np.arange(len(count)) < memsys.own_cells) & (pointer + count <= memsys.own_entries)
        cells = [part << (memsys.scene_cells - 1).bit_length() | cell for clusters in self._strings.cells
                 for one in clusters for cell in one.tolist() if not own[cell]
                 for part in range(max(1, -(-int(count[cell]) // memsys.reply_ids)))]
        held = frustum.image["residence"]["cluster"] != NONE
        return cells, [patch for clusters in self._strings.patches for one in clusters for patch in one.tolist()
                       if not held[patch]]

    def beats(self, key):
        """Of main memory, to read a part of a cell's list: the record, and a word for every two entries."""
        part, cell = divmod(key, self.config.memsys.scene_cells)
        first = self._table.pointer[cell] + self.config.memsys.reply_ids * part
        end = min(self._table.pointer[cell] + self._table.count[cell], first + self.config.memsys.reply_ids)
        return 1 + max(0, -(-end // 2) - first // 2)


@pytest.mark.parametrize("clusters", CLUSTERS[:1])
def test_each_policy_hits_and_misses_as_golden(clusters):
    """One cluster opens few cells of the bus, in golden's order, and requests all patches there, or those that are not
    resident.
    """
    given = {"points": (5, 1, 2), "cell": 0.3, "rays": (32, 8)}
    made, requests = cornell(clusters, **given), Requests(clusters, **given)
    phases = made, [resident(frustum, None) for frustum in made]
    found, expected = {}, {}
    with Driven(made, latency=10) as machine:
        for policy, number in product(CachePolicy, range(len(phases))):
            given = phases[number]
            keys = requests.cached(given[0])
            assert all(keys)
            memsys = requests.config.replace({"memsys.cache_policy": policy.name.lower()}).memsys
            caches = [Cache.of(memsys, lines=lines) for lines in (memsys.cell_lines, memsys.patch_lines)]
            for cache, several in zip(caches, keys, strict=True):
                cache.access(np.array(several, dtype=np.int64))
            expected[policy, number] = tuple(count for cache in caches for count in (cache.hits, cache.misses))
            # A policy is taken with the cells: later loads write another one into the register.
            machine.check(given[0], policy=policy)
            for frustum in given[1:]:
                machine.check(frustum, *FRUSTUM)
            found[policy, number] = tuple(machine(machine.host.read(name)) for name in COUNTED)
    assert found == expected
    # For every two policies one of the phases has different hits and misses.
    for one, other in combinations(CachePolicy, 2):
        assert any(expected[one, number] != expected[other, number] for number in range(len(phases)))


@pytest.mark.parametrize("clusters", CLUSTERS[1:])
@pytest.mark.parametrize("policy", CachePolicy)
def test_requests_of_two_clusters_are_goldens(clusters, policy):
    """Their order depends on cycles, and hits on their order. Each request is a hit or a miss, and each miss one read
    of main memory.
    """
    given = {"points": (5, 1, 2), "cell": 0.2, "rays": (32, 8)}
    columns = given["rays"][0]
    made = [resident(cut(frustum, 0, columns // 3), None) for frustum in cornell(clusters, **given)]
    sectors = [Sector(*(int(one[name]) for name in ("first_column", "end_column", "first_row", "end_row")))
               for one in made[0].image["clusters"]]
    requests = Requests(clusters, **given, sectors=tuple(sectors))
    cells, patches = requests.cached(made[0])
    with Driven(made, latency=10) as machine:
        beats = 0
        for number, frustum in enumerate(made):
            machine.load(frustum, *(FRUSTUM if number else ()), policy=policy)
            beats -= machine.port.read_beats
            machine.cast()
            beats += machine.port.read_beats
        cell_hits, cell_misses, patch_hits, patch_misses = (machine(machine.host.read(name)) for name in COUNTED)
    assert (cell_hits + cell_misses, patch_hits + patch_misses) == (len(cells), len(patches))
    assert len(set(cells)) <= cell_misses < len(cells)
    assert len(set(patches)) <= patch_misses < len(patches)
    lists, each = beats - PATCH_WORDS * patch_misses, [requests.beats(key) for key in cells]
    assert min(each) * cell_misses <= lists <= max(each) * cell_misses

"""What a patch store serves follows from golden's own store, and its latencies from the hardware's docstrings."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from benchmarks.machine_cuts import recorded_cuts, simulated_cuts
from benchmarks.machine_memory import recorded_memory, simulated_memory
from golden.engine.config import PRESETS
from golden.engine.memsys.patches.patch_store import KEPT_OF, PatchStore
from radiosity.machines.engine.cluster_cast import KEPT, NO_CLUSTER
from radiosity.machines.engine.job_latencies import store_timing
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.store_path import StoreTiming, ask_store, store_after
from tb.radiosity.machines.engine.scenarios import joint_casts, joint_runs

pytestmark = pytest.mark.usefixtures("interpreted")


def test_own_patches_pass_no_store_and_others_are_kept_once():
    store, patches = PatchStore(4), np.array([0, 1, 2, 4, 3, 6])
    first, keeps = ask_store(store, patches, np.array([NO_CLUSTER, -1, 2, 2, -1, NO_CLUSTER]))
    # 4 meets 0 in its frame, and 6 meets 2.
    assert first.tolist() == [NO_CLUSTER, -1, 2, 2, -1, NO_CLUSTER]
    assert keeps.tolist() == [True, False, True, False, False, False]
    second, keeps = ask_store(store, patches, first)
    assert second.tolist() == [KEPT, -1, KEPT, 2, -1, NO_CLUSTER]
    assert not keeps.any()


def test_every_16th_conflict_keeps_its_patch():
    store, fetched = store_after(1, np.arange(KEPT_OF + 1))
    assert fetched.tolist() == [*range(KEPT_OF + 1)]
    assert [patch in store for patch in (0, KEPT_OF - 1, KEPT_OF)] == [False, False, True]
    assert store_after(1, np.array([7, 7, 3, 7]))[1].tolist() == [7, 3]


def test_a_store_that_has_all_patches_hides_the_network():
    """Clusters end sooner where half of their patches have been requested from large stores than from small ones."""
    none, small, large = (joint_runs(joint_cast, columns=2, rows=2, frames=frames) for frames in (0, 2, 256))
    assert large.sum() < small.sum()
    assert large.sum() < none.sum()


def test_presence_bits_that_block_keep_the_order_of_the_requests():
    """A patch that is absent delays those behind it, and nothing else changes: the same patches are fetched."""
    free, blocked = (joint_casts(joint_cast, columns=2, rows=2, cached="lru", frames=64, in_order=in_order)
                     for in_order in (False, True))
    assert sum(one.cycles for one in blocked.times) > sum(one.cycles for one in free.times)
    assert (blocked.deferred == free.deferred).all()
    assert free.deferred.all()
    assert all((one == other).all() for one, other in zip(blocked.owner, free.owner, strict=True))


def test_latencies_are_those_of_the_components():
    timing = store_timing(PRESETS["paper"])
    assert (timing.lookup, timing.passed, timing.stored, timing.requests) == (3, 2, 16, 16)
    assert replace(timing, requests=8) == store_timing(PRESETS["paper"].replace({"memsys.store_requests": 8}))


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"lookup": 0}, ValueError, "Lookup must be at least 1, not 0"),
    ({"kept": 1.5}, TypeError, "Kept must be an int, not 1.5")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        StoreTiming(**asdict(store_timing(PRESETS["paper"])) | wrong)


@pytest.mark.nightly
def test_cycles_are_those_of_the_hardware_with_patch_stores():
    """Both paths: patches of other clusters, and patches of main memory."""
    rows = [simulated_cuts(row for row in recorded_cuts() if row.store),
            simulated_memory(tuple(row for row in recorded_memory() if row.store))]
    error = [abs(cycles / row.cycles - 1) for each in rows for row, cycles in each]
    assert len(error) == 3
    assert max(error) < 0.04

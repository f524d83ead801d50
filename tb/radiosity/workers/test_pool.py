"""Workers give the bytes of one process, or are refused with one line."""

import logging
from dataclasses import replace
from functools import partial

import psutil
import pytest
from distributed import LocalCluster

from golden.base.errors import InputError
from golden.base.library_versions import library_versions
from golden.engine.cast.methods import frustum_caster
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.npz_file import write_npz
from golden.light.factors.rows import FactorRows
from golden.scene.builtin import builtin_scene
from radiosity.workers import pool
from radiosity.workers.pool import WorkerPool
from radiosity.workers.proof import Proof

ROWS = {
    "grid": partial(FactorRows, error=0.1, sky_patches="tregenza", block_rows=6),
    "naive": partial(FactorRows, error=0.1, seed=3, block_rows=5),
    "shelling": partial(HemisphereRows, rays=(8, 4), block_rows=9),
}
# Workers in threads, which start sooner than processes.
LOCAL = {"n_workers": 2, "threads_per_worker": 2, "processes": False, "protocol": "tcp", "host": "127.0.0.1",
         "dashboard_address": "127.0.0.1:0", "scheduler_kwargs": {"dashboard": False},
         "silence_logs": logging.CRITICAL}


@pytest.fixture(scope="module")
def cluster():
    """A scheduler with two workers."""
    with LocalCluster(**LOCAL) as opened:
        yield opened


@pytest.fixture(scope="module")
def scene():
    return builtin_scene("furnace:2")


def content(rows, path, spread=None):
    write_npz(compute_view_factors(rows, spread=spread), path)
    return path.read_bytes()


@pytest.mark.parametrize("method", ROWS)
def test_workers_of_a_scheduler_give_the_bytes_of_one_process(method, cluster, scene, tmp_path):
    caster = frustum_caster(scene, method, cell=0.5)
    rows = ROWS[method](scene, caster)
    with WorkerPool(cluster.scheduler_address, method=method, cell=0.5) as workers:
        found = content(rows, tmp_path / "a.npz", workers.spread(scene, frusta=caster, rays=caster))
    assert found == content(rows, tmp_path / "b.npz")


def test_local_processes_give_the_bytes_of_one_process_and_listen_on_loopback_alone(scene, tmp_path):
    caster = frustum_caster(scene, "naive")
    rows = ROWS["naive"](scene, caster)
    with WorkerPool(2, method="naive") as workers:
        found = content(rows, tmp_path / "a.npz", workers.spread(scene, frusta=caster, rays=caster))
        here = psutil.Process()
        ports = [socket.laddr.ip for process in (here, *here.children(recursive=True))
                 for socket in process.net_connections("inet") if socket.status == psutil.CONN_LISTEN]
    assert found == content(rows, tmp_path / "b.npz")
    assert set(ports) == {"127.0.0.1"}
    assert len(ports) >= 3


def test_a_scene_travels_once_for_all_its_work(cluster, scene):
    caster = frustum_caster(scene, "naive")
    with WorkerPool(cluster.scheduler_address, method="naive") as workers:
        spread = workers.spread(scene, frusta=caster, rays=caster)
        first, second = (spread(FactorRows(scene, caster, error=error).rows, [(0, 1)]) for error in (0.1, 0.05))
        next(first)
        next(second)
        parcels = [key for key in cluster.scheduler.tasks if key.startswith("parcel-")]
        # The scene, and the rows with each error.
        assert len(parcels) == 3


def test_an_error_in_a_worker_ends_the_work(cluster, scene):
    caster = frustum_caster(scene, "naive")
    with WorkerPool(cluster.scheduler_address, method="naive") as workers:
        spread = workers.spread(scene, frusta=caster, rays=caster)
        with pytest.raises(IndexError):
            list(spread(FactorRows(scene, caster).rows, [(0, 1), (24, 25)]))


@pytest.mark.parametrize(("change", "message"), [
    ({"versions": library_versions("naive") | {"numpy": "0.0"}}, r"worker on .*: numpy must be 0\.0, not "),
    ({"canary": "abc"}, r"worker on .*: it computes other bits")])
def test_workers_that_would_give_other_bytes_are_refused(change, message, cluster, monkeypatch):
    proof = replace(Proof.of_this_process("naive"), **change)
    monkeypatch.setattr(Proof, "of_this_process", lambda method: proof)
    with pytest.raises(InputError, match=message), WorkerPool(cluster.scheduler_address, method="naive"):
        pytest.fail("the workers were accepted")


@pytest.mark.parametrize(("address", "message"), [
    ("tcp://192.0.2.1:8786", "^workers: scheduler tcp://192.0.2.1:8786: Address must begin with tls:// unless"),
    ("tcp://elsewhere:8786", "Address must begin with tls://"),
    ("tls://127.0.0.1:1", "no certificate; dask's settings distributed.comm.tls name it"),
    ("tcp://127.0.0.1:1", "^workers: scheduler tcp://127.0.0.1:1 cannot be reached: ")])
def test_schedulers_that_cannot_be_used_are_refused(address, message, monkeypatch):
    monkeypatch.setattr(pool, "_ANSWER", 0.2)
    with pytest.raises(InputError, match=message), WorkerPool(address, method="naive"):
        pytest.fail("the scheduler was accepted")


def test_a_scheduler_without_workers_is_refused(monkeypatch):
    monkeypatch.setattr(pool, "_ANSWER", 0.2)
    with (LocalCluster(**(LOCAL | {"n_workers": 0})) as empty,
          pytest.raises(InputError, match=r"^workers: scheduler .* has none$"),
          WorkerPool(empty.scheduler_address, method="naive")):
        pytest.fail("the scheduler was accepted")

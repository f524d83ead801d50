"""Processes of a run are killed: the file has the bytes of an undisturbed run."""

import contextlib
import signal
import subprocess
import sys
import time

import psutil
import pytest

pytestmark = pytest.mark.nightly

COMMAND = (sys.executable, "-m", "golden", "formfactors", "city:2", "--error", "0.02", "-o", "F.npz")
SCHEDULER = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
             "--dashboard-address", "127.0.0.1:0")


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The bytes of a run in one process."""
    folder = tmp_path_factory.mktemp("whole")
    subprocess.run(COMMAND, cwd=folder, check=True, capture_output=True)
    return (folder / "F.npz").read_bytes()


@contextlib.contextmanager
def started(folder, *options):
    """A run that has kept its first block."""
    with subprocess.Popen([*COMMAND, *options], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          text=True) as run:
        while not list(folder.glob("F.npz.blocks/rows-*.npz")):
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.02)
        yield run


def worker_processes(process):
    return [child for child in psutil.Process(process.pid).children() if "spawn_main" in " ".join(child.cmdline())]


@pytest.mark.parametrize("count", [1, 2])
def test_blocks_of_killed_workers_are_computed_again(count, expected, tmp_path):
    with started(tmp_path, "--workers", "2") as run:
        workers = worker_processes(run)
        assert len(workers) == 2
        for worker in workers[:count]:
            worker.kill()
        assert run.wait() == 0, run.stderr.read()
    assert (tmp_path / "F.npz").read_bytes() == expected
    assert not (tmp_path / "F.npz.blocks").exists()


def test_a_killed_client_is_continued_and_leaves_no_workers(expected, tmp_path):
    with started(tmp_path, "--workers", "2") as run:
        workers = worker_processes(run)
        run.send_signal(signal.SIGKILL)
    psutil.wait_procs(workers)
    kept = {path.name for path in tmp_path.glob("F.npz.blocks/rows-*.npz")}
    assert kept
    subprocess.run([*COMMAND, "--workers", "2", "--resume"], cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "F.npz").read_bytes() == expected


@pytest.fixture
def scheduler():
    """A scheduler in a process of its own with a worker, and its address."""
    with subprocess.Popen([sys.executable, "-m", *SCHEDULER], stderr=subprocess.PIPE, text=True) as process:
        line = next(line for line in process.stderr if "Scheduler at:" in line)
        address = line.split("at:")[1].strip()
        with subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1",
                               "--no-dashboard", "--dashboard-address", "127.0.0.1:0"],
                              stderr=subprocess.DEVNULL) as worker:
            yield process, address
            worker.terminate()
        process.kill()


def test_a_lost_scheduler_is_one_line_and_the_run_is_continued(scheduler, expected, tmp_path):
    process, address = scheduler
    with started(tmp_path, "--workers", address) as run:
        process.kill()
        assert run.wait() == 2
        assert run.stderr.read() == f"error: workers: the connection to scheduler {address} was lost\n"
    assert not (tmp_path / "F.npz").exists()
    subprocess.run([*COMMAND, "--resume"], cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "F.npz").read_bytes() == expected

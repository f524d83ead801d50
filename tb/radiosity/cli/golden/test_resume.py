"""A killed run of `formfactors`, and the run that continues it."""

import signal
import subprocess
import sys
import time

import pytest

COMMAND = (sys.executable, "-m", "golden", "formfactors", "city:2", "--error", "0.02", "-o")


def run(output, *options):
    return subprocess.run([*COMMAND, output, *options], capture_output=True, text=True, check=False)


@pytest.mark.nightly
def test_a_killed_run_is_continued_with_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    whole = run("whole.npz")
    assert whole.returncode == 0, whole.stderr
    folder = tmp_path / "F.npz.blocks"
    with subprocess.Popen([*COMMAND, "F.npz"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as killed:
        while len(list(folder.glob("rows-*.npz"))) < 3:
            assert killed.poll() is None
            time.sleep(0.02)
        killed.send_signal(signal.SIGKILL)
    assert not (tmp_path / "F.npz").exists()
    refused = run("F.npz")
    assert refused.returncode == 2
    assert "continue it by --resume" in refused.stderr
    resumed = run("F.npz", "--resume")
    assert resumed.returncode == 0, resumed.stderr
    assert (tmp_path / "F.npz").read_bytes() == (tmp_path / "whole.npz").read_bytes()
    assert not folder.exists()

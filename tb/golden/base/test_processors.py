import os
from pathlib import Path

import pytest

from golden.base.processors import processors
from golden.base.source_digest import PACKAGES


@pytest.fixture(autouse=True)
def sixteen(monkeypatch):
    """A process that may run on 16 processors."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: set(range(16)))


def write(root, files):
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


def test_without_quotas_they_are_those_of_the_affinity(tmp_path, monkeypatch):
    assert processors(tmp_path) == 16
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {3, 7})
    assert processors(tmp_path) == 2
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert processors(tmp_path) == 1


@pytest.mark.parametrize(("quotas", "expected"), [
    ({"a/b/cpu.max": "400000 100000\n"}, 4), ({"a/b/cpu.max": "150000 100000\n"}, 2),
    ({"a/b/cpu.max": "1 100000\n"}, 1), ({"a/b/cpu.max": "max 100000\n"}, 16),
    ({"a/b/cpu.max": "9900000 100000\n"}, 16), ({"a/b/cpu.max": "no"}, 16),
    ({"a/b/cpu.max": "max 100000\n", "a/cpu.max": "300000 100000\n"}, 3), ({"cpu.max": "500000 50000\n"}, 10),
    ({"other/cpu.max": "100000 100000\n"}, 16)])
def test_quotas_of_the_group_and_of_those_above_it(tmp_path, quotas, expected):
    quotas = {f"sys/fs/cgroup/{name}": text for name, text in quotas.items()}
    write(tmp_path, {"proc/self/cgroup": "0::/a/b\n"} | quotas)
    assert processors(tmp_path) == expected


@pytest.mark.parametrize(("quota", "expected"), [("250000", 3), ("-1", 16)])
@pytest.mark.parametrize("controllers", ["cpu", "cpu,cpuacct"])
def test_quotas_of_the_first_version_of_control_groups(tmp_path, controllers, quota, expected):
    folder = f"sys/fs/cgroup/{controllers}/jobs"
    write(tmp_path, {"proc/self/cgroup": f"5:memory:/other\n4:{controllers}:/jobs\n",
                     f"{folder}/cpu.cfs_quota_us": quota, f"{folder}/cpu.cfs_period_us": "100000"})
    assert processors(tmp_path) == expected


def test_nothing_else_counts_processors():
    sources = [path for package in (*PACKAGES, "benchmarks")
               for path in (Path(__file__).parents[3] / package).rglob("*.py")]
    assert [path.name for path in sources if "cpu_count" in path.read_text()] == ["processors.py"]


def test_this_process_has_one_at_least():
    assert 1 <= processors() <= 16

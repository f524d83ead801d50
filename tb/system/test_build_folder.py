"""The cache of builds: what was used longest ago goes first, and never what a process uses."""

import os

import pytest

from radiosity.flow.simulator.build_folder import content_key, keep_newest, locked, temporary_folder


def entry(parent, name, *, size, age):
    folder = parent / name
    folder.mkdir()
    (folder / "program").write_bytes(bytes(size))
    os.utime(folder, (1000 - age,) * 2)
    return folder


def test_the_longest_unused_go_first(tmp_path):
    old, new, newest = (entry(tmp_path, f"build{age}", size=100, age=age) for age in (3, 2, 1))
    keep_newest(tmp_path, most=300)
    assert old.exists()
    keep_newest(tmp_path, most=250)
    assert not old.exists()
    assert new.exists()
    os.utime(new)
    keep_newest(tmp_path, most=150)
    assert new.exists()
    assert not newest.exists()


def test_files_are_entries_too(tmp_path):
    for age in 1, 2:
        path = tmp_path / f"top{age}.v"
        path.write_bytes(bytes(100))
        os.utime(path, (1000 - age,) * 2)
    keep_newest(tmp_path, most=150)
    assert [path.name for path in tmp_path.iterdir()] == ["top1.v"]


def test_what_is_in_use_stays(tmp_path):
    old = entry(tmp_path, "old", size=100, age=2)
    with locked(old, shared=True), locked(old, shared=True):
        keep_newest(tmp_path, most=50)
        assert old.exists()
    keep_newest(tmp_path, most=50)
    assert not old.exists()


def test_what_is_in_use_or_just_built_is_not_counted(tmp_path):
    old, running, built = (entry(tmp_path, f"build{age}", size=size, age=age)
                           for age, size in ((3, 100), (2, 1000), (1, 1000)))
    with locked(running):
        keep_newest(tmp_path, most=150, built=built)
    assert all(folder.exists() for folder in (old, running, built))
    keep_newest(tmp_path, most=150, built=built)
    assert built.exists()
    assert not running.exists()
    assert not old.exists()


def test_a_temporary_folder_goes_with_its_build(tmp_path, monkeypatch):
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    with temporary_folder("a") as first:
        (first / "part").touch()
        with temporary_folder("b") as second:
            assert (first / "part").exists()
            assert second.exists()
        with pytest.raises(RuntimeError), temporary_folder("b"):
            raise RuntimeError
        assert not second.exists()
    assert not first.exists()


def test_what_a_killed_build_left_goes_with_the_next(tmp_path, monkeypatch):
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    (tmp_path / "parts").mkdir()
    left = entry(tmp_path / "parts", "killed", size=100, age=0)
    (tmp_path / "parts" / "killed.lock").touch()
    with temporary_folder("a"):
        assert not left.exists()


def test_another_source_has_another_key():
    keys = {content_key("a", "b"), content_key("ab"), content_key("a", "b", ""), content_key("b", "a")}
    assert len(keys) == 4
    assert content_key("a", "b") in keys

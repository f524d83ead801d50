import os
import stat
from pathlib import Path

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.base.output import (
    beginning_with,
    check_inputs_stay,
    check_named_once,
    check_outputs,
    check_text_name,
    whole_file,
)


def test_check_outputs_leaves_no_trace(tmp_path):
    check_outputs(tmp_path / "a.png", None, tmp_path / "b.EXR", suffixes=(".png", ".exr"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("name", "message"), [
    ("a.jpg", "must end in .png"), ("a", "must end in .png"), ("missing/a.png", "cannot be written"),
    ("folder.png", "is a directory"), ("file/a.png", "cannot be written"), ("x" * 300 + ".png", "cannot be written"),
])
def test_check_outputs_refuses(tmp_path, name, message):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=message):
        check_outputs(tmp_path / name, suffixes=(".png",))


@pytest.mark.parametrize("name", ["", ".", "/", "./", "//"])
def test_a_prefix_has_a_name(name):
    with pytest.raises(InputError, match=r"^output '.*': Prefix must have a name, not be a folder$"):
        beginning_with(Path(name), "-a.png")
    assert beginning_with(Path(name) / "b", "-a.png", ".c") == (Path(name) / "b-a.png", Path(name) / "b.c")
    assert beginning_with(None, "-a.png") == ()


@pytest.mark.parametrize("byte", [0x80, 0xC3, 0xFF])
def test_a_name_in_another_file_is_text(byte):
    name = os.fsdecode(b"a" + bytes([byte]) + b".mtl")
    with pytest.raises(InputError, match=r"Name must be UTF-8, which another file holds, not ") as caught:
        check_text_name(Path(name))
    str(caught.value).encode()
    check_text_name(Path(name) / "\N{GREEK SMALL LETTER PHI}.mtl")


@pytest.mark.parametrize("name", ["a.obj", "./folder/../a.obj", "link.obj", "hard.obj"])
def test_an_output_is_no_input(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "a.obj").write_text("v 0 0 0")
    (tmp_path / "link.obj").symlink_to("a.obj")
    (tmp_path / "hard.obj").hardlink_to(tmp_path / "a.obj")
    with pytest.raises(InputError, match=r"it is the input$"):
        check_inputs_stay("cornell", tmp_path / "a.obj", outputs=(None, tmp_path / name))
    check_inputs_stay(tmp_path / "a.obj", outputs=(tmp_path / "b.obj", tmp_path / "folder"))


@pytest.mark.parametrize("exists", [False, True])
@pytest.mark.parametrize("name", ["a.png", "./a.png", "folder/../a.png", "link.png", "linked/a.png", "/a.png"])
def test_an_output_is_named_once_by_whatever_path(tmp_path, monkeypatch, name, exists):
    """Also where it is to be made; an absolute path is below the folder here."""
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    Path("link.png").symlink_to("a.png")
    Path("linked").symlink_to(tmp_path)
    if exists:
        Path("a.png").write_text("old")
    same, others = Path(f"{tmp_path}{name}" if name.startswith("/") else name), (Path("b.png"), Path("folder/a.png"))
    with pytest.raises(InputError, match=r"^output .*(a|link).png': it is named twice$"):
        check_named_once(*others, None, same, Path("a.png"))
    check_named_once(*others, None, same, None)


def test_whole_file_replaces_only_when_the_block_ends_well(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail():
        with whole_file(path) as part:
            part.write_text("half")
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        fail()
    assert path.read_text() == "old"
    with whole_file(path) as part:
        part.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_named_by_the_output(tmp_path):
    with pytest.raises(OSError, match="No space left") as error, whole_file(tmp_path / "a.txt"):
        raise OSError(28, "No space left on device")
    assert error.value.filename == str(tmp_path / "a.txt")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["missing/a.txt", "file/a.txt", "folder"])
def test_what_cannot_be_written_has_the_name_that_was_given(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match=name) as caught, whole_file(Path(name)) as part:
        part.write_text("new")
    assert caught.value.filename == name
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


@pytest.mark.parametrize("real", ["a.npz", "A.NPZ", "a.Npz", "a", "a.dat"])
@pytest.mark.parametrize("name", ["b.npz", "B.NPZ", None])
def test_the_name_that_was_given_has_the_suffix_of_the_part_in_lower_case(tmp_path, name, real):
    """Whatever a link leads to: np.savez adds .npz to a part that does not end in it."""
    path = tmp_path / (name or real)
    if name:
        path.symlink_to(real)
    with whole_file(path) as part:
        assert part.name.endswith(path.suffix.lower())
        if part.suffix == ".npz":
            np.savez(part, a=np.arange(3))
        else:
            part.write_text("new")
    assert {one.name for one in tmp_path.iterdir()} == {path.name, real}
    assert (tmp_path / real).stat().st_size


def test_whole_file_writes_through_a_link_with_the_usual_permissions(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link.txt").symlink_to(tmp_path / "real" / "a.txt")
    with whole_file(tmp_path / "link.txt") as part:
        assert part.suffix == ".txt"
        part.write_text("new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real" / "a.txt").read_text() == "new"
    umask = os.umask(0)
    os.umask(umask)
    assert stat.S_IMODE((tmp_path / "real" / "a.txt").stat().st_mode) == 0o666 & ~umask

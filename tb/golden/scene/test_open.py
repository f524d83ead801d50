import pytest

from golden.base.errors import InputError
from golden.scene.builtin import builtin_scene
from golden.scene.export import export_scene
from golden.scene.open import open_scene


def test_names_sizes_and_files_are_opened(tmp_path):
    export_scene(builtin_scene("cornell"), tmp_path / "box.obj")
    assert open_scene("cornell").name == "cornell"
    assert len(open_scene("furnace:2")) == 24
    assert len(open_scene(str(tmp_path / "box.obj"))) == len(open_scene("cornell"))
    assert len(open_scene(tmp_path / "box.obj", zenith=(0, 0, 1))) == len(open_scene("cornell"))


def test_a_file_of_a_built_in_name_is_reached_by_its_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    export_scene(builtin_scene("furnace:1"), tmp_path / "a.obj")
    (tmp_path / "a.obj").rename(tmp_path / "cornell")
    assert open_scene("cornell").name == "cornell"
    with pytest.raises(InputError, match="Suffix must be one of"):
        open_scene("./cornell")


@pytest.mark.parametrize("scene", ["furnace:1", "gone.obj"])
@pytest.mark.parametrize("zenith", [(0, 0, 0), (0, 1), (0, float("nan"), 1), "y"])
def test_a_zenith_that_is_none_is_refused(scene, zenith):
    with pytest.raises(InputError) as error:
        open_scene(scene, zenith=zenith)
    assert str(error.value) == f"scene: Zenith must be three finite values, not all zero, not {zenith!r}"


def test_a_built_in_scene_has_the_zenith_that_is_given():
    assert open_scene("cornell").up == (0, 1, 0)
    assert open_scene("cornell", zenith=[0, 0, 1]).up == (0, 0, 1)


@pytest.mark.parametrize(("spec", "message"), [
    ("cornel", "scene 'cornel': no built-in scene and no file has that name; did you mean 'cornell'? Built in are "
     "cornell, "),
    ("Furnaces:2", "scene 'Furnaces:2': no built-in scene and no file has that name; did you mean 'furnace'?"),
    ("", "scene '': no built-in scene and no file has that name; built in are "),
    ("gone.obj", "gone.obj: no such file"),
    ("furnace:0", "scene 'furnace': Size must be 1 to 64, not 0"),
    ("furnace:x", "scene 'furnace:x': Size must be a whole number, not 'x'"),
    # A digit, but no decimal one.
    ("furnace:²", "scene 'furnace:²': Size must be a whole number, not '²'"),
    ("cornell:3", "scene 'cornell': it has one size, so cornell:3 does not exist"),
    ("/", "/: it is a directory, not a scene file"),
])
def test_what_is_no_scene_gives_one_line(spec, message):
    with pytest.raises(InputError) as error:
        open_scene(spec)
    assert str(error.value).startswith(message)

"""The list of built-in scenes."""

import pytest

from golden.base.errors import InputError
from golden.scene import builtin
from golden.scene.builtin import BUILTIN, builtin_scene
from tb.radiosity.cli.golden.runner import report, run


def test_the_sizes_of_the_list_are_those_that_scenes_have(monkeypatch):
    listed = report("scenes")["scenes"]
    assert [row["name"] for row in listed] == list(BUILTIN)
    lines = run("scenes").stdout.splitlines()
    # The room that the source counts.
    assert {row["name"]: row["patches"] for row in listed}["lobby"] == 227

    class Made:
        """A module whose scene is its size."""

        def __getattr__(self, name):
            return lambda *size: size

    monkeypatch.setattr(builtin, "import_module", lambda name: Made())
    for row in listed:
        line, = (line for line in lines if line.split()[:1] == [row["name"]])
        assert line.split()[1] == str(row["patches"])
        if row["sizes"] is None:
            assert builtin_scene(row["name"]) == ()
            with pytest.raises(InputError, match="it has one size"):
                builtin_scene(f"{row['name']}:1")
            continue
        least, most = row["sizes"]
        assert f" {least}-{most} ({row['default']}) " in line
        assert builtin_scene(row["name"]) == (row["default"],)
        for size in (least, most):
            assert builtin_scene(f"{row['name']}:{size}") == (size,)
        for size in (least - 1, most + 1):
            with pytest.raises(InputError):
                builtin_scene(f"{row['name']}:{size}")

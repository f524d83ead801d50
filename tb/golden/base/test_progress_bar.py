"""A bar on terminals of any size."""

import fcntl
import io
import os
import pty
import re
import select
import struct
import termios
from pathlib import Path

import pytest

from golden.base import progress_bar as progress_bar_module
from golden.base.progress_bar import progress_bar
from golden.base.source_digest import PACKAGES
from golden.cast.default_camera import default_camera
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin.furnace import furnace
from radiosity.cli.console import Console

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("size", [(0, 0), (24, 0), (0, 80), (24, 120)])
def test_a_bar_shows_whatever_size_the_terminal_reports(size, monkeypatch):
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", *size, 0, 0))
    with open(terminal, "w") as screen:
        monkeypatch.setattr("sys.stderr", screen)
        with progress_bar(total=4, desc="cast") as bar:
            bar.update(2)
            bar.refresh()
        shown = b""
        # A terminal hands text over piece by piece.
        while b"cast:  50%" not in shown and select.select([reader], [], [], 5)[0]:
            shown += os.read(reader, 10_000)
    os.close(reader)
    assert b"cast:  50%" in shown


def test_a_file_is_no_terminal(monkeypatch):
    screen = io.StringIO()
    monkeypatch.setattr("sys.stderr", screen)
    with progress_bar(total=4, desc="cast"):
        pass
    assert "cast:   0%" in screen.getvalue()


@pytest.fixture
def bars(monkeypatch):
    """Whether each bar that is made is disabled, by what it describes."""
    made = {}

    class Bar(progress_bar_module.tqdm):
        def __init__(self, *given, desc, disable, **options):
            made.setdefault(desc, set()).add(disable)
            super().__init__(*given, desc=desc, disable=True, **options)

    monkeypatch.setattr(progress_bar_module, "tqdm", Bar)
    return made


@pytest.mark.parametrize("progress", [False, True])
def test_bars_are_shown_where_they_are_requested(progress, bars):
    scene = furnace(1)
    settings = RenderSettings(width=2, height=2, samples=1, light_samples=1, rays=(8, 4), max_edge=2, jobs=1)
    render(scene, camera=default_camera(scene), settings=settings, progress=progress)
    compute_view_factors(HemisphereRows(scene, Naive(scene), rays=(8, 4)), progress=progress)
    Grid(scene, progress=progress)
    assert bars.keys() == {"embree", "form factors", "radiosity", "image", "view factors", "grid"}
    if progress:  # blocks of view factors have one bar together
        assert all(False in disabled for disabled in bars.values())
    else:
        assert all(disabled == {True} for disabled in bars.values())


@pytest.mark.parametrize(("quiet", "verbose", "is_terminal", "expected"), [
    (False, False, True, True), (False, False, False, False), (False, True, False, True), (True, False, True, False)])
def test_a_command_shows_bars_on_a_terminal_or_when_it_is_verbose(quiet, verbose, is_terminal, expected, monkeypatch):
    screen = io.StringIO()
    screen.isatty = lambda: is_terminal
    monkeypatch.setattr("sys.stderr", screen)
    console = Console()
    console.quiet, console.verbose = quiet, verbose
    assert console.progress == expected


def test_every_bar_is_disabled_by_its_request_alone():
    """Those of the simulated machine and of the hardware's commands too."""
    sources = "".join(path.read_text() for package in (*PACKAGES, "benchmarks")
                      for path in (ROOT / package).rglob("*.py"))
    assert set(re.findall(r"\bdisable=(not [\w.()]+?|[^n][^,)]*)[,)]+", sources)) <= {
        "not progress", "not shown", "not self._progress", "not console(", "not console().progress"}
    assert set(re.findall(r"\bshown=([\w.()]+?)[,)]", sources)) <= {"progress", "console(", "console().progress"}

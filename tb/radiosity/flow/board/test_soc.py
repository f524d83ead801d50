"""The SoC with SDRAM for the ULX3S: what its engine holds, and the command, without LiteX and the tools of synthesis.

tb/radiosity/flow/package/test_litex.py has these tools, and casts in the SoC.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import radiosity.cli.hw.main
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.differences import oracle_rays
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import PRESETS
from golden.engine.frustum import hemisphere_record
from golden.engine.jobs.core_manifest import CoreManifest
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene
from radiosity.flow.board.soc import NEXTPNR, SOC
from radiosity.flow.job_image import ImageFrusta, job_files
from radiosity.flow.synthesis.family import Area
from radiosity.flow.synthesis.flow import Bitstream, Clock

ROOT = Path(__file__).parents[4]
# Stands for the Python of LiteX: notes its words, writes what LiteX does, and finds no packages of this environment.
LITEX = """#!{python}
import os
import sys
from pathlib import Path

assert "PYTHONPATH" not in os.environ
assert Path("ulx3s.py").exists() or sys.argv[1] == "-c"
with open({words!r}, "a") as file:
    print(*sys.argv[1:], file=file)
if {fails}:
    sys.exit("first\\nNo module named 'litex'")
if sys.argv[1] != "-c":
    gateware = Path(sys.argv[2], "gateware")
    gateware.mkdir(parents=True)
    (gateware / "top.v").write_text("module top; endmodule")
    (gateware / "top.lpf").write_text("LOCATE")
"""


@pytest.fixture
def litex(monkeypatch, tmp_path):
    """Makes a program for ``--litex``, which notes its words in ``words``."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "packages"))

    def made(*, fails=False):
        program = tmp_path / "litex"
        program.write_text(LITEX.format(python=sys.executable, words=str(tmp_path / "words"), fails=fails))
        program.chmod(0o755)
        return str(program)
    return made


@pytest.fixture
def tools(monkeypatch):
    """The calls of synthesis, place and route, in place of which there are figures."""
    calls = []

    def bitstream(*arguments, **options):
        calls.append((arguments, options))
        return Bitstream(area=Area(lut=51, ff=52, dsp=53, bram=54), clocks=(Clock(seed=3, mhz=41.25, path="a to b"),),
                         synthesis_seconds=5, route_seconds=(6,))

    def write_core(top, *, config, preset, folder, ram_styles):
        (folder / "litex_soc").mkdir(parents=True)
        (folder / "litex_soc" / "ulx3s.py").touch()

    monkeypatch.setattr("radiosity.flow.board.soc.check_options", lambda *_, **__: None)
    monkeypatch.setattr("radiosity.flow.board.soc.verilog_bitstream", bitstream)
    monkeypatch.setattr("radiosity.flow.board.soc.write_core", write_core)
    monkeypatch.setattr("radiosity.flow.synthesis.flow.tool_versions", lambda: "tools")
    return calls


def run(*arguments):
    """What the command returns."""
    return CliRunner().invoke(radiosity.cli.hw.main.main, ["soc", *map(str, arguments)])


def test_the_engine_holds_room1627():
    """A hemisphere with as many rays as a section may have, all resident patches, in the board's 32 MB."""
    core = CoreManifest(config=SOC, policy=0, sha256="")
    made = job_files("room1627", ImageFrusta(patches=(100,), rays=(64, 16)), core, sums=True)
    (request,) = [phase.request for phase in made.job.phases]
    assert len(request.geometry) == 1297
    assert len(request.records[0]) == SOC.icu.rays == 1024
    assert made.job.end <= 32 << 20 == 1 << SOC.memory.address_bits


@pytest.mark.nightly
@pytest.mark.parametrize(("config", "least", "most"), [(SOC, 0, 1e-3), (PRESETS["board"], 0.15, 0.25)],
                         ids=["SoC", "serial demo"])
def test_narrow_numbers_change_as_many_rays_as_the_page_says(config, least, most):
    """Of hemispheres of 4,096 rays from 16 patches, which no section holds; form factors change about as much."""
    scene, hemisphere = open_scene("room1627"), Hemisphere(64, 64)
    grid, patches = Grid(scene, jobs=1), range(0, len(scene), 82)
    middles = {patch: scene.vertices[patch].mean(axis=0) for patch in patches}
    config = replace(config, icu=replace(config.icu, rays=len(hemisphere), side_bits=6, patch_bits=11))
    geometry = PatchGeometry.of(scene, config.numbers, list(middles.values()))
    differ, shares = 0, 0.0
    for patch, middle in middles.items():
        record = hemisphere_record(hemisphere, geometry.coordinates, middle, scene.normals[patch],
                                   source=int(scene.surface[patch]))
        found, oracle = NaiveFixed(geometry, config).cast(record).patch, grid.nearest(
            oracle_rays(record, geometry)).patch
        differ += np.count_nonzero(found != oracle)
        factors = [np.bincount(hits + 1, hemisphere.weights, len(scene) + 1)[1:] for hits in (found, oracle)]
        shares += np.abs(factors[0] - factors[1]).sum() / 2.0**hemisphere.weight_bits / len(middles)
    assert len(middles) * len(hemisphere) == 65536
    assert least < differ / 65536 < most
    assert least / 2 < shares < 2 * most


def test_hits_in_the_numbers_of_the_soc_are_those_of_float64():
    """All but one ray in a thousand, from the middles of patches of all kinds; form factors to a thousandth in sum."""
    scene = open_scene("room1627")
    grid, patches = Grid(scene, jobs=1), range(0, len(scene), 180)
    middles = {patch: scene.vertices[patch].mean(axis=0) for patch in patches}
    geometry = PatchGeometry.of(scene, SOC.numbers, list(middles.values()))
    rays = differ = 0
    for patch, middle in middles.items():
        record = hemisphere_record(Hemisphere(64, 16), geometry.coordinates, middle, scene.normals[patch],
                                   source=int(scene.surface[patch]))
        found = NaiveFixed(geometry, SOC).cast(record).patch
        oracle = grid.nearest(oracle_rays(record, geometry)).patch
        counts = [np.bincount(hits[hits >= 0], minlength=len(scene)) for hits in (found, oracle)]
        assert np.abs(counts[0] - counts[1]).sum() <= 4, patch
        rays, differ = rays + len(found), differ + np.count_nonzero(found != oracle)
    assert rays == 8 * 1024
    assert differ <= rays / 1000


def test_the_command_has_litex_and_the_tools_make_a_bitstream(litex, tools, tmp_path):
    folder = tmp_path / "out"
    done = run("--litex", litex(), "-o", folder, "--mhz", 41, "--baud", 500000, "--revision", "1.7", "--seed", 3)
    assert done.exit_code == 0, done.output
    made = folder / "litex_soc" / "ulx3s"
    assert (tmp_path / "words").read_text().splitlines()[1] == (
        "ulx3s.py ulx3s --clock 41000000 --baud 500000 --revision 1.7")
    ((sources, constraints, where, name), options), = tools
    assert sources == (folder / "radiosity_engine.sv", made / "gateware" / "top.v")
    assert (constraints, where, name) == ("LOCATE", made, "soc")
    assert options == {"seeds": (3,), "options": ("--freq", "41", *NEXTPNR)}
    figures = json.loads((made / "soc.figures.json").read_text())
    assert {word: figures[word] for word in ("lut", "ff", "dsp", "bram", "mhz", "seed")} == {
        "lut": 51, "ff": 52, "dsp": 53, "bram": 54, "mhz": 41.25, "seed": 3}
    first, *paths = done.stdout.splitlines()
    assert first.startswith("51 LUT, 52 registers, 53 DSP blocks, 54 block RAM; 41.2 MHz of 41; ")
    assert first.endswith(f"; {figures['seconds']} s")
    assert paths[-2:] == [str(made / "soc.bit"), str(made / "soc.figures.json")]


def test_the_verilog_alone_needs_no_tools(litex, tools, tmp_path):
    done = run("--no-bitstream", "--litex", litex(), "-o", tmp_path / "out")
    assert not tools
    assert [path.rpartition("/")[2] for path in done.stdout.splitlines()] == ["radiosity_engine.sv", "top.v", "top.lpf"]


@pytest.mark.parametrize(("arguments", "message"), [
    (["-P", "noc.columns=2"], "must be 1, not 2"), (["--litex", "nowhere"], "--litex names another Python"),
    (["--mhz", "200"], "200.0 is not in the range")])
def test_what_cannot_be_built_is_refused(litex, tools, tmp_path, arguments, message):
    done = run("--litex", litex(), "-o", tmp_path / "out", *arguments)
    assert done.exit_code == 2
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_litex_that_fails_without_a_word_is_one_line(tools, tmp_path):
    program = tmp_path / "silent"
    program.write_text("#!/bin/sh\nexit 3\n")
    program.chmod(0o755)
    done = run("--litex", program, "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert done.stderr == "error: soc: LiteX failed: exit code 3\n"


def test_without_litex_nothing_is_written(litex, tools, tmp_path):
    done = run("--litex", litex(fails=True), "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert done.stderr == "error: soc: LiteX failed: No module named 'litex'\n"
    assert not (tmp_path / "out").exists()

import csv
import errno
import json
import os
import subprocess
import sys

import click
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import radiosity.cli.golden.main
import radiosity.tasks.render
from golden.cast.methods import RAY_METHODS
from radiosity.cli.command_line import command_line
from tb.golden.light.exr import read_exr

FAST = ("--size", "12x8", "--spp", "1", "--light-samples", "1", "--depth", "1", "--rays", "16x4", "--method", "grid")
# With patches that are not cut.
COARSE = (*FAST, "--max-edge", "1000")

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
LAMP = "mtllib lamp.mtl\nusemtl lamp\n"
NFF_VIEW = "v\nfrom {from_}\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 16 16\n"
NFF_BODY = "b 0.5 0.5 0.5\nl 4 3 2\nf 0.8 0.2 0.2 1 0 0 0 1\np 3\n0 0 0\n1 0 0\n0 1 0\n"
@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments):
    result = CliRunner().invoke(radiosity.cli.golden.main.main, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exc_info
    return result


def succeed(*arguments):
    result = run(*arguments)
    assert result.exit_code == 0, result.stderr
    return result.stdout


def content(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(exit_code, stderr, message, code=2):
    assert exit_code == code
    assert stderr.startswith("error: "), stderr
    assert stderr.endswith("\n")
    assert stderr.count("\n") == 1, stderr
    assert "Traceback" not in stderr
    assert message in stderr


RENDER = ("render", "furnace:1", "-o", "out.png", *FAST)

FACTORS = ("formfactors", "furnace:1", "--rays", "16x4")
PENTAGON = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n"
ADAPTIVE = ("formfactors", "-o", "F.npz")
VS3 = "V 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nS 1 1 2 3 4 0 0 1 wall\n"
EXCHANGE = ("exchange", "F.npz", "t.csv", "-o", "q.csv")
HEAD = "surface,temperature,emissivity\n"
# View factors between two parallel walls.
WALLS = {"data": [1.0, 1.0], "indices": [1, 0], "indptr": [0, 1, 2], "shape": [2, 2], "sky": [0.0, 0], "area": [1.0, 1],
         "normal": [[0.0, 0, 1], [0, 0, -1]], "surface": ["a", "b"], "settings": "{}",
         "back": [0.0, 0], "patch": [0, 1], "front": [True, True]}

# Name of the case: files to make (text, or arrays of an .npz), arguments, the message.
BAD = {
    "no command": ({}, (), "Missing command"),
    "unknown command": ({}, ("rendr", "cornell"), "rendr"),
    "unknown option": ({}, (*RENDER, "--sise", "8x8"), "--sise"),
    "no scene": ({}, ("render", "-o", "out.png"), "SCENE"),
    "no output": ({}, ("render", "furnace"), "--output"),
    "two scenes": ({}, ("render", "furnace", "cornell", "-o", "out.png"), "cornell"),
    "unknown scene": ({}, ("render", "atrium", "-o", "out.png"), "'atrium'"),
    "size that is no number": ({}, ("render", "tetra:big", "-o", "out.png"), "whole number"),
    "negative size": ({}, ("render", "tetra:-1", "-o", "out.png"), "whole number"),
    "missing file": ({}, ("render", "nowhere.obj", "-o", "out.png"), "nowhere.obj"),
    "unknown ending": ({"a.max": "x"}, ("render", "a.max", "-o", "out.png"), ".max"),
    "empty file": ({"a.obj": ""}, ("render", "a.obj", "-o", "out.png"), "a.obj"),
    "rubbish as glTF": ({"a.gltf": "{}"}, ("render", "a.gltf", "-o", "out.png"), "a.gltf"),
    "rubbish as NFF": ({"a.nff": "p 3\n0 0\n"}, ("render", "a.nff", "-o", "out.png"), "a.nff"),
    "unknown material": ({"a.obj": LAMP + TRIANGLE + "f 1 2 3\n", "lamp.mtl": "newmtl other\nKd 1 1 1\n"},
                         ("render", "a.obj", "-o", "out.png", "--strict"), "'lamp'"),
    "missing material file": ({"a.obj": LAMP + TRIANGLE + "f 1 2 3\n"},
                              ("render", "a.obj", "-o", "out.png", "--strict"), "lamp.mtl"),
    "no light": ({"a.obj": TRIANGLE + "f 1 2 3\n"}, ("render", "a.obj", "-o", "out.png"), "light"),
    "folder as scene": ({"a.obj/b": ""}, ("render", "a.obj", "-o", "out.png"), "a.obj"),
    "eye at the target": ({}, (*RENDER, "--eye", "1,2,3", "--target", "1,2,3"), "eye"),
    "eye of two numbers": ({}, (*RENDER, "--eye", "1,2"), "--eye"),
    "eye not a number": ({}, (*RENDER, "--eye", "1,2,nan"), "--eye"),
    "degenerate camera of a file": ({"a.nff": NFF_VIEW.format(from_="0 0 0") + NFF_BODY},
                                    ("render", "a.nff", "-o", "out.png"), "camera"),
    "wrong ending": ({}, ("render", "furnace", "-o", "out.jpg"), ".jpg"),
    "output in a missing folder": ({}, ("render", "furnace", "-o", "missing/out.png"), "missing/out.png"),
    "output that is a folder": ({"out.png/a": ""}, ("render", "furnace", "-o", "out.png"), "directory"),
    "output below a file": ({"a": ""}, ("render", "furnace", "-o", "a/out.png"), "a/out.png"),
    "same output twice": ({"a/b": ""}, (*RENDER, "-o", "a/../out.png"), "twice"),
    "statistics with the wrong ending": ({}, (*RENDER, "--stats", "a.txt"), ".json"),
    "statistics in a missing folder": ({}, (*RENDER, "--stats", "missing/a.json"), "missing/a.json"),
    "heat map in a missing folder": ({}, (*RENDER, "--heatmap", "missing/a"), "missing/a"),
    "heat map without a name": ({}, (*RENDER, "--heatmap", "."), "Prefix must have a name"),
    "false colours without a name": ({}, (*RENDER, "--false-colour", ""), "Prefix must have a name"),
    "heat map over an image": ({}, ("render", "furnace:1", "-o", "a-steps.png", "--heatmap", "a", *FAST), "twice"),
    "illuminance with the wrong ending": ({}, (*RENDER, "--illuminance", "a.txt"), ".csv"),
    "surfaces with the wrong ending": ({}, (*RENDER, "--surfaces", "a.obj"), ".glb"),
    "false colours in a missing folder": ({}, (*RENDER, "--false-colour", "missing/a"), "missing/a"),
    "sensors that are not there": ({}, (*RENDER, "--sensors", "a.txt"), "a.txt: cannot be read"),
    "table of no sensors": ({}, (*RENDER, "--sensor-table", "a.csv"), "--sensor-table: Sensor table must have sensors"),
    "table over its sensors": ({"a.csv": "0 0 0 0 0 1\n"}, (*RENDER, "--sensors", "a.csv", "--sensor-table", "a.csv"),
                               "it is the input"),
    "no efficacy": ({}, (*RENDER, "--efficacy", "0"), "--efficacy"),
    "image of one number": ({}, (*RENDER, "--size", "512"), "--size"),
    "image of a digit that is no decimal one": ({}, (*RENDER, "--size", "12x²"), "'12x²' is not two whole numbers"),
    "image too large": ({}, (*RENDER, "--size", "16384x16384"), "pixels"),
    "samples that are no square": ({}, (*RENDER, "--spp", "3"), "square number"),
    "samples not a number": ({}, (*RENDER, "--spp", "many"), "--spp"),
    "rays not a power of two": ({}, (*RENDER, "--rays", "100x64"), "power of two"),
    "no edge": ({}, (*RENDER, "--max-edge", "0"), "--max-edge"),
    "too many elements": ({}, (*RENDER, "--max-edge", "1e-6"), "elements"),
    "no threads": ({}, (*RENDER, "--jobs", "0"), "Jobs must be"),
    "unknown solver": ({}, (*RENDER, "--solver", "magic"), "magic"),
    "nothing missing": ({}, (*RENDER, "--shoot", "1e-9"), "--shoot: Tolerance must be"),
    "no shooters": ({}, (*RENDER, "--shoot", "0.1", "--shooters", "0"), "--shooters: Shooters must be"),
    "shooters without shooting": ({}, (*RENDER, "--shooters", "4"), "--shooters needs --shoot"),
    "preview without shooting": ({}, (*RENDER, "--preview", "p.png"), "--preview needs --shoot"),
    "preview of no format": ({}, (*RENDER, "--shoot", "0.1", "--preview", "p.tga"), ".tga"),
    "preview at no step": ({}, (*RENDER, "--shoot", "0.1", "--preview", "p.png", "--preview-steps", "0"),
                           "--preview-steps: Steps must be"),
    "shooting by a solver": ({}, (*RENDER, "--shoot", "0.1", "--solver", "gauss-seidel"), "exclude each other"),
    "shooting under a sky": ({}, (*RENDER, "--shoot", "0.1", "--sky", "1,1,1"), "--shoot: It has a background"),
    "unknown method": ({}, (*RENDER, "--method", "octree"), "octree"),
    "unknown tone curve": ({}, (*RENDER, "--tone", "filmic"), "filmic"),
    "gamma that no picture states": ({}, (*RENDER, "--gamma", "1e-5"), "--gamma: Gamma must be"),
    "exposure not a number": ({}, (*RENDER, "--exposure", "nan"), "--exposure"),
    "scale without false colours": ({}, (*RENDER, "--decades", "3"), "--decades"),
    "picture of other bits": ({}, (*RENDER, "--bits", "12"), "--bits"),
    "gamma of zero": ({}, (*RENDER, "--gamma", "0"), "--gamma"),
    "sky of two numbers": ({}, (*RENDER, "--sky", "1,1"), "--sky"),
    "dark sky below zero": ({}, (*RENDER, "--sky", "0,-1,0"), "--sky"),
    "unknown quality": ({}, (*RENDER, "--quality", "best"), "'best' is not one of 'sketch', 'draft', 'normal', 'high'"),
    "two qualities": ({}, (*RENDER, "--quick", "--quality", "high"), "--quick and --quality exclude each other"),
    "quick view factors": ({}, (*FACTORS, "-o", "F.npz", "--quick"), "'--quick'"),
    "unknown sky": ({}, (*RENDER, "--sky", "blue"), "--sky"),
    "sun without a sky": ({}, (*RENDER, "--sun", "180,40"), "--sun needs --sky"),
    "clear sky without a sun": ({}, (*RENDER, "--sky", "cie-clear"), "--sun: Sun must be above the horizon"),
    "clear sky at night": ({}, (*RENDER, "--sky", "cie-clear", "--date", "2026-06-21T23:00+00:00", "--place", "48,11"),
                           "--sun: Sun must be above the horizon"),
    "date without a place": ({}, (*RENDER, "--sky", "cie-clear", "--date", "2026-06-21T12:00Z"), "need each other"),
    "date without an offset": ({}, (*RENDER, "--sky", "cie-clear", "--date", "2026-06-21T12:00", "--place", "48,11"),
                               "--date: Date must have an offset"),
    "date that is none": ({}, (*RENDER, "--sky", "cie-clear", "--date", "today", "--place", "48,11"), "--date"),
    "two suns": ({}, (*RENDER, "--sky", "cie-clear", "--sun", "180,40", "--date", "2026-06-21T12:00Z", "--place",
                      "48,11"), "--sun excludes"),
    "weather of another sky": ({}, (*RENDER, "--sky", "uniform", "--weather", "500,100"), "--weather: Weather must"),
    "north upwards": ({}, (*RENDER, "--sky", "uniform", "--north", "0,0,1"), "--north: North must not be"),
    "luminaire of an unknown kind": ({"a.txt": ""}, (*RENDER, "--luminaire", "a.txt", "0,0,1"), "a.txt: Suffix"),
    "luminaire that is not there": ({}, (*RENDER, "--luminaire", "a.ies", "0,0,1"), "a.ies: cannot be read"),
    "luminaire nowhere": ({"a.ies": ""}, (*RENDER, "--luminaire", "a.ies", "0,0"), "--luminaire"),
    "export of an unknown scene": ({}, ("scene", "atrium", "-o", "a.glb"), "'atrium'"),
    "export to an unknown format": ({}, ("scene", "furnace", "-o", "a.blend"), ".blend"),
    "form factors with the wrong ending": ({}, ("formfactors", "furnace", "-o", "F.csv"), ".csv"),
    "form factors of too many elements": ({}, ("formfactors", "furnace", "-o", "F.npz", "--max-edge", "1e-5"),
                                          "elements"),
    "form factors without sample points": ({}, ("formfactors", "furnace", "-o", "F.npz", "--samples", "0"),
                                           "--samples"),
    "view factors without a case": ({}, ("formfactors", "furnace", "-o", "vfsparse.input"), "vfsparse.inp"),
    "view factors where nothing can be written": ({}, (*FACTORS, "-o", "/sys/F.npz"), "/sys/F.npz': cannot be written"),
    "netCDF where nothing can be written": ({}, (*FACTORS, "-o", "/sys/F.nc"), "/sys/F.nc': cannot be written"),
    "lines where nothing can be written": ({}, (*FACTORS, "-o", "/sys/vfsparse.inp"), "cannot be written"),
    "view factors over a folder": ({"F.nc/a": ""}, (*FACTORS, "-o", "F.nc"), "directory"),
    "sky view factors over a folder": ({"svf.inp.1/a": ""}, (*FACTORS, "-o", "vfsparse.inp.1"), "svf.inp.1"),
    "error of zero": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--error", "0"), "--error"),
    "error above all": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--error", "2"), "--error: Error must be"),
    "sky patches of plain hemispheres": ({}, (*FACTORS, "-o", "F.npz", "--sky-patches", "tregenza"),
                                         "--sky-patches excludes --rays"),
    "sky patches as lines": ({}, ("formfactors", "furnace:1", "-o", "vfsparse.inp", "--sky-patches", "tregenza"),
                             "--sky-patches needs an output that ends in .npz or .nc"),
    "error of the sky above all": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--sky-error", "2"),
                                   "--sky-error: Sky error must be"),
    "negative seed of view factors": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--seed", "-1"),
                                      "--seed: Seed must be"),
    "no time": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--time-limit", "0"), "--time-limit"),
    "limit of a resumed run": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--time-limit", "9", "--resume"),
                               "exclude each other"),
    "error of plain hemispheres": ({}, (*FACTORS, "-o", "F.npz", "--error", "0.1"), "--error excludes --rays"),
    "seed of a fixed method": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--seed", "1", "--method", "shelling"),
                               "--seed excludes --method shelling"),
    "projection of adaptive rows": ({}, ("formfactors", "furnace:1", "-o", "F.npz", "--project"), "--project needs"),
    "resumed run that is none": ({"F.npz.blocks/run.json": "rubbish"}, (*FACTORS, "-o", "F.npz", "--resume"),
                                 "cannot be resumed"),
    "resumed run of something else": ({"F.npz.blocks/run.json": "{}"}, (*FACTORS, "-o", "F.npz", "--resume"),
                                      "other values of"),
    "unfinished run": ({"F.npz.blocks/run.json": "{}"}, (*FACTORS, "-o", "F.npz"), "continue it by --resume"),
    "rubbish as VS3": ({"a.vs3": "\0\1 rubbish"}, ("formfactors", "a.vs3", "-o", "F.npz"), "line 1"),
    "missing VS3": ({}, ("formfactors", "a.vs3", "-o", "F.npz"), "no such file"),
    "facets of rubbish as STL": ({"a.stl": "rubbish " * 30}, (*ADAPTIVE, "a.stl", "--facets"), "not a readable STL"),
    "error not a number": ({}, (*ADAPTIVE, "furnace:1", "--error", "nan"), "--error"),
    "error in words": ({}, (*ADAPTIVE, "furnace:1", "--error", "small"), "--error"),
    "no error of the sky": ({}, (*ADAPTIVE, "furnace:1", "--sky-error", "0"), "--sky-error"),
    "period of plain hemispheres": ({}, (*FACTORS, "-o", "F.npz", "--period", "9,9"), "--period excludes --rays"),
    "period below the scene's size": ({"a.vs3": VS3}, (*ADAPTIVE, "a.vs3", "--period", "0.5,9"),
                                      "--period: Period must be at least 1,1"),
    "period of two-sided patches": ({"a.obj": PENTAGON}, (*ADAPTIVE, "a.obj", "--period", "9,9"), "fronts alone"),
    "truncated factors that are not reciprocal": ({}, (*FACTORS, "-o", "F.npz", "--drop-below", "0.01"),
                                                  "--drop-below needs reciprocal factors"),
    "receivers without single rays": ({}, (*ADAPTIVE, "furnace:1", "--method", "shelling", "--receivers", "p", "r.csv"),
                                      "--receivers needs single rays"),
    "receivers that are no points": ({"p": "1 2 3"}, (*ADAPTIVE, "furnace:1", "--receivers", "p", "r.csv"),
                                     "p: line 1: Values must be the numbers"),
    "receivers in no table": ({"p": "0 0 0 0 0 1"}, (*ADAPTIVE, "furnace:1", "--receivers", "p", "r.nc"), ".csv"),
    "zenith of view factors without a sky": ({}, (*ADAPTIVE, "furnace:1", "--zenith", "0,0,1"),
                                             "--zenith needs --sky-patches or --period"),
    "zenith of an export that is none": ({}, ("scene", "cornell", "-o", "a.stl", "--zenith", "0,0,0"),
                                         "--zenith: Zenith must be three finite values"),
    "unknown division of the sky": ({}, (*ADAPTIVE, "furnace:1", "--sky-patches", "klems"), "--sky-patches"),
    "infinite time": ({}, (*ADAPTIVE, "furnace:1", "--time-limit", "inf"), "--time-limit"),
    "no workers": ({}, (*ADAPTIVE, "furnace:1", "--workers", "0"), "--workers"),
    "too many workers": ({}, (*ADAPTIVE, "furnace:1", "--workers", "257"), "--workers"),
    "workers by HTTP": ({}, (*ADAPTIVE, "furnace:1", "--workers", "http://localhost:8786"), "--workers"),
    "workers at no port": ({}, (*ADAPTIVE, "furnace:1", "--workers", "tls://localhost"), "--workers"),
    "workers far away by plain TCP": ({}, (*ADAPTIVE, "furnace:1", "--workers", "tcp://192.0.2.1:8786"), "tls://"),
    "view factors with an unknown ending of netCDF": ({}, (*FACTORS, "-o", "F.nc4"), "F.nc4"),
    "view factors of a case without a name": ({}, (*FACTORS, "-o", "vfsparse.inp."), "vfsparse.inp."),
    "areas over a folder": ({"facetarea.inp.1/a": ""}, (*FACTORS, "-o", "vfsparse.inp.1"), "facetarea.inp.1"),
    "blocks over a file": ({"F.npz.blocks": ""}, (*ADAPTIVE, "furnace:6", "--error", "0.1"), "F.npz.blocks"),
    "resumed run with other options": ({"F.npz.blocks/run.json": '{"error": 0.1}'},
                                       (*ADAPTIVE, "furnace:1", "--error", "0.05", "--resume"),
                                       "other values of block_rows, "),
    "size of a city": ({}, ("formfactors", "city:0", "-o", "F.npz"), "Size must be 1 to 20"),
    "exchange without view factors": ({"t.csv": ""}, EXCHANGE, "F.npz: no such file"),
    "exchange by rays": ({"F.npz": {"origin": [0.0]}, "t.csv": ""}, EXCHANGE, "F.npz: it holds no view factors"),
    "exchange by an archive that is none": ({"F.npz": "rubbish", "t.csv": ""}, EXCHANGE,
                                            "F.npz: it holds no view factors (it is no .npz archive)"),
    "exchange with the wrong ending": ({"F.npz": WALLS}, ("exchange", "F.npz", "t.csv", "-o", "q.txt"), ".csv"),
    "exchange without a table": ({"F.npz": WALLS}, EXCHANGE, "t.csv: cannot be read"),
    "exchange of an unknown surface": ({"F.npz": WALLS, "t.csv": HEAD + "x,3,1\n"}, EXCHANGE, "no surface 'x'"),
    "exchange of a surface twice": ({"F.npz": WALLS, "t.csv": HEAD + "a,3,1\na,3,1\n"}, EXCHANGE,
                                    "line 3: surface 'a' has a row already"),
    "exchange of some surfaces": ({"F.npz": WALLS, "t.csv": HEAD + "a,3,1\n"}, EXCHANGE, "no row for surface 'b'"),
    "emissivity above one": ({"F.npz": WALLS, "t.csv": HEAD + "a,3,1.5\nb,3,1\n"}, EXCHANGE,
                             "t.csv: line 2: surface 'a': Emissivity must be 0 to 1, not 1.5"),
    "neither temperature nor flux": ({"F.npz": WALLS, "t.csv": HEAD + "a,,1\nb,3,1\n"}, EXCHANGE,
                                         "t.csv: line 2: surface 'a': it must"),
    "sky below zero": ({"F.npz": WALLS, "t.csv": HEAD + "a,3,1\nb,3,1\n"}, (*EXCHANGE, "--sky-temperature", "-1"),
                       "--sky-temperature: Sky temperature"),
    "script-F with the wrong ending": ({"F.npz": WALLS}, (*EXCHANGE, "--script-f", "s.txt"), ".csv"),
    "exchange by netCDF that is none": ({"F.nc": "rubbish", "t.csv": HEAD},
                                        ("exchange", "F.nc", "t.csv", "-o", "q.csv"), "F.nc: it holds no view factors"),
    "exchange of a missing patch": ({"F.npz": WALLS, "t.csv": HEAD.replace("surface", "patch") + "5,3,1\n"}, EXCHANGE,
                                    "line 2: there is no patch '5'"),
    "flux beyond float64": ({"F.npz": WALLS, "t.csv": HEAD.strip() + ",flux\na,,1,1e300\nb,3,1,\n"}, EXCHANGE,
                            "at most 1e+100 W/m2"),
    "both temperature and flux": ({"F.npz": WALLS, "t.csv": HEAD.strip() + ",flux\na,3,1,1\nb,3,1,\n"}, EXCHANGE,
                                  "line 2: surface 'a': it must have either"),
    "flux below what arrives": ({"F.npz": WALLS, "t.csv": HEAD.strip() + ",flux\na,,1,-1e6\nb,3,1,\n"}, EXCHANGE,
                                "surface 'a': it cannot take in more than arrives: Flux is too low, not -1e+06"),
    "short row": ({"F.npz": WALLS, "t.csv": HEAD + "a,3\nb,3,1\n"}, EXCHANGE, "line 2: surface 'a' has no emissivity"),
    "column twice": ({"F.npz": WALLS, "t.csv": "surface,temperature,emissivity,surface\na,3,1,a\nb,3,1,b\n"}, EXCHANGE,
                     "each once"),
    "more values than names": ({"F.npz": WALLS, "t.csv": HEAD + "a,3,1,9\nb,3,1\n"}, EXCHANGE, "line 2: it has more"),
    "exchange where nothing can be written": ({}, ("exchange", "F.npz", "t.csv", "-o", "/sys/q.csv"),
                                              "/sys/q.csv': cannot be written"),
    "missing rays": ({}, ("intersect", "furnace", "rays.npz", "-o", "hits.npz"), "rays.npz"),
    "rays that are no archive": ({"rays.npz": "0 0 0"}, ("intersect", "furnace", "rays.npz", "-o", "hits.npz"),
                                 "'rays.npz': rays: not a .npz file\n"),
    "rays without direction": ({"rays.npz": {"origin": [[0.0, 0, 0]]}},
                               ("intersect", "furnace", "rays.npz", "-o", "hits.npz"), "direction"),
    "hits with the wrong ending": ({"rays.npz": {"origin": [[0.0, 0, 0]], "direction": [[0.0, 0, 1]]}},
                                   ("intersect", "furnace", "rays.npz", "-o", "hits.txt"), ".txt"),
}


def make(folder, files):
    for name, what in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        if isinstance(what, str):
            (folder / name).write_text(what)
        else:
            np.savez(folder / name, **what)


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_leaves_nothing_behind(folder, case):
    files, arguments, message = BAD[case]
    make(folder, files)
    before = content(folder)
    result = run(*arguments)
    refused(result.exit_code, result.stderr, message)
    assert result.stdout == ""
    assert content(folder) == before


def test_bad_input_to_the_module_is_one_line_and_leaves_nothing_behind(folder):
    files, arguments, message = BAD["unknown option"]
    make(folder, files)
    before = content(folder)
    result = subprocess.run([sys.executable, "-m", "golden", *arguments], capture_output=True, text=True, check=False)
    refused(result.returncode, result.stderr, message)
    assert content(folder) == before


@pytest.mark.nightly
@pytest.mark.parametrize("case", BAD)
def test_bad_input_takes_five_seconds_and_two_gigabytes_at_most(folder, case):
    """Seconds of the processor, of a new process with all that it imports."""
    files, arguments, message = BAD[case]
    make(folder, files)
    before = content(folder)
    with (folder.parent / f"{folder.name}.err").open("w+") as stderr:
        process = subprocess.Popen([sys.executable, "-m", "golden", *arguments], stdout=stderr, stderr=stderr)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        stderr.seek(0)
        refused(process.returncode, stderr.read(), message)
    assert content(folder) == before
    seconds = used.ru_utime + used.ru_stime
    assert seconds < 5
    assert used.ru_maxrss < 2_000_000


def test_intersect_of_no_rays_gives_no_hits(folder):
    np.savez(folder / "rays.npz", origin=np.empty((0, 3)), direction=np.empty((0, 3)))
    for method in RAY_METHODS:
        succeed("intersect", "furnace:1", "rays.npz", "-o", "hits.npz", "--method", method)
        with np.load(folder / "hits.npz") as hits:
            assert hits["patch"].shape == (0,)


def test_render_writes_all_requested_files(folder):
    text = succeed("render", "furnace:2", "-o", "a.png", "-o", "a.exr", "--stats", "a.json", "--heatmap", "a", *COARSE)
    assert {path.name for path in folder.iterdir()} == {"a.png", "a.exr", "a.json", "a-tests.png", "a-steps.png"}
    with Image.open(folder / "a.png") as image:
        assert image.size == (12, 8)
    assert read_exr(folder / "a.exr").shape == (8, 12, 3)
    stats = json.loads((folder / "a.json").read_text())
    assert stats["patches"] == 24
    assert stats["rays"]["primary"]["rays"] == 12 * 8
    for kind, counts in stats["rays"].items():
        assert counts["hits"] <= counts["rays"] <= counts["tests"]
        assert kind in text
    for stage in stats["seconds"]:
        assert stage in text


def test_render_has_a_sky(folder):
    """The sun of a summer's noon lights a floor in the open as its altitude says."""
    (folder / "floor.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nf 1 2 3 4\n")
    (folder / "points.txt").write_text("0.5 0.5 -0.5 0 1 0\n0.5 0.5 -0.5 0 0 1\n")
    succeed("render", "floor.obj", "-o", "a.png", "--sky", "cie-clear", "--date", "2026-06-21T13:16+02:00", "--place",
            "48,11", "--sensors", "points.txt", "--sensor-table", "s.csv", *FAST)
    with (folder / "s.csv").open(newline="") as file:
        level, south = (float(row["illuminance"]) for row in csv.DictReader(file))
    sine = np.sin(np.radians(90 - 48 + 23.44))
    sun = 127_500 * np.exp(-0.21 / sine)
    assert level == pytest.approx(sun * sine + 800 + 15_500 * np.sqrt(sine), rel=0.01)
    assert sun * np.sqrt(1 - sine**2) < south < level


@pytest.mark.parametrize(("words", "values"), [
    ((), (4, 1, 2, [32, 8], 300)), (("--quick",), (1, 4, 2, [32, 8], 3000)),
    (("--quality", "draft"), (1, 4, 2, [32, 8], 3000)), (("--quality", "normal"), (4, 2, 6, [256, 64], 3000)),
    (("--quality", "high"), (16, 16, 6, [256, 64], 3000)),
    (("--spp", "9", "--quick", "--rays", "16x4", "--elements", "7"), (9, 4, 2, [16, 4], 7))])
@pytest.mark.usefixtures("folder")
def test_a_quality_is_for_the_options_that_are_not_given(words, values):
    settings = json.loads(succeed("render", "furnace:1", "-o", "a.png", "--size", "2x2", "--max-edge", "9", "--method",
                                  "grid", *words, "--json"))["settings"]
    assert tuple(settings[name] for name in ("samples", "light_samples", "depth", "rays", "elements")) == values


def test_an_image_does_not_depend_on_what_is_measured(folder):
    (folder / "points.txt").write_text("0.5 0.5 0.5 0 0 1\n")
    succeed("render", "furnace:2", "-o", "a.exr", *COARSE)
    succeed("render", "furnace:2", "-o", "b.exr", "--false-colour", "b", "--sensors", "points.txt", *COARSE)
    assert (folder / "a.exr").read_bytes() == (folder / "b.exr").read_bytes()


def test_upper_case_suffixes_are_those_of_the_same_formats(folder):
    succeed("render", "furnace:2", "-o", "A.EXR", "-o", "A.PNG", *COARSE)
    assert read_exr(folder / "A.EXR").shape == (8, 12, 3)
    with Image.open(folder / "A.PNG") as image:
        assert image.format == "PNG"


def test_same_inputs_give_the_same_bytes_and_another_seed_others(folder):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        succeed("render", "cornell", "-o", f"{name}.png", "-o", f"{name}.exr", *COARSE, "--seed", seed)
    for ending in ("png", "exr"):
        first, second, other = ((folder / f"{name}.{ending}").read_bytes() for name in "abc")
        assert first == second
        assert first != other


def test_camera_of_a_file_is_used_and_each_option_overrides_its_part(folder):
    # Of coarser pictures no ray may hit the triangle.
    fine = (*COARSE, "--size", "24x16")
    (folder / "a.nff").write_text(NFF_VIEW.format(from_="1 2 5") + NFF_BODY)
    here = ("--eye", "1,2,5", "--target", "0,0,0", "--up", "0,0,1", "--fov", "40")
    succeed("render", "a.nff", "-o", "file.exr", *fine)
    succeed("render", "a.nff", "-o", "same.exr", *fine, *here)
    assert (folder / "file.exr").read_bytes() == (folder / "same.exr").read_bytes()
    for option in (("--eye", "1,2,4"), ("--target", "0,1,0"), ("--up", "0,1,0"), ("--fov", "50")):
        succeed("render", "a.nff", "-o", "other.exr", *fine, *option)
        assert (folder / "other.exr").read_bytes() != (folder / "file.exr").read_bytes(), option


def test_sky_is_seen_where_rays_leave_and_lights_a_scene_without_lights(folder):
    (folder / "a.obj").write_text(TRIANGLE + "f 1 2 3\n")
    succeed("render", "a.obj", "-o", "a.exr", *COARSE, "--sky", "1,2,4", "--eye", "0.3,0.3,5", "--target", "0.3,0.3,0",
            "--up", "0,1,0")
    image = read_exr(folder / "a.exr")
    np.testing.assert_array_equal(image[0, 0], [1, 2, 4])
    assert image[4, 6].max() > 0


@pytest.mark.parametrize("code", [0, 1, 3])
def test_a_command_ends_with_its_exit_code(code):
    @command_line("radiosity", is_script=False)
    def main():
        """Commands."""

    @main.command()
    @click.pass_context
    def ends(context):
        """End at once."""
        context.exit(code)

    assert CliRunner().invoke(main, ["ends"]).exit_code == code


def test_interruption_exits_with_130_and_leaves_nothing_behind(folder, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(radiosity.tasks.render, "render", interrupt)
    result = run(*RENDER)
    assert result.exit_code == 130
    assert "Traceback" not in result.stderr
    assert not list(folder.iterdir())


@pytest.mark.parametrize("failure", [OSError(errno.ENOSPC, "No space left on device"), MemoryError("12 GiB")])
def test_failure_of_the_system_is_one_line_and_leaves_nothing_behind(folder, monkeypatch, failure):
    def fail(_, path, **__):
        path.write_bytes(b"half")
        raise failure

    monkeypatch.setattr(Image.Image, "save", fail)
    result = run(*RENDER)
    refused(result.exit_code, result.stderr, "No space left" if isinstance(failure, OSError) else "not enough memory")
    assert not list(folder.iterdir())

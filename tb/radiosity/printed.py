"""What commands print and write, as values that a reader can compare.

tb/radiosity/printed.json lists commands with their results; `python -m tb.radiosity.printed` makes it anew: for a
change that is meant to change them, and says so.
"""

import contextlib
import json
import re
import tempfile
import zlib
from pathlib import Path

import numpy as np
from click.testing import CliRunner
from PIL import Image

import radiosity.cli
from golden.config import PRESETS
from golden.image import read_exr
from tb.golden.jobs.manifests import write_manifest
from tb.golden.scene.luminaires.texts import eulumdat, ies

__all__ = ["RECORD", "listed", "results", "write_inputs"]

RECORD = Path(__file__).parent / "printed.json"
# Lines of a text up to which it is listed whole, and characters of one of them.
_WHOLE, _LONG = 40, 240
_ROUNDING = 1e-13
# Members that differ from run to run, or from processor to processor, such as hashes of pictures of real numbers.
_MASKED = ("peak_memory", "seconds", "picture")

_SCENE = """mtllib scene.mtl
v 0 0 0\nv 2 0 0\nv 2 0 1\nv 0 0 1\nv 0 2 0\nv 2 2 0\nv 0.5 1 0.5\nv 1.5 1 0.5\nv 1 1.5 0.75
usemtl white\nf 1 4 3 2\nf 1 2 6 5
usemtl lamp\nf 7 8 9
usemtl mirror\nf 2 3 6
"""
_MATERIALS = """newmtl white\nKd 0.6 0.7 0.8\nnewmtl lamp\nKd 0 0 0\nKe 4 5 6\nnewmtl mirror\nKd 0.1 0.1 0.1
Ks 0.8 0.8 0.8\nillum 3\nNs 1000
"""
_NFF = """b 0.1 0.2 0.3\nv\nfrom 0 -4 2\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 16 12\nl 3 -3 4
f 0.8 0.5 0.2 0.7 0.3 10 0 1\np 4\n-2 -2 0\n2 -2 0\n2 2 0\n-2 2 0\ns 0 0 0.5 0.5
"""
_EXCHANGE = "surface,temperature,emissivity,flux\n0,300,0.8,\n1,,0.5,0\n2,500,0.9,\n3,,1,20\n4,350,0.7,\n5,400,0.6,\n"


def write_inputs(folder: Path) -> None:
    """Write the files that the commands read into a folder."""
    (folder / "scene.obj").write_text(_SCENE)
    (folder / "scene.mtl").write_text(_MATERIALS)
    (folder / "scene.nff").write_text(_NFF)
    (folder / "strange.obj").write_text(_SCENE.replace("f 7", "l 7 8\nf 7"))
    (folder / "exchange.csv").write_text(_EXCHANGE)
    (folder / "sensors.txt").write_text("1 1 0.2 0 0 1\nplane 0 0 0.1 2 0 0 0 2 0 2 3\n")
    (folder / "lamp.ies").write_text(ies(vertical=(0, 60, 90), horizontal=(0, 90), candela=[[100, 50, 5], [80, 40, 0]],
                                         size=(0.3, 0.2, 0.0), multiplier=2.0))
    (folder / "lamp.ldt").write_text(eulumdat(gamma=(0, 45, 90), candela=[[200, 100, 10]]))
    grid = np.stack(np.meshgrid(np.linspace(0.1, 1.9, 5), np.linspace(0.1, 1.9, 4), indexing="ij"), axis=-1)
    origin = np.concatenate([grid.reshape(-1, 2), np.full((20, 1), 3.0)], axis=1)
    direction = np.tile((0.1, 0.05, -1.0), (20, 1))
    np.savez(folder / "rays.npz", origin=origin, direction=direction)
    np.savez(folder / "shadow.npz", origin=origin, direction=direction, tmax=np.linspace(1.0, 5.0, 20))
    write_manifest(folder / "engine.json", PRESETS["tiny"])


def results(commands: list[str]) -> list[dict]:
    """What commands print and write that run one after the other in a folder of their own."""
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        folder = Path(name)
        write_inputs(folder)
        seen, found = set(_files(folder)), []
        for command in commands:
            done = CliRunner(env={"COLUMNS": "80"}).invoke(radiosity.cli.main, command.split())
            if done.exception is not None and not isinstance(done.exception, SystemExit):
                raise done.exception
            files = set(_files(folder))
            found.append({"exit": done.exit_code, "stdout": _printed(done.stdout), "stderr": listed(done.stderr),
                          "files": {str(path.relative_to(folder)): _content(path) for path in sorted(files - seen)}})
            seen = files
        return [{name: value for name, value in one.items() if value} for one in found]


def _files(folder):
    return (path for path in folder.rglob("*") if path.is_file())


def _rounded(value):
    """To six digits, so that the order of a sum does not count; times and sizes of this process are left out."""
    if isinstance(value, dict):
        return {name: "masked" if name in _MASKED else _rounded(one) for name, one in value.items()}
    if isinstance(value, list):
        return [_rounded(one) for one in value]
    return float(_number(value)) if isinstance(value, float) else value


def _number(value):
    """Six digits of a number, and 0 for what the rounding of sums leaves: each processor adds in another order."""
    return f"{value if abs(value) > _ROUNDING else 0:.6g}"


def listed(text):
    """The lines of a text without times, or their number and check sum if there are many."""
    text = re.sub(r"\d+\.\d+ s\b", "# s", text)
    text = re.sub(r"\b[0-9a-f]{64}\b", "#", text)
    # What `render` lists at the end.
    text = re.sub(r"^((?:seconds|  [a-z ]+[a-z]) +)(\d+\.\d\d)$",
                  lambda found: f"{found[1]}{' ' * (len(found[2]) - len('0.00'))}#", text, flags=re.MULTILINE)
    text = re.sub(r"-?\d+\.(\d{5,}(e[+-]\d+)?|\d+e-(1[4-9]|[2-9]\d))", lambda found: _number(float(found[0])), text)
    lines = text.splitlines()
    if len(lines) > _WHOLE:
        lines = [*lines[:8], f"... {len(lines)} lines, {zlib.crc32(text.encode()):08x}"]
    return [line if len(line) <= _LONG else f"{line[:60]} ... {zlib.crc32(line.encode()):08x}" for line in lines]


def _printed(text):
    return _rounded(json.loads(text)) if text.startswith("{") else listed(text)


def _content(path):
    """What a file holds."""
    match path.suffix:
        case ".npz":
            with np.load(path) as stored:
                return {name: _array(stored[name]) for name in sorted(stored.files)}
        case ".png":
            with Image.open(path) as picture:
                return _array(np.asarray(picture))
        case ".exr":
            return _array(read_exr(path))
        case ".bin" | ".glb" | ".nc" | ".stl":
            return f"{path.stat().st_size} bytes, {zlib.crc32(path.read_bytes()):08x}"
        case ".json":
            return _rounded(json.loads(path.read_text()))
        case _:
            return listed(path.read_text())


def _array(array):
    """Type, shape, and check sum of an array, or of real numbers two sums, the second of which sees their order."""
    if array.dtype.kind == "U":
        return listed(str(array))
    head = f"{array.dtype.str} {array.shape}"
    if array.dtype.kind != "f":
        return f"{head} {zlib.crc32(np.ascontiguousarray(array).tobytes()):08x}"
    flat = array.ravel().astype(np.float64)
    flat = flat[np.isfinite(flat)]
    return f"{head} {len(flat)} finite, {flat.sum():.6g}, {flat @ np.sqrt(1 + np.arange(len(flat))):.6g}"


if __name__ == "__main__":
    table = json.loads(RECORD.read_text())
    for row in table:
        row["results"] = results(row["commands"])
    text = json.dumps(table, indent=1, ensure_ascii=False)
    # Numbers of a list stand in one line.
    text = re.sub(r"\[\s+(-?[\d.e+-]+(?:,\s+-?[\d.e+-]+)*)\s+\]", lambda found: f"[{' '.join(found[1].split())}]", text)
    RECORD.write_text(text + "\n")

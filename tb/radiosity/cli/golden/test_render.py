"""The tables of ``render``: what is known of the light that patches and sensors receive."""

import csv

import numpy as np
import pytest

from tb.radiosity.cli.golden.runner import report

FAST = ("-o", "a.png", "--size", "2x2", "--spp", "1", "--depth", "1", "--rays", "16x4", "--method", "grid")
MATERIAL = "newmtl floor\nKd 0.5 0.5 0.5\n"
# An isotropic luminaire of 1000 cd.
LAMP = "TILT=NONE\n1 -1 1000 2 1 1 2 0 0 0\n1 1 9\n0 180\n0\n1 1\n"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.mtl").write_text(MATERIAL)
    (tmp_path / "lamp.ies").write_text(LAMP)
    return tmp_path


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def solid_angle(point, corners):
    """Of a triangle, by van Oosterom and Strackee."""
    a, b, c = ((corner - point) / np.linalg.norm(corner - point) for corner in np.array(corners, dtype=float))
    return 2 * np.arctan2(abs(np.dot(a, np.cross(b, c))), 1 + a @ b + b @ c + c @ a)


def test_the_mean_of_a_patch_is_that_of_its_area(folder):
    """A trapezoid whose elements are ten times as large at one end as at the other, where the lamp is.

    The flux that arrives is the lamp's intensity times the solid angle of the trapezoid.
    """
    corners = [(0, 0, 0), (0, 0, 4), (4, 0, 2.2), (4, 0, 1.8)]
    (folder / "a.obj").write_text("mtllib a.mtl\nusemtl floor\n" + "".join(
        "v {} {} {}\n".format(*corner) for corner in corners) + "f 1 2 3 4\n")
    lamp = np.array([3.5, 1, 2])
    report("render", "a.obj", *FAST, "--max-edge", "0.2", "--light-samples", "1", "--luminaire", "lamp.ies", "3.5,1,2",
           "--illuminance", "i.csv", "--efficacy", "100")
    row, back = rows(folder / "i.csv")
    area = 4 * (4 + 0.4) / 2
    assert (row["side"], back["side"], float(back["illuminance"])) == ("front", "back", 0)
    assert float(row["area"]) == pytest.approx(area)
    flux = 1000 * (solid_angle(lamp, corners[:3]) + solid_angle(lamp, [corners[0], *corners[2:]]))
    assert float(row["illuminance"]) == pytest.approx(flux / area, rel=0.03)
    # What a floor alone reflects; nothing comes back.
    assert float(row["radiosity"]) == pytest.approx(float(row["illuminance"]) / 2, rel=1e-6)


def test_sky_and_ground_light_sensors_by_the_share_that_they_see(folder):
    """Below an open sky of 9000 lx, above a ground that reflects 0.4 of it; a patch far away hides none of either."""
    (folder / "a.obj").write_text("v 0 90 0\nv 1 90 0\nv 1 90 -1\nv 0 90 -1\nf 1 2 3 4\n")
    (folder / "points.txt").write_text("0 0 0 0 1 0\n0 0 0 0 -1 0\n0 0 0 1 0 0\n0 0 0 0 0 1\n"
                                       "plane 0 0 0  1 0 0  0 0 -1  2 3\n")
    printed = report("render", "a.obj", *FAST, "--light-samples", "1", "--sky", "uniform", "--sky-illuminance", "9000",
                     "--ground", "0.4", "--north", "1,0,0", "--sensors", "points.txt", "--sensor-table", "s.csv")
    found = [float(row["illuminance"]) for row in rows(folder / "s.csv")]
    up, down = 9000, 0.4 * 9000
    assert found == pytest.approx([up, down, *[(up + down) / 2] * 2, *[up] * 6], rel=0.02)
    singles, plane = printed["sensors"]
    assert (plane["sensors"], plane["mean"]) == (6, pytest.approx(up, rel=0.02))
    assert singles["mean"] == pytest.approx(np.mean(found[:4]))

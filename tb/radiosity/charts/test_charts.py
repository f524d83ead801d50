"""Charts show values where they are: positions by hand from the size of the drawing."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from radiosity.charts.activity import write_activity
from radiosity.charts.chart import COLOURS, Line, ticks, write_chart

SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize(("top", "expected"), [
    (1.0, [0, 0.2, 0.4, 0.6, 0.8, 1.0]), (10.2, [0, 2, 4, 6, 8, 10]), (7, [0, 1, 2, 3, 4, 5, 6, 7]),
    (8, [0, 1, 2, 3, 4, 5, 6, 7, 8]), (1020, [0, 200, 400, 600, 800, 1000]), (45, [0, 10, 20, 30, 40])])
def test_ticks_are_round_and_at_most_eight_steps(top, expected):
    np.testing.assert_allclose(ticks(top), expected, atol=1e-9)


def test_a_line_has_its_points_in_the_frame(tmp_path):
    """The frame is from (60, 390) to (520, 40); x ends at 1.02 times the largest one."""
    path = tmp_path / "folder" / "chart.svg"
    write_chart(path, [Line(name="a < b", x=np.array([0.0, 50, 100]), y=np.array([0.0, np.nan, 2])),
                       Line(name="two", x=np.array([0.0, 25, 50]), y=np.array([1.0, 8, np.inf]), ends_at=51.0)],
                title="T & U", x_name="cycle", y_name="share", y_top=4.0)
    root = ElementTree.parse(path).getroot()
    assert root.get("viewBox") == "0 0 720 440"
    first, second = root.iter(f"{SVG}polyline")
    right = 60 + 460 / 1.02
    assert first.get("points") == f"60.0,390.0 {right:.1f},215.0"
    assert second.get("points") == f"60.0,302.5 {60 + 460 / 4.08:.1f},-310.0"
    assert [one.get("stroke") for one in (first, second)] == list(COLOURS[:2])
    assert {one.get("clip-path") for one in (first, second)} == {"url(#inside)"}
    clip = next(root.iter(f"{SVG}clipPath"))[0]
    assert [clip.get(name) for name in ("x", "y", "width", "height")] == ["60", "40", "460", "350"]
    marks = [one.get("d") for one in root.iter(f"{SVG}path") if one.get("fill")]
    assert marks == ["M290.0 390l-4 8h8z"]
    texts = {one.text: one for one in root.iter(f"{SVG}text")}
    assert {"T & U", "cycle", "share", "a < b", "two", "0", "20", "100", "4"} <= texts.keys()
    assert float(texts["100"].get("x")) == pytest.approx(right, abs=0.06)
    assert texts["100"].get("y") == "406"
    assert float(texts["3"].get("y")) == pytest.approx(390 - 350 * 3 / 4 + 4, abs=0.06)
    assert [texts[name].get("y") for name in ("a < b", "two")] == ["50", "68"]


def test_activity_has_a_lane_for_each_cluster(tmp_path):
    """From 70 to 790, 26 for each lane below 40; results are the lower part of a lane."""
    path = tmp_path / "activity.svg"
    casts = np.array([(1, 300, 400, 420), (0, 200, 600, 720), (1, 100, 300, 310)])
    write_activity(path, clusters=2, loads=np.array([(0, 90)]), casts=casts, title="job")
    root = ElementTree.parse(path).getroot()
    assert root.get("viewBox") == "0 0 900 162"
    bars = [[float(one.get(name)) for name in ("x", "y", "width", "height")] + [one.get("fill")]
            for one in [*root.iter(f"{SVG}rect")][1:8]]
    assert bars == [
        [70, 40, 90, 20, COLOURS[4]], [270, 66, 400, 14, COLOURS[0]], [670, 80, 120, 6, COLOURS[2]],
        [170, 92, 200, 14, COLOURS[0]], [370, 106, 10, 6, COLOURS[2]],
        [370, 92, 100, 14, COLOURS[5]], [470, 106, 20, 6, COLOURS[2]]]
    names = [one.text for one in root.iter(f"{SVG}text") if one.get("text-anchor") == "end"]
    assert names == ["loads", "cluster 0", "cluster 1"]
    assert re.search(r'<text x="170.0" y="134" text-anchor="middle">100</text>', path.read_text())


def test_a_bar_without_length_is_seen(tmp_path):
    path = tmp_path / "activity.svg"
    write_activity(path, clusters=1, loads=np.empty((0, 2)), casts=np.array([(0, 5, 5, 5)]), title="none")
    root = ElementTree.parse(path).getroot()
    assert [one.get("width") for one in root.iter(f"{SVG}rect")][1:3] == ["0.30", "0.30"]

"""Charts show values where they are, with the same bytes in every run."""

import matplotlib
import numpy as np
import pytest
from click.testing import CliRunner

from radiosity.charts.chart import COLOURS, Bars, Line, check_chart, lane_figure, line_figure, write_figure
from radiosity.cli.main import main as radiosity
from tb.radiosity.charts import rectangles

LINES = [Line(name="a < b", x=np.array([0.0, 50, 100]), y=np.array([0.0, np.nan, 2])),
         Line(name="two", x=np.array([0.0, 25, 50]), y=np.array([1.0, 8, np.inf]), ends_at=51.0)]


def lines():
    return line_figure(LINES, title="T & U", x_name="cycle", y_name="share", y_top=4.0)


def test_a_line_has_its_finite_points():
    axes, = lines().axes
    first, second, end = axes.lines
    assert first.get_xydata().tolist() == [[0, 0], [100, 2]]
    assert second.get_xydata().tolist() == [[0, 1], [25, 8]]
    assert end.get_xydata().tolist() == [[51, 0]]
    assert [one.get_color() for one in axes.lines] == [COLOURS[0], COLOURS[1], COLOURS[1]]
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, 102), (0, 4))
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["a < b", "two"]


def test_equal_values_give_equal_bytes_whatever_the_settings(tmp_path):
    write_figure(tmp_path / "folder" / "one.svg", lines())
    with matplotlib.rc_context({"svg.hashsalt": "other", "font.size": 20, "lines.marker": "o"}):
        write_figure(tmp_path / "two.svg", lines())
    text = (tmp_path / "folder" / "one.svg").read_text()
    assert text == (tmp_path / "two.svg").read_text()
    assert all(f">{name}</text>" in text for name in ("T &amp; U", "cycle", "share", "a &lt; b", "two", "20", "100"))
    assert "dc:date" not in text


def test_bars_are_in_their_lanes():
    bars = [Bars(lane=np.array([0]), begin=np.array([0]), end=np.array([90]), colour=COLOURS[4], name="load"),
            Bars(lane=np.array([2, 1]), begin=np.array([300, 200]), end=np.array([300, 600]), colour=COLOURS[0],
                 top=0.25, bottom=0.5),
            Bars(lane=np.array([], dtype=int), begin=np.array([]), end=np.array([]), colour=COLOURS[1])]
    axes, = lane_figure(["loads", "cluster 0", "cluster 1"], bars, title="job", x_name="cycle").axes
    assert [rectangles(patch).tolist() for patch in axes.patches] == [
        [[0, 90, 0.1, 0.9]], [[300, 300, 2.25, 2.5], [200, 600, 1.25, 1.5]], []]
    # A bar without a length is a stroke.
    assert axes.patches[1].get_linewidth() > 0
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, 600), (3, 0))
    assert [text.get_text() for text in axes.get_yticklabels()] == ["loads", "cluster 0", "cluster 1"]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["load"]


def test_a_chart_without_matplotlib_is_refused_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr("radiosity.charts.chart.find_spec", lambda name: None)
    check_chart(None)
    with pytest.raises(ModuleNotFoundError, match="matplotlib"):
        check_chart(tmp_path / "steps.svg")
    done = CliRunner().invoke(radiosity, ["machine", "torus", "spheres40", "--steps", str(tmp_path / "steps.svg")])
    assert done.stderr == ("error: matplotlib is not installed: `pip install radiosity-engine[plots]` installs it\n")
    assert done.exit_code == 2

"""The bar of a job in stages."""

import json
import time

import pytest

from golden.base.stage_progress import StageProgress

STAGES = {"first": 3.0, "second": 1.0}


def shown(capsys, monkeypatch, *, begin=-10.0, **options):
    """What a job of no time prints, as if it had begun so many seconds before."""
    now = time.time
    with StageProgress("job", STAGES, **options) as bar:
        # tqdm waits by this clock.
        monkeypatch.setattr("tqdm.std.time", lambda: now() - begin)
        bar._bar._time = lambda: now() - begin
        for name in STAGES:
            with bar.stage(name):
                pass
        if options.get("record"):
            bar.keep()
    return capsys.readouterr().err


def test_a_long_job_shows_its_stage_and_an_estimate(capsys, monkeypatch):
    text = shown(capsys, monkeypatch, shown=True)
    assert "job: second: 100%" in text
    assert "of about 4 s" in text


@pytest.mark.parametrize(("begin", "is_shown"), [(-10.0, False), (0.0, True)])
def test_a_short_or_silent_job_shows_nothing(capsys, monkeypatch, begin, is_shown):
    assert shown(capsys, monkeypatch, begin=begin, shown=is_shown) == ""


def test_the_last_durations_are_the_next_estimate(capsys, monkeypatch, tmp_path):
    record = tmp_path / "durations.json"
    record.write_text(json.dumps({"first": 100.0, "other": 7.0}))
    assert "of about 101 s" in shown(capsys, monkeypatch, shown=True, record=record)
    known = json.loads(record.read_text())
    assert known["first"] < 10
    assert known["other"] == 7.0


@pytest.mark.parametrize("content", [
    "", '{"first": 10', "[1]", "7", '{"first": "x"}', '{"first": -1}', '{"first": 1e400}', '{"first": NaN}', b"\xff"])
def test_durations_that_cannot_be_read_are_replaced(capsys, monkeypatch, tmp_path, content):
    record = tmp_path / "durations.json"
    record.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert "of about 4 s" in shown(capsys, monkeypatch, shown=True, record=record)
    assert json.loads(record.read_text()).keys() == STAGES.keys()


def test_durations_that_cannot_be_kept_stop_nothing(capsys, monkeypatch, tmp_path):
    assert "of about 4 s" in shown(capsys, monkeypatch, shown=True, record=tmp_path / "none" / "durations.json")


@pytest.mark.parametrize(("first", "total"), [(100.4, 101), (0.0, 1), (99.6, 101)])
def test_the_bar_ends_at_its_end_whatever_the_durations(capsys, monkeypatch, tmp_path, first, total):
    """Their sum is not a whole number of seconds; beyond the total tqdm warns."""
    record = tmp_path / "durations.json"
    record.write_text(json.dumps({"first": first, "second": 1.0 if first else 0.3}))
    text = shown(capsys, monkeypatch, shown=True, record=record)
    assert f"of about {total} s" in text
    assert "clamping" not in text


def test_a_failing_stage_ends_the_bar():
    with StageProgress("job", STAGES, shown=True) as bar, pytest.raises(OSError, match="no"), bar.stage("first"):
        raise OSError("no")
    assert not bar._taken

"""The table of what a run's time protects."""

from tb.lib.cpu_times import tenths


def test_tenths_share_out_all_seconds_from_the_largest_folder_on():
    rows = tenths({"small": 20.0, "large": 65.0, "tiny": 0.0, "middle": 15.0}).splitlines()[2:]
    assert len(rows) == 10
    assert rows[0] == "| 1 | `large` 10 s |"
    assert rows[6] == "| 7 | `large` 5 s, `small` 5 s |"
    assert rows[9] == "| 10 | `middle` 10 s |"
    assert not any("tiny" in row for row in rows)

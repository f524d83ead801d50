"""Every test module is in one shard."""

from pathlib import Path

from tb.runs.shard import shards

TB = Path(__file__).parents[1]


def test_shards_share_out_all_modules():
    files = [path for shard in shards(TB) for path in shard.files]
    assert sorted(files) == sorted(TB.rglob("test_*.py"))


def test_a_folder_is_cut_into_equal_parts(tmp_path):
    for name in ("a/test_0.py", "a/b/test_1.py", "a/test_2.py", "c/test_3.py", "c/help.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    found = {shard.name: {path.name for path in shard.files} for shard in shards(tmp_path, {"a": 2, "c": 5})}
    assert sorted(len(files) for name, files in found.items() if name.startswith("a/")) == [1, 2]
    assert found["c"] == {"test_3.py"}
    assert set(found) == {"a/1", "a/2", "c"}

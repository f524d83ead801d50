"""Every member of the scenes of small files of all formats."""

import json

import pytest

from tb.golden.scene.loaded import FILES, RECORD, loaded

RECORDED = json.loads(RECORD.read_text())


@pytest.mark.parametrize("name", FILES)
def test_the_scene_of_a_file(name):
    assert loaded(name) == RECORDED[name]


def test_all_files_are_recorded():
    assert set(FILES) == set(RECORDED)

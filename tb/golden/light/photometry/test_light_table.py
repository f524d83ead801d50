import csv
from types import SimpleNamespace

import numpy as np
import pytest

from golden.light.elements import Elements
from golden.light.photometry.light_table import patch_rows, write_table
from golden.scene.refine import refine
from tb.golden.light.scenes import BLACK, rectangle, scene_of

SCENE = scene_of((rectangle((0, 0, 0), (2, 0, 0), (0, 1, 0)), BLACK),
                 (rectangle((0, 0, 1), (1, 0, 0), (0, 1, 0)), BLACK, {"two_sided": True}))


def rows():
    """Of a first patch in two elements with the light 1 and 3, and of a second one with 5 in front and 7 behind."""
    elements = Elements(SCENE, refine(SCENE, max_edge=1.0))
    light = np.repeat([1.0, 3, 5, 7], 3).reshape(4, 3)
    return patch_rows(SCENE, SimpleNamespace(elements=elements, received=light, radiosity=light / 2), 100.0)


def test_values_are_means_over_the_elements_of_a_side():
    head, *found = rows()
    assert [row[:3] for row in found] == [(0, "front", "black"), (1, "front", "black"), (1, "back", "black")]
    assert [row[head.index("illuminance")] for row in found] == pytest.approx([200 * np.pi, 500 * np.pi, 700 * np.pi])
    assert [row[head.index("radiosity")] for row in found] == pytest.approx([100 * np.pi, 250 * np.pi, 350 * np.pi])


def test_rows_have_area_and_centre():
    head, first, *_ = rows()
    assert dict(zip(head, first, strict=True)) | {"area": 2, "x": 1, "y": 0.5, "z": 0} == dict(
        zip(head, first, strict=True))


def test_a_table_is_a_csv_with_a_head(tmp_path):
    write_table(tmp_path / "a.csv", rows())
    with (tmp_path / "a.csv").open(newline="") as file:
        stored = list(csv.DictReader(file))
    assert [row["side"] for row in stored] == ["front", "front", "back"]
    assert float(stored[2]["illuminance"]) == pytest.approx(700 * np.pi)

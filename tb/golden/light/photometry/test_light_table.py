import csv
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.light.elements import Elements
from golden.light.photometry.light_table import patch_rows, write_table
from golden.scene.refine import refine
from tb.golden.light.drawn_scenes import unequal_scenes
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.lib.schedules import SETTINGS

SCENE = scene_of((rectangle((0, 0, 0), (2, 0, 0), (0, 1, 0)), BLACK),
                 (rectangle((0, 0, 1), (1, 0, 0), (0, 1, 0)), BLACK, {"two_sided": True}))


def rows():
    """Of a first patch in two elements with the light 1 and 3, and of a second one with 5 in front and 7 behind."""
    elements = Elements(SCENE, refine(SCENE, max_edge=1.0))
    light = np.repeat([1.0, 3, 5, 7], 3).reshape(4, 3)
    return patch_rows(SCENE, SimpleNamespace(elements=elements, received=light, radiosity=light / 2), 100.0)


@settings(SETTINGS, max_examples=25)
@given(scene=unequal_scenes(), max_edge=st.sampled_from((0.4, 0.9, 9.0)), seed=st.integers(0, 9))
def test_means_of_elements_of_unequal_areas_keep_the_flux_of_each_side(scene, max_edge, seed):
    refinement = refine(scene, max_edge=max_edge)
    elements = Elements(scene, refinement)
    light = np.random.default_rng(seed).random((len(elements), 3))
    head, *found = patch_rows(scene, SimpleNamespace(elements=elements, received=light, radiosity=2 - light), 1.0)
    sides = [(patch, front) for patch in range(len(scene)) for front in (True, False)[:1 + scene.two_sided[patch]]]
    assert [row[:2] for row in found] == [(patch, "front" if front else "back") for patch, front in sides]
    a, b, c, d = np.moveaxis(elements.vertices[..., :2], 1, 0)
    # Half the product of the diagonals.
    area = np.abs((c - a)[:, 0] * (d - b)[:, 1] - (c - a)[:, 1] * (d - b)[:, 0]) / 2
    for row, (patch, front) in zip(found, sides, strict=True):
        own = (elements.patch == patch) & (elements.front == front)
        for name, values in (("illuminance", light), ("radiosity", 2 - light)):
            flux = area[own] @ values[own] @ (0.2126, 0.7152, 0.0722) * np.pi
            assert row[head.index(name)] * row[head.index("area")] == pytest.approx(flux, rel=1e-9)


def test_a_table_has_side_area_centre_and_mean_light_under_their_names(tmp_path):
    write_table(tmp_path / "a.csv", rows())
    with (tmp_path / "a.csv").open(newline="") as file:
        stored = list(csv.DictReader(file))
    assert [(row["patch"], row["side"], row["name"]) for row in stored] == [
        ("0", "front", "black"), ("1", "front", "black"), ("1", "back", "black")]
    for row, expected in zip(stored, ((2, 1, 0.5, 0, 200), (1, 0.5, 0.5, 1, 500), (1, 0.5, 0.5, 1, 700)), strict=True):
        *place, light = expected
        found = [float(row[name]) for name in ("area", "x", "y", "z", "illuminance", "radiosity")]
        assert found == pytest.approx([*place, light * np.pi, light / 2 * np.pi])

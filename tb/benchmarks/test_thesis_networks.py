"""Grades of the thesis' ratios."""

import pytest

from benchmarks.grades import grade
from benchmarks.thesis_networks import EDRC, THESIS, ratios_of, spread_of

pytestmark = pytest.mark.xdist_group("machines")


@pytest.mark.parametrize(("simulated", "thesis", "expected"), [
    (1.5, 1.67, "reproduced"), (1.2, 1.67, "same shape"), (0.95, 1.67, "not reproduced"),
    (1.01, 1.67, "not reproduced"), (0.99, 1.1, "not reproduced"), (1.0, 1.01, "reproduced"),
    (0.94, 1.1, "not reproduced"), (1.13, 1.01, "reproduced"),
    (0.6, 0.77, "same shape"), (1.3, 0.77, "not reproduced")])
def test_grades(simulated, thesis, expected):
    assert grade(simulated, thesis) == expected


def test_ratios_are_those_of_the_tables():
    lobby, room = (ratios_of(THESIS, scene) for scene in ("lobby", "room1627"))
    assert [round(lobby[name], 2) for name in ("torus, 8 : 16", "ring, 8 : 16")] == [1.67, 1.20]
    assert round(room["torus, 8 : 16"], 2) == 0.77
    assert 1 < room["hypercube : torus, 16"] < room["Illiac : torus, 16"] < room["ring : torus, 16"]


def test_spreads_are_those_of_the_tables():
    lobby, room = (spread_of(EDRC, scene) for scene in ("lobby", "room1627"))
    assert [round(ratio, 1) for ratio in lobby.values()] == [1.7, 6.5, 9.1]
    assert [round(ratio, 1) for ratio in room.values()] == [1.8, 3.3, 7.9]

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError, InputWarning
from golden.scene.luminaires.ies import read_ies
from tb.golden.scene.luminaires.texts import ies, ies_dialects
from tb.golden.scene.luminaires.webs import folded, symmetric_tables
from tb.lib.schedules import SETTINGS


def candela(text):
    """By C angle the intensities of the file."""
    found = read_ies(text.encode())
    return dict(zip(found.planes.tolist(), found.candela.tolist(), strict=True))


@pytest.mark.parametrize(("edition", "lamp", "factor"), [
    ("IESNA:LM-63-2002", 1.1, 1.1), ("IESNA91", 1.1, 1.1), ("IES:LM-63-2019", 1.111, 1),
    ("\n \nIES:LM-63-2019", 1.111, 1)])
def test_the_type_of_generation_of_an_edition_is_no_factor(edition, lamp, factor):
    assert candela(ies(lamp=lamp).replace("IESNA:LM-63-2002", edition)) == {0: pytest.approx([100 * factor] * 3)}


def test_multiplier_and_both_ballast_factors_scale_the_intensities():
    assert candela(ies(multiplier=2, ballast=0.5)) == {0: [100, 100, 100]}
    assert candela(ies(multiplier=3, ballast=0.5, lamp=0.75)) == {0: [112.5, 112.5, 112.5]}
    assert candela(ies(multiplier=3)) == {0: [300, 300, 300]}


@pytest.mark.filterwarnings("ignore:its commas are taken for decimal points$")
@pytest.mark.parametrize("examples", [60, pytest.param(500, marks=pytest.mark.nightly)])
def test_symmetric_lights_are_completed_with_any_factors_and_units_in_every_dialect(examples):
    @settings(SETTINGS, max_examples=examples)
    @given(table=symmetric_tables(), multiplier=st.sampled_from((1.0, 2.0)), ballast=st.sampled_from((0.5, 1.0)),
           unit=st.sampled_from((1, 2)), write=ies_dialects())
    def completes(table, multiplier, ballast, unit, write):
        mirrors, (gamma, planes, values) = table["mirrors"], (table[name] for name in ("gamma", "planes", "candela"))
        text = ies(vertical=gamma, horizontal=planes, candela=np.array(values, dtype=float) + 0.25, unit=unit,
                   multiplier=multiplier, ballast=ballast, size=(1.0, 2.0, 0.0))
        found = read_ies(write(text))
        assert found.planes.tolist() == list(range(0, 361, planes[1] - planes[0]))
        expected = [values[planes.index(folded(mirrors, plane))] for plane in found.planes.astype(int).tolist()]
        np.testing.assert_allclose(found.candela, (np.array(expected) + 0.25) * multiplier * ballast)
        assert found.opening == pytest.approx((2, 1) if unit == 2 else (0.6096, 0.3048))
    completes()


@pytest.mark.parametrize(("horizontal", "values", "whole"), [
    ((0,), [1], {0: 1}), ((0, 60, 180), [1, 2, 3], {0: 1, 60: 2, 180: 3, 300: 2, 360: 1}),
    ((0, 90, 200, 360), [1, 2, 3, 1], {0: 1, 90: 2, 200: 3, 360: 1})])
def test_planes_may_be_unevenly_spaced_or_one(horizontal, values, whole):
    rows = np.repeat(np.array(values, dtype=float), 3).reshape(-1, 3)
    assert {plane: row[0] for plane, row in candela(ies(horizontal=horizontal, candela=rows)).items()} == whole


OLD, SINCE_2002 = ("IESNA91", "IESNA:LM-63-1995"), ("IESNA:LM-63-2002", "IES:LM-63-2019")


@pytest.mark.filterwarnings("ignore:not used. height of the luminous opening$")
@pytest.mark.parametrize(("editions", "size", "opening", "is_round"), [
    ((*OLD, *SINCE_2002), (3, 4, 0), (4, 3), False), ((*OLD, *SINCE_2002), (3, 4, 2), (4, 3), False),
    (OLD, (-3, 0, 0), (3, 3), True), (OLD, (-3, 0, 2), (3, 3), True), (OLD, (-3, 4, 0), (4, 3), True),
    (OLD[1:], (-3, 0, -3), (3, 3), True), (OLD[1:], (-3, 4, -2), (4, 3), True),
    (OLD[1:], (0, 4, -3), (4, 3), False), (OLD[1:], (4, 0, -3), (3, 4), False),
    (SINCE_2002, (-3, -3, 0), (3, 3), True), (SINCE_2002, (-3, -4, 0), (4, 3), True),
    (SINCE_2002, (-3, -3, 2), (3, 3), True), (SINCE_2002, (-3, -4, -3), (4, 3), True),
    (SINCE_2002, (-3, 4, -3), (4, 3), False), (SINCE_2002, (3, -4, -4), (4, 3), False),
    (SINCE_2002, (-3, 0, -3), (0, 3), False), (SINCE_2002, (-3, 0, 0), (3, 3), True),
    (SINCE_2002, (0, 4, -3), (4, 0), False)])
def test_negative_sizes_mean_the_shapes_of_their_edition(editions, size, opening, is_round):
    """The level outline of each shape: ellipses for what is round seen from below, rectangles for what lies."""
    for edition in editions:
        text = ies(size=size, lamp=1).replace("IESNA:LM-63-2002", edition)
        found = read_ies(text.encode())
        assert (found.opening, found.is_round) == (opening, is_round), edition


def test_a_tilt_is_read_over_with_a_warning():
    text = ies().replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8")
    with pytest.warns(InputWarning, match="lamp's tilt"):
        assert candela(text) == {0: [100, 100, 100]}


@pytest.mark.parametrize(("text", "message"), [
    ("", "it has no line TILT="), ("IESNA:LM-63-2002\n[TEST]\n", "it has no line TILT="),
    ("TILT=NONE\n", "the file ends before lamps"), (ies(kind=2), "Photometric type must be 1"),
    (ies(unit=3), "Type of units must be"), (ies(horizontal=(0, 120)), "Horizontal angles must be 0 alone"),
    (ies(horizontal=(90, 150, 210, 270), candela=np.ones((4, 3))), "must have 180 among them"),
    (ies().replace("100.0 100.0 100.0", "100.0 100.0"), "the file ends before candela values"),
    (ies().replace("0 45 90", "0 x 90"), "line 6: Vertical angles must be a finite number, not 'x'"),
    (ies().replace("1.0 3 1", "1.0 0 1"), "line 4: Number of vertical angles must be a whole number of 1"),
    (ies().replace("1.0 3 1", "1.0 99999999 1"), "Number of vertical angles must be a whole number"),
    (ies().replace("1.0 3 1", "1.0 3 4000"), "the file ends before horizontal angles"),
    (ies(multiplier=1e31), "line 4: Candela multiplier must be at most 1e.30, not 1e.31"),
    (ies().replace("1 1000", "1 nan"), "Lamps and their lumens must be a finite number, not 'nan'")])
def test_bad_texts_are_one_line(text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_ies(text.encode())
    assert "\n" not in str(caught.value)

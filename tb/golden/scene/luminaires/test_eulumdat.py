import numpy as np
import pytest

from golden.errors import InputError
from golden.scene.luminaires.eulumdat import read_eulumdat
from tb.golden.scene.luminaires.texts import eulumdat

EIGHT = tuple(range(0, 360, 45))


def first(text):
    """By C angle the intensity of the axis."""
    found = read_eulumdat(text)
    return {plane: row[0] for plane, row in zip(found.planes.tolist(), found.candela.tolist(), strict=True)}


def rows(*values):
    return np.repeat(np.array(values, dtype=float), 3).reshape(-1, 3)


def test_intensities_are_per_thousand_lumens():
    assert first(eulumdat(flux=2500, factor=2)) == {0: 500}


@pytest.mark.parametrize(("symmetry", "values", "whole"), [
    (0, (1, 2, 3, 4, 5, 6, 7, 8), (1, 2, 3, 4, 5, 6, 7, 8, 1)), (2, (1, 2, 3, 4, 5), (1, 2, 3, 4, 5, 4, 3, 2, 1)),
    # Planes 270, 315, 0, 45, 90, and the mirror image about C90 and C270.
    (3, (1, 2, 3, 4, 5), (3, 4, 5, 4, 3, 2, 1, 2, 3)), (4, (1, 2, 3), (1, 2, 3, 2, 1, 2, 3, 2, 1))])
def test_symmetric_lights_are_completed(symmetry, values, whole):
    found = first(eulumdat(symmetry=symmetry, planes=EIGHT, candela=rows(*values)))
    assert found == dict(zip((*EIGHT, 360), whole, strict=True))


@pytest.mark.parametrize(("size", "opening"), [((1200, 600), (0.6, 1.2)), ((300, 0), (0.3, 0.3)), ((0, 0), (0, 0))])
def test_the_opening_is_in_metres_with_its_length_along_c90(size, opening):
    assert read_eulumdat(eulumdat(size=size)).opening == pytest.approx(opening)


def test_the_first_of_several_sets_of_lamps_counts_and_decimal_commas_do():
    assert first(eulumdat(sets=3, flux="2000,0")) == {0: 200}


@pytest.mark.parametrize(("text", "message"), [
    ("", "line 0: the file ends before line 3"), ("a\n1\n", "the file ends before line 3"),
    (eulumdat(symmetry=5), "line 3: Symmetry must be 0 to 4, not 5"),
    (eulumdat(symmetry="x"), "line 3: it must be a whole number, not 'x'"),
    (eulumdat(symmetry=1.5), "line 3: it must be a whole number"),
    (eulumdat(symmetry=4, planes=EIGHT[:6]), "Number of C planes must be a multiple of 4"),
    (eulumdat(flux="bright"), "line 29: it must be a finite number, not 'bright'"),
    (eulumdat(size=(-1, 0)), "line 16: Sizes of the luminous area must be"),
    (eulumdat(candela=[[1.0, 2.0]]), "the file ends before intensities"),
    (eulumdat(candela=[["a", "b", "c"]]), "line 47: Intensities must be a finite number, not 'a'"),
    (eulumdat(sets=0), "Number of sets of lamps must be 1 to 20")])
def test_bad_texts_are_one_line(text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_eulumdat(text)
    assert "\n" not in str(caught.value)

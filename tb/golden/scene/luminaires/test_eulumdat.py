import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.scene.luminaires.eulumdat import read_eulumdat
from tb.golden.scene.luminaires.texts import eulumdat, eulumdat_dialects
from tb.golden.scene.luminaires.webs import folded, symmetric_tables
from tb.lib.schedules import SETTINGS

EIGHT = tuple(range(0, 360, 45))


def first(text):
    """By C angle the intensity of the axis."""
    found = read_eulumdat(text.encode())
    return {plane: row[0] for plane, row in zip(found.planes.tolist(), found.candela.tolist(), strict=True)}


@pytest.mark.filterwarnings("ignore:not used. sets of lamps beside the first")
@pytest.mark.parametrize("examples", [60, pytest.param(500, marks=pytest.mark.nightly)])
def test_symmetric_lights_are_completed_with_any_lamps_and_factors_in_every_dialect(examples):
    @settings(SETTINGS, max_examples=examples)
    @given(table=symmetric_tables(), sets=st.integers(1, 3), flux=st.sampled_from((500.0, 2000.0)),
           factor=st.sampled_from((0.5, 1.0)), write=eulumdat_dialects())
    def completes(table, sets, flux, factor, write):
        mirrors, (gamma, planes, candela) = table["mirrors"], (table[name] for name in ("gamma", "planes", "candela"))
        symmetry = {(): 0, ("C0",): 2, ("C90",): 3, ("C0", "C90"): 4}[mirrors]
        step = planes[1] - planes[0]
        # With symmetry 3 the file has C270 over C0 to C90: mirror images of C270 to C90.
        given = {0: candela[:-1], 3: candela[::-1]}.get(symmetry, candela)
        text = eulumdat(symmetry=symmetry, planes=range(0, 360, step), gamma=gamma, sets=sets, flux=flux,
                        candela=np.array(given, dtype=float) + 0.25, factor=factor)
        found = read_eulumdat(write(text))
        assert found.gamma.tolist() == gamma
        assert found.planes.tolist() == list(range(0, 361, step))
        expected = [candela[planes.index(folded(mirrors, plane))] for plane in range(0, 361, step)]
        np.testing.assert_allclose(found.candela, (np.array(expected) + 0.25) * factor * flux / 1000)
    completes()


@pytest.mark.parametrize("count", [4, 8, 24])
@pytest.mark.parametrize(("symmetry", "centres", "given"), [(2, {180}, 1 / 2), (3, {90, 270}, 1 / 2), (4, {90}, 1 / 4)])
def test_a_light_is_mirrored_at_a_plane_that_is_given(count, symmetry, centres, given):
    """The C angles are evenly spaced but for one."""
    even, candela = np.arange(count) * 360 / count, np.ones((int(count * given) + 1, 3))
    for moved in range(1, count):
        planes = even + (np.arange(count) == moved) * 90 / count
        text = eulumdat(symmetry=symmetry, planes=planes.tolist(), candela=candela).encode()
        if even[moved] in centres:
            with pytest.raises(InputError, match=rf"^line {43 + moved}: C angle {moved + 1} of {count} must be "
                                                 rf"{even[moved]:g} with symmetry {symmetry}, not {planes[moved]:g}$"):
                read_eulumdat(text)
        else:
            found = read_eulumdat(text).planes
            assert (np.diff(found) > 0).all()
            assert (found[0], found[-1], len(found)) == (0, 360, count + 1)
            axis = 180 if symmetry == 3 else 360
            assert np.isin((axis - found) % 360, found % 360).all()


@pytest.mark.parametrize(("size", "opening", "is_round"), [
    ((1200, 600), (0.6, 1.2), False), ((600, 600), (0.6, 0.6), False), ((300, 0), (0.3, 0.3), True),
    ((0, 0), (0, 0), True)])
def test_the_opening_is_in_metres_with_its_length_along_c90_and_round_without_a_width(size, opening, is_round):
    found = read_eulumdat(eulumdat(size=size).encode())
    assert found.opening == pytest.approx(opening)
    assert found.is_round == is_round


@pytest.mark.parametrize(("text", "message"), [
    ("", "line 0: the file ends before line 3"), ("a\n1\n", "the file ends before line 3"),
    (eulumdat(symmetry=5), "line 3: Symmetry must be 0 to 4, not 5"),
    (eulumdat(symmetry="x"), "line 3: it must be a whole number, not 'x'"),
    (eulumdat(symmetry=1.5), "line 3: it must be a whole number"),
    (eulumdat(symmetry=4, planes=EIGHT[:6]), "Number of C planes must be a multiple of 4"),
    (eulumdat(flux=1e31), "line 29: it must be at most 1e.30, not 1e.31"),
    (eulumdat(flux="bright"), "line 29: it must be a finite number, not 'bright'"),
    (eulumdat(size=(-1, 0)), "line 16: Sizes of the luminous area must be"),
    (eulumdat(candela=[[1.0, 2.0]]), "the file ends before intensities"),
    (eulumdat(candela=[["a", "b", "c"]]), "line 47: Intensities must be a finite number, not 'a'"),
    (eulumdat(sets=0), "Number of sets of lamps must be 1 to 20")])
def test_bad_texts_are_one_line(text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_eulumdat(text.encode())
    assert "\n" not in str(caught.value)

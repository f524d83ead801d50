import numpy as np
import pytest

from golden.light.factors.sky_division import SkyDivision


def direction(altitude, azimuth):
    """Of angles in degrees, the azimuth from the north to the east."""
    altitude, azimuth = np.radians(altitude), np.radians(azimuth)
    return np.stack(np.broadcast_arrays(np.cos(altitude) * np.sin(azimuth), np.cos(altitude) * np.cos(azimuth),
                                        np.sin(altitude)), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize(("name", "count"), [("tregenza", 145), ("reinhart", 577)])
def test_patches_above_the_horizon(name, count):
    division = SkyDivision(name)
    assert len(division) == count + 1
    random = np.random.default_rng(1).normal(size=(200_000, 3))
    numbers = division.numbers(random / np.linalg.norm(random, axis=1, keepdims=True))
    assert np.unique(numbers).tolist() == list(range(count + 1))
    assert (numbers == 0).mean() == pytest.approx(0.5, abs=0.01)


def test_numbers_by_tregenza():
    division = SkyDivision("tregenza")
    assert division.numbers(direction(6, [0, -5, 7, 90, 354])).tolist() == [1, 1, 2, 9, 1]
    assert division.numbers(direction([18, 66, 78], 0)).tolist() == [31, 127, 139]
    assert division.numbers(direction([83, 85, 90], 40)).tolist() == [139 + 1, 145, 145]
    assert division.numbers(direction([-1e-9, -90], 0)).tolist() == [0, 0]


@pytest.mark.parametrize(("name", "parts"), [("tregenza", 1), ("reinhart", 2)])
def test_patches_end_at_their_heights_and_azimuths(name, parts):
    """A millionth of a degree on either side of each border of each band, the north among them."""
    division, first = SkyDivision(name), 1
    counts = np.repeat([30, 30, 24, 24, 18, 12, 6], parts) * parts
    height = 90 / (len(counts) + 0.5)
    for band, count in enumerate(counts.tolist()):
        borders = (np.arange(count) + 0.5) * 360 / count
        for altitude in (band * height + 1e-6, (band + 1) * height - 1e-6):
            before, behind = (division.numbers(direction(altitude, borders + step)) for step in (-1e-6, 1e-6))
            assert before.tolist() == [first + sector for sector in range(count)]
            assert behind.tolist() == [first + (sector + 1) % count for sector in range(count)]
        first += count
    assert division.numbers(direction(90 - height / 2 + 1e-6, [0, 123, 359])).tolist() == [first] * 3


def test_places_do_not_leave_the_division():
    assert SkyDivision("tregenza").numbers(np.array([(0.0, 0, 1 + 1e-15), (0, -1, 0), (-1e-300, -1, 0)])).tolist() == [
        145, 16, 16]

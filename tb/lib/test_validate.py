import enum

import pytest

from hw.lib.validate import check_instance, check_integer, check_power_of_two


class Answer(enum.Enum):
    YES = 0


@pytest.mark.parametrize(("bounds", "value"), [
    ({}, -5), ({"minimum": 1}, 1), ({"maximum": 8}, 8), ({"minimum": 1, "maximum": 8}, 3)])
def test_an_integer_of_the_range_passes(bounds, value):
    check_integer("Depth", value, **bounds)


@pytest.mark.parametrize(("bounds", "value", "message"), [
    ({"minimum": 1}, 0, "Depth must be at least 1, not 0"), ({"maximum": 8}, 9, "Depth must be at most 8, not 9"),
    ({"minimum": 1, "maximum": 8}, 0, "Depth must be from 1 to 8, not 0")])
def test_an_integer_out_of_range(bounds, value, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        check_integer("Depth", value, **bounds)


@pytest.mark.parametrize("value", ["2", 2.0, None, True])
def test_no_integer(value):
    with pytest.raises(TypeError, match=f"^Depth must be at least 1, not {value!r}$"):
        check_integer("Depth", value, minimum=1)
    with pytest.raises(TypeError, match=f"^Depth must be an integer, not {value!r}$"):
        check_integer("Depth", value)
    with pytest.raises(TypeError, match=f"^Depth must be a power of two, at least 1, not {value!r}$"):
        check_power_of_two("Depth", value)


@pytest.mark.parametrize("value", [1, 2, 4, 64])
def test_a_power_of_two_passes(value):
    check_power_of_two("Depth", value, maximum=64)


@pytest.mark.parametrize("value", [-4, 0, 1, 3, 12, 128])
def test_no_power_of_two(value):
    with pytest.raises(ValueError, match=f"^Depth must be a power of two, from 2 to 64, not {value}$"):
        check_power_of_two("Depth", value, minimum=2, maximum=64)


def test_an_instance():
    check_instance("Answer", Answer.YES, Answer)
    with pytest.raises(TypeError, match=r"^Answer must be an Answer, not 0$"):
        check_instance("Answer", 0, Answer)

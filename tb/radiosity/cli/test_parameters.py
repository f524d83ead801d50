"""Numbers of options: how many there are, and the least and the most that each may be, themselves included."""

import click
import pytest

import radiosity.cli.golden.main
import radiosity.cli.hw.main
import radiosity.cli.main
from radiosity.cli.parameters import FiniteRange, Numbers
from radiosity.cli.workers import Workers


@pytest.mark.parametrize("least", [0, -2.5, 3])
@pytest.mark.parametrize("at", range(3))
def test_the_least_number_is_accepted_and_none_below_it(least, at):
    numbers = [least + 1.0, least + 2.0, least + 3.0]
    numbers[at] = least
    kind = Numbers("R,G,B", least=least)
    assert kind.convert(",".join(map(str, numbers)), None, None) == tuple(numbers)
    numbers[at] = least - 2**-40
    with pytest.raises(click.BadParameter, match=f"three finite numbers of at least {least:g} like R,G,B"):
        kind.convert(",".join(map(repr, numbers)), None, None)


@pytest.mark.parametrize("text", ["1,2", "1,2,3,4", "1,2,x", "1,2,", "nan,1,2", "1,inf,2", "1,2,-inf", ""])
def test_other_texts_are_refused(text):
    with pytest.raises(click.BadParameter, match="is not three finite numbers like X,Y,Z"):
        Numbers().convert(text, None, None)


RANGES = {f"{name} {option.opts[0]}": option
          for main in (radiosity.cli.main.main, radiosity.cli.golden.main.main, radiosity.cli.hw.main.main)
          for name, command in main.commands.items() for option in command.params
          if isinstance(option.type, click.FloatRange)}


@pytest.mark.parametrize("option", RANGES.values(), ids=RANGES.keys())
@pytest.mark.parametrize("text", ["nan", "-nan", "inf", "-inf", "1e999"])
def test_a_range_of_any_command_is_of_finite_numbers(option, text):
    with pytest.raises(click.BadParameter):
        option.type.convert(text, option, None)


@pytest.mark.parametrize("bounds", [{}, {"min": 0}, {"max": 0}, {"min": 0, "max": 1}])
def test_a_finite_range_has_its_bounds(bounds):
    kind = FiniteRange(**bounds)
    assert kind.convert("0", None, None) == 0
    for text in "nan", "inf", "-inf", "1.5" if "max" in bounds else "nan", "-0.5" if "min" in bounds else "nan":
        with pytest.raises(click.BadParameter):
            kind.convert(text, None, None)


@pytest.mark.parametrize("count", [1, 256])
def test_the_fewest_and_the_most_processes_are_accepted(count):
    """One less and one more are refused as uses of the command line."""
    assert Workers().convert(str(count), None, None) == count

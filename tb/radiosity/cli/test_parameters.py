"""Numbers of options: how many there are, and the least and the most that each may be, themselves included."""

import click
import pytest

from radiosity.cli.parameters import Numbers
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


@pytest.mark.parametrize("count", [1, 256])
def test_the_fewest_and_the_most_processes_are_accepted(count):
    """One less and one more are refused as uses of the command line."""
    assert Workers().convert(str(count), None, None) == count

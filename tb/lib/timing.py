"""What a component's docstring says of its timing.

`tb.lib.bench` predicts transfers from these sentences of the section ``Timing``:

* ``Latency: ``formula`` cycles``;
* ``One item per cycle``, ``an item every four cycles``, ``one item per ``formula`` cycles``, of whatever the items are;
* ``nothing stalls``: an `Elastic` stage of any capacity;
* ``stalls while the item at the end waits``: a `Rigid` stage; ``and a register enables all others``: the last of its
  cycles is a skid buffer's;
* ```formula`` items in flight``: an `Elastic` stage of this capacity.
"""

import inspect
import re

from golden.engine.config import Config
from tb.lib.stages import Elastic, Rigid, Stage

__all__ = ["documented_interval", "documented_latency", "documented_stages"]

_NUMBERS = {"one": 1, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6}


def documented_latency(component: type, config: Config, **more: int) -> int:
    """The value of the formula in the line ``Latency:`` of a component's docstring, for a configuration.

    The formula is Python, with the parameters of `Config` by name, ``bits(n)`` for the bits of n, other arguments
    of the component as they are unless given, and ``more``.

    Raises
    ------
    AssertionError
        The docstring has no such line.
    """
    found = re.search(r"Latency: ``(.+?)``", inspect.getdoc(component) or "", re.DOTALL)
    assert found, f"{component.__name__} does not say its latency"
    return _value(found[1], component, config, more)


def documented_interval(component: type, config: Config, **more: int) -> int:
    """Cycles from an item to the next one, as the docstring says; 1 if it does not.

    Parameters
    ----------
    more
        See `documented_latency`.
    """
    found = re.search(r"\b(?:one|an?) \w+ (?:per|every) (?:``(.+?)`` |(\w+) )?(cycle|interval)", _timing(component),
                      re.IGNORECASE)
    if found is None:
        return 1
    formula, word, unit = found.groups()
    count = _value(formula, component, config, more) if formula else _NUMBERS[word or "one"]
    return count * (_value("interval", component, config, more) if unit == "interval" else 1)


def documented_stages(component: type, config: Config, **more: int) -> list[Stage]:
    """The stages between the input and the output of a component, as its docstring says.

    Parameters
    ----------
    more
        See `documented_latency`.

    Raises
    ------
    AssertionError
        The docstring says nothing that this module knows.
    """
    text, latency = _timing(component), documented_latency(component, config, **more)
    if re.search("(nothing|never) stalls?", text):
        return [Elastic(latency)]
    if re.search(r"stalls while the \w+ at the end waits", text):
        return [Rigid(latency - 1), Elastic(1, 2)] if "a register enables all others" in text else [Rigid(latency)]
    found = re.search(r"(?:``([^`]+)``|(\w+)) \w+ (?:are )?in flight", text)
    assert found, f"{component.__name__} does not say when it stalls"
    return [Elastic(latency, _value(found[1], component, config, more) if found[1] else _NUMBERS[found[2]])]


def _timing(component):
    """The section ``Timing``, in one line."""
    found = re.search(r"^Timing\n-+\n(.+?)(?:\n\n|\Z)", inspect.getdoc(component) or "", re.DOTALL | re.MULTILINE)
    return " ".join(found[1].split()) if found else ""


def _value(formula, component, config, more):
    parameters = {path.partition(".")[2]: value for path, value in config.parameters().items()}
    arguments = {name: argument.default for name, argument in inspect.signature(component).parameters.items()
                 if isinstance(argument.default, int)}
    functions = {"bits": lambda number: int(number).bit_length(), "max": max, "min": min}
    names = {**functions, **arguments, **parameters, **more}
    return eval(" ".join(formula.split()), {"__builtins__": {}}, names)

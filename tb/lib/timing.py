"""What a component's docstring says of its timing."""

import inspect
import re

from golden.config import Config

__all__ = ["documented_latency"]


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
    parameters = {path.partition(".")[2]: value for path, value in config.parameters().items()}
    arguments = {name: argument.default for name, argument in inspect.signature(component).parameters.items()
                 if isinstance(argument.default, int)}
    names = {**arguments, **parameters, **more, "bits": lambda number: int(number).bit_length(), "max": max, "min": min}
    return eval(" ".join(found[1].split()), {"__builtins__": {}}, names)

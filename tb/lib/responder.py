"""The environment of a component in one function: what it answers to what comes out of a stream."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from random import Random

__all__ = ["Responder", "responder"]


@dataclass(frozen=True)
class Responder:
    """Answers each item of one stream with items of another one.

    Parameters
    ----------
    takes, gives
        Streams out of and into the component.
    function
        From an item's value to the values of the answer.
    after
        Cycles from an item to its answer, or two numbers between which they are drawn.
    """

    takes: str
    gives: str
    function: Callable[[object], Iterable]
    after: int | tuple[int, int] = 0

    def __call__(self, value) -> list:
        """The answer to an item."""
        return list(self.function(value))

    def delay(self, generator: Random) -> int:
        """Cycles until the next answer."""
        return self.after if isinstance(self.after, int) else generator.randint(*self.after)

    def __get__(self, instance, owner=None):
        """A responder in a class answers as a method."""
        return self if instance is None else replace(self, function=self.function.__get__(instance, owner))


def responder(takes: str, gives: str, *, after: int | tuple[int, int] = 0) -> Callable[[Callable], Responder]:
    """A decorator that makes a `Responder` of a function; in a class, of a method."""
    return lambda function: Responder(takes, gives, function, after)

"""Components with one fault inside: one text of their source is replaced by another one."""

import inspect
import sys
from types import ModuleType

__all__ = ["source_fault"]


def source_fault(cls, right: str, wrong: str):
    """A component's class of which the source says ``wrong`` where it says ``right``, once.

    Raises
    ------
    ValueError
        The source does not say so, or more than once.
    """
    text = inspect.getsource(sys.modules[cls.__module__])
    if text.count(right) != 1:
        raise ValueError(f"Text must stand once in the source of {cls.__name__}, not {text.count(right)} times: "
                         f"{right!r}")
    module = ModuleType(cls.__module__)
    exec(compile(text.replace(right, wrong), cls.__module__, "exec"), module.__dict__)
    return getattr(module, cls.__name__)

"""Components with one fault inside: one text of their source is replaced, or what they are made of."""

import inspect
import sys
from types import ModuleType

__all__ = ["source_fault", "with_parts"]


def source_fault(cls, right: str, wrong: str):
    """A component's class of which the source says ``wrong`` where it says ``right``, once.

    Raises
    ------
    ValueError
        The source does not say so, or more than once.
    """
    text = _text(cls)
    if text.count(right) != 1:
        raise ValueError(f"Text must stand once in the source of {cls.__name__}, not {text.count(right)} times: "
                         f"{right!r}")
    return getattr(_module(cls, text.replace(right, wrong)), cls.__name__)


def with_parts(cls, **parts):
    """A component's class for which some names of its module stand for something else.

    Raises
    ------
    ValueError
        The module has no such name.
    """
    module = _module(cls, _text(cls))
    if missing := parts.keys() - vars(module).keys():
        raise ValueError(f"Part must be one of {cls.__module__}, not {', '.join(missing)}")
    vars(module).update(parts)
    return getattr(module, cls.__name__)


def _text(cls):
    """The source of its module, with the fault that it may have."""
    return cls.__init__.__globals__.get("_text") or inspect.getsource(sys.modules[cls.__module__])


def _module(cls, text):
    module = ModuleType(cls.__module__)
    vars(module)["_text"] = text
    exec(compile(text, cls.__module__, "exec"), vars(module))
    return module

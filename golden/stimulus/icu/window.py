"""Windows as fields of a stimulus."""

from golden.fixed import unsigned
from golden.icu.window import Window
from golden.stimulus.block import Arrays, Field

__all__ = ["window_arrays", "window_fields"]


def window_fields() -> list[Field]:
    """What `window_arrays` gives."""
    return [Field(name, unsigned(17, 0), about) for name, about in (
        ("column_first", "in a hemisphere the columns go on from the last to the first"),
        ("column_count", "0 of a window without rays"), ("row_first", "the row nearest to the pole, or the upmost"),
        ("row_count", "0 of a window without rays"))]


def window_arrays(window: Window) -> Arrays:
    """The numbers of some windows."""
    return {field.name: getattr(window, field.name) for field in window_fields()}

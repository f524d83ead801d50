"""Compiled functions run as they are, for tests of their arithmetic on arrays."""

__all__ = ["on_arrays"]


def on_arrays(monkeypatch, *modules) -> None:
    """Have the compiled functions of modules run as they are."""
    for module in modules:
        for name, value in list(vars(module).items()):
            if hasattr(value, "py_func"):
                monkeypatch.setattr(module, name, value.py_func)

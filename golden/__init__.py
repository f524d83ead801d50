"""The executable specification of the Radiosity Engine: scenes, casting and light.

``golden`` holds a float64 oracle, the machine in its own integers, and the renderer that a person uses. It knows
nothing of ``hw`` or ``tb``, and of ``radiosity`` only the command line that ``python -m golden`` starts.
"""

__all__ = ["view_factors"]


def __getattr__(name):
    # Imported at its first use: help must not import numpy.
    if name == "view_factors":
        from golden.light.factors.interface import view_factors

        return view_factors
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""The executable specification of the Radiosity Engine: scenes, casting and light.

``golden`` holds a float64 oracle and the renderer that a person uses. It knows nothing of ``hw`` or ``tb``.
"""

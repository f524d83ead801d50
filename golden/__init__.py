"""The executable specification of the Radiosity Engine: scenes, casting and light.

``golden`` holds a float64 oracle, the machine in its own integers, and the renderer that a person uses. It knows
nothing of ``hw`` or ``tb``.
"""

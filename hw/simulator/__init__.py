"""The simulated machine: the engine's RTL as a compiled library, driven by the host's driver.

`SimulatedMachine` casts memory images. `MachineCaster` makes it a caster of frusta for the renderer.
"""

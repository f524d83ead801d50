"""The simulated machine: the engine's RTL as a compiled library, driven by the host's driver.

`SimulatedMachine` casts the frusta of a job. `MachineCaster` makes it a caster of frusta for the renderer.
"""

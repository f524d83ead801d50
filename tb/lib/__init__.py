"""What benches of the hardware are made of.

A bench of ``hw/icu/foo.py`` is ``tb/icu/test_foo.py``. It holds pytest functions, which call `tb.lib.runner.simulate`
with a component, and the coroutines (``@cocotb.test()``) that the simulator runs in it; see docs/verification.md.
"""

"""What testbenches of the hardware are made of.

The testbench of ``hw/icu/foo.py`` is ``tb/icu/test_foo.py``. It holds a `tb.lib.bench.Bench`, or pytest functions that
call `tb.lib.runner.simulate` with a component, and coroutines (``@cocotb.test()``) that the simulator runs in it; see
docs/benches.md.
"""

"""The simulators give the same numbers compiled and uncompiled."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tb.radiosity.machines.engine.scenarios import SCENARIOS


@pytest.mark.nightly
def test_uncompiled_runs_equal_compiled_ones():
    done = subprocess.run([sys.executable, "-m", "tb.radiosity.machines.engine.scenarios"], check=True,
                          capture_output=True,
                          text=True, env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    uncompiled = json.loads(done.stdout)
    assert {name: np.asarray(run()).tolist() for name, run in SCENARIOS.items()} == uncompiled

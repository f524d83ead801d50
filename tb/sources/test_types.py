"""A type checker reads the public names and the modules that they are from."""

import subprocess
import sys

import pytest

import radiosity
from tb.sources.source_texts import ROOT


@pytest.mark.nightly
def test_types_of_public_names_fit(tmp_path):
    """Not in a commit's tests: mypy reads the types of numpy for twenty seconds."""
    modules = {getattr(radiosity, name).__module__ for name in radiosity.__all__ if name != "__version__"}
    files = sorted(f"{module.replace('.', '/')}.py" for module in modules)
    done = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), "radiosity/__init__.py", *files],
                          cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr

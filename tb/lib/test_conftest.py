"""The rules of every run of tests."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

RULES = Path(__file__).parents[1] / "conftest.py"


@pytest.mark.parametrize("options", [(), ("-n", "1")], ids=["one process", "workers"])
@pytest.mark.parametrize("skips", [True, False])
def test_a_run_with_a_skipped_test_fails(tmp_path, options, skips):
    shutil.copyfile(RULES, tmp_path / "conftest.py")
    (tmp_path / "test_it.py").write_text(
        f"import pytest\n\n\n@pytest.mark.skipif({skips}, reason='not here')\ndef test_it():\n    pass\n")
    run = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options, str(tmp_path)],
                         capture_output=True, text=True, cwd=tmp_path, check=False)
    assert run.returncode == int(skips), run.stdout + run.stderr
    assert ("error: skipped tests: 1; none may be" in run.stdout) == skips

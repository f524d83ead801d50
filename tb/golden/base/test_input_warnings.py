import re
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from golden.base.errors import InputWarning
from golden.base.input_warnings import caught_warnings, warn
from golden.scene.load import load_scene

ROOT = Path(__file__).parents[3]
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_files_read_by_threads_each_give_their_warning_and_leave_the_filters(tmp_path):
    paths = [tmp_path / f"{number}.obj" for number in range(40)]
    for path in paths:
        path.write_text(f"mtllib none{path.stem}.mtl\n{TRIANGLE}")
    with warnings.catch_warnings(record=True) as given, ThreadPoolExecutor(8) as threads:
        warnings.simplefilter("always", InputWarning)
        filters = list(warnings.filters)
        assert len(list(threads.map(load_scene, paths))) == 40
        assert warnings.filters == filters
    expected = sorted(f"{path}: there is no material library 'none{path.stem}.mtl': its materials become grey"
                      for path in paths)
    assert sorted(str(warning.message) for warning in given) == expected


def test_a_warning_names_the_line_that_called():
    def careless():
        warn("not used: a thing")

    with pytest.warns(InputWarning, match="^not used: a thing$") as given:
        careless()
    assert given[0].filename == __file__


def test_what_is_caught_is_given_to_the_innermost_block():
    with caught_warnings() as outer:
        warn("one")
        with caught_warnings() as inner:
            warn("two")
        warn("three")
    assert (outer, inner) == (["one", "three"], ["two"])


def test_no_other_module_warns_of_input_or_changes_filters():
    """But for the command line, which has one thread when it does."""
    found = {path.name for path in (*(ROOT / "golden").rglob("*.py"), *(ROOT / "radiosity").rglob("*.py"))
             if re.search(r"warnings\.(warn\([^)]*InputWarning|catch_warnings|simplefilter)", path.read_text())}
    assert found == {"console.py", "input_warnings.py"}

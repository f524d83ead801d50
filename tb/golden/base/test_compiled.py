"""Machine code that is kept is that of the functions and constants as they are now, in whatever files these are."""

import fcntl
import importlib
import os
import pkgutil
import re
import subprocess
import sys
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from threading import Event

import numpy as np
import pytest

import golden
from golden.base import kernel_cache
from golden.base.compiled import compiled
from golden.base.kernel_cache import MOST_FILES, kernel_folder
from golden.base.kernel_digest import kernel_digest
from radiosity import machines
from tb.sources.source_texts import ROOT

# `kernel(Pair(3, 5))` is 2 * 3 + (3 + 1) + 5 * 10 + 300 + 7 + 1000 + 1 * 3 = 1370.
_FILES = {
    "__init__": "",
    "kernels": """
from golden.base.compiled import compiled
from {package} import shifts
from {package}.doubled import doubled
from {package}.pair import Pair
from {package}.numbers import OFFSET, TABLE
from {package}.unrelated import unused

CHOICES = 1, shifts.successor


def made(factor):
    @compiled
    def times(x):
        return factor * x
    return times


once = made(1)


@compiled
def kernel(pair):
    return doubled(pair.x) + CHOICES[1](pair.x) + pair.y * 10 + OFFSET + shifts.SHIFT + TABLE[1] + once(pair.x)
""",
    "doubled": """
from golden.base.compiled import compiled
from {package}.unit import one


@compiled
def doubled(x, factor=2):
    return factor * x * one()
""",
    "unit": """
from golden.base.compiled import compiled


@compiled
def one():
    return 1
""",
    "shifts": """
from golden.base.compiled import compiled

SHIFT = 7


@compiled
def successor(x):
    return x + 1
""",
    "pair": """
from typing import NamedTuple


class Pair(NamedTuple):
    x: int
    y: int
""",
    "numbers": "import numpy as np\n\nOFFSET = 300\nTABLE = np.array([0, 1000])\n",
    "unrelated": "def unused():\n    return 0\n",
}
_VALUE = 1370
_CHANGES = {
    "callee": ("doubled", "factor * x", "factor - x", 1363),
    "default": ("doubled", "factor=2", "factor=4", 1376),
    "callee of a callee": ("unit", "return 1", "return 2", 1376),
    "callee in a tuple": ("shifts", "x + 1", "x + 2", 1371),
    "constant": ("numbers", "300", "400", 1470),
    "constant of a module": ("shifts", "SHIFT = 7", "SHIFT = 8", 1371),
    "array": ("numbers", "1000]", "2000]", 2370),
    "closure": ("kernels", "made(1)", "made(2)", 1373),
    "fields of an argument": ("pair", "x: int\n    y: int", "y: int\n    x: int", 1358),
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The folder of a package of kernels."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.syspath_prepend(tmp_path)
    folder = tmp_path / f"package{abs(hash(tmp_path))}"
    folder.mkdir()
    for name, text in _FILES.items():
        (folder / f"{name}.py").write_text(text.replace("{package}", folder.name))
    return folder


@contextmanager
def loaded(package):
    """The package's module of kernels, as a new process imports it."""
    importlib.invalidate_caches()
    try:
        yield importlib.import_module(f"{package.name}.kernels")
    finally:
        for name in [one for one in sys.modules if one.partition(".")[0] == package.name]:
            del sys.modules[name]


def run(package):
    """The value of the kernel, and whether it has been compiled for it."""
    with loaded(package) as kernels:
        value = kernels.kernel(kernels.Pair(3, 5))
        return value, bool(kernels.kernel.stats.cache_misses)


def change(package, name, old, new):
    path = package / f"{name}.py"
    text = path.read_text()
    assert text.count(old) == 1
    # Files of equal size that are written in the same second have the same bytecode file.
    path.write_text(text.replace(old, new) + "# changed\n")


def test_kernels_are_compiled_again_after_changes_in_any_file_that_they_depend_on(package):
    assert run(package) == (_VALUE, True)
    assert run(package) == (_VALUE, False)
    for name, (file, old, new, value) in _CHANGES.items():
        change(package, file, old, new)
        assert run(package) == (value, True), name
        change(package, file, new, old)
        assert run(package) == (_VALUE, False), name
    change(package, "unrelated", "return 0", "return 1")
    change(package, "doubled", "@compiled", "# Of x.\n@compiled")
    assert run(package) == (_VALUE, False)
    assert not list(package.rglob("*.nb?"))


@pytest.mark.nightly
def test_two_processes_that_compile_at_once_leave_one_file_a_kernel(package):
    code = f"from {package.name}.kernels import Pair, kernel; print(kernel(Pair(3, 5)))"
    runs = [subprocess.Popen([sys.executable, "-c", code], text=True, stdout=subprocess.PIPE, env={
        **os.environ, "PYTHONPATH": os.pathsep.join([str(package.parent), str(ROOT)])}) for _ in range(2)]
    assert [one.communicate()[0] for one in runs] == [f"{_VALUE}\n"] * 2
    files = [path for path in kernel_folder().rglob("*") if path.is_file()]
    assert len({path.parent for path in files}) == len(files)
    assert run(package) == (_VALUE, False)


def test_a_process_reads_what_another_one_is_compiling(package, monkeypatch):
    assert run(package) == (_VALUE, True)
    folder, waits = kernel_folder() / f"{package.name}.kernels.kernel", Event()
    kept, = folder.iterdir()
    code = kept.read_bytes()
    kept.unlink()
    compiling, flock = os.open(folder, os.O_RDONLY), fcntl.flock
    flock(compiling, fcntl.LOCK_EX)
    monkeypatch.setattr(fcntl, "flock", lambda *given: waits.set() or flock(*given))
    with ThreadPoolExecutor() as threads:
        found = threads.submit(run, package)
        assert waits.wait(60)
        kept.write_bytes(code)
        os.close(compiling)
        assert found.result() == (_VALUE, False)
    # Nobody waits for a process that has ended its own.
    another = os.open(folder, os.O_RDONLY)
    flock(another, fcntl.LOCK_EX | fcntl.LOCK_NB)
    os.close(another)


def test_kernels_run_where_nothing_can_be_written(package, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(package / "unit.py" / "kept"))
    assert run(package) == (_VALUE, True)
    assert run(package) == (_VALUE, True)


def test_kernels_run_where_the_user_has_no_folder(package, monkeypatch):
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(kernel_cache.Path, "expanduser", no_home)
    assert run(package) == (_VALUE, True)
    assert run(package) == (_VALUE, True)


def no_home(path):
    raise RuntimeError("Could not determine home directory.")


def test_a_folder_that_can_only_be_read_is_used(package, monkeypatch):
    run(package)
    for name in ("utime", "replace"):
        monkeypatch.setattr(os, name, refused)
    assert run(package) == (_VALUE, False)


def refused(*arguments):
    raise PermissionError("read-only")


def test_a_damaged_file_is_replaced(package):
    run(package)
    for path in kernel_folder().rglob("*"):
        if path.is_file():
            path.write_bytes(path.read_bytes()[:-1])
    assert run(package) == (_VALUE, True)
    assert run(package) == (_VALUE, False)


def test_files_used_longest_ago_are_removed(package):
    run(package)
    folder = kernel_folder() / f"{package.name}.kernels.kernel"
    kept, = folder.iterdir()
    for number in range(MOST_FILES):
        (folder / f"{number}").touch()
        os.utime(folder / f"{number}", (number, number))
    os.utime(kept, (0, 0))
    assert run(package) == (_VALUE, False)  # which uses it
    change(package, "numbers", "300", "400")
    run(package)
    names = {path.name for path in folder.iterdir()}
    assert len(names) == MOST_FILES
    assert kept.name in names
    assert {"0", "1"} & names == set()
    assert f"{MOST_FILES - 1}" in names


def test_the_folder_is_numbas_variable_or_in_the_users_cache(monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/given")
    assert str(kernel_folder()) == "/given"
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", "/cache")
    assert str(kernel_folder()) == "/cache/radiosity-engine/kernels"
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", "/home/one")
    assert str(kernel_folder()) == "/home/one/.cache/radiosity-engine/kernels"


def test_all_kernels_of_the_project_go_through_compiled_and_are_distinguished():
    sources = {path: path.read_text() for tree in ("golden", "radiosity", "hw") for path in (ROOT / tree).rglob("*.py")}
    users = {path.name for path, text in sources.items() if re.search(r"^\s*(import|from) numba\b", text, re.MULTILINE)}
    assert users == {"kernel_cache.py", "kernel_dispatcher.py", "native.py"}
    found = {}
    for module in (*pkgutil.walk_packages(golden.__path__, "golden."),
                   *pkgutil.walk_packages(machines.__path__, "radiosity.machines.")):
        if module.name != "golden.__main__":
            for name, value in vars(importlib.import_module(module.name)).items():
                if hasattr(value, "py_func") and value.__module__ == module.name:
                    found[f"{module.name}.{name}"] = kernel_digest(value)
    assert len(found) == sum(len(re.findall(r"(?m)^@(?:compiled|callback|inlined)$",
                                            text)) for text in sources.values())
    assert None not in found.values()
    assert len(set(found.values())) == len(found)


def test_constants_that_kernels_pass_make_no_copies_of_what_they_call(tmp_path, monkeypatch):
    # A caller whose code is read from the user's folder compiles nothing that it calls.
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    @compiled
    def callee(x, y, both):
        return x + y if both else x

    @compiled
    def caller(x):
        return callee(x, 1, True) + callee(x, 2, False) + callee(x, x, x > 0)

    assert caller(5) == 6 + 5 + 10
    assert len(callee._twin.overloads) == 1


def test_a_kernel_that_reads_an_object_of_its_package_is_not_kept():
    class Unknown:
        pass

    unknown = Unknown()

    def kernel():
        return unknown

    assert kernel_digest(kernel) is None


def test_sets_and_arrays_count_by_their_values():
    def kernel(x, table=np.arange(3)):  # noqa: B008
        return x in {"one", "two", "three"}

    digest = kernel_digest(kernel)
    assert digest == kernel_digest(kernel)
    kernel.__defaults__[0][1] = 5
    assert kernel_digest(kernel) != digest


def test_entries_of_a_tuple_count_by_their_names(monkeypatch):
    def kernel(row):
        return row[_VALUE.FIRST]

    digests = set()
    for names in ("FIRST LAST", "LAST FIRST"):
        monkeypatch.setitem(kernel.__globals__, "_VALUE", namedtuple("Columns", names)(0, 1))
        digests.add(kernel_digest(kernel))
    assert len(digests) == 2


def test_what_functions_within_a_kernel_read_counts(monkeypatch):
    def kernel(x):
        return [_VALUE + y for y in x]

    digest = kernel_digest(kernel)
    monkeypatch.setitem(kernel.__globals__, "_VALUE", 5)
    assert kernel_digest(kernel) != digest

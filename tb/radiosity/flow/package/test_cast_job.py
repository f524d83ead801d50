"""The exported example of the driver casts its job at a machine of registers, and fails if a descriptor does."""

import ctypes
import re
import shutil

import numpy as np
import pytest

from golden.engine.jobs.result_formats import pack_sums
from hw.registers.error_code import ErrorCode
from radiosity.flow.package.core_files import write_core
from tb.radiosity.flow.package.driver_library import FLAGS, complaints
from tb.radiosity.flow.package.exported_engine import CONFIG
from tb.radiosity.flow.package.register_machine import RegisterMachine

SIZE = 1 << 22
DESCRIPTORS = 2


def compiled(folder):
    """The example beside an exported engine casts its sample at a machine, and returns its result."""
    assert not complaints(folder, "gcc", *FLAGS, "-fPIC", "-shared", "-o", "cast.so", "-Idriver", "-Ijob",
                          "example/cast_job.c", "driver/radiosity.c")
    library = ctypes.CDLL(str(folder / "cast.so"))
    return lambda machine: library.cast_job(machine.port, str(folder / "job" / "job.bin").encode())


@pytest.fixture(scope="module")
def cast_job(exported, tmp_path_factory):
    """That of the engine with a cluster."""
    return compiled(shutil.copytree(exported, tmp_path_factory.mktemp("example") / "core"))


def test_results_are_printed_if_all_descriptors_end_well(cast_job, capfd):
    assert cast_job(RegisterMachine(SIZE)) == 0
    assert capfd.readouterr().out.count("hit ") == 256


@pytest.mark.parametrize("tag", range(DESCRIPTORS))
def test_any_descriptor_with_an_error_is_named_and_fails_the_job(cast_job, capfd, tag):
    machine = RegisterMachine(SIZE)
    machine.errors = {tag: ErrorCode.OVERFLOW.value}
    assert cast_job(machine) == 1
    found = capfd.readouterr()
    assert "hit" not in found.out
    assert f"error: descriptor {tag}: OVERFLOW" in found.err


def test_a_job_of_another_core_is_refused_before_any_access(core, capfd):
    header = core / "job" / "job.h"
    number = re.search(r'JOB_CORE "(\w{8})', header.read_text())[1]
    header.write_text(header.read_text().replace(number, "01234567"))
    machine = RegisterMachine(SIZE)
    assert compiled(core)(machine) == 2
    assert capfd.readouterr().err == (f"error: job.h must be of the core {number}, not 01234567: "
                                      "give `radiosity image` this core's --manifest\n")
    assert not machine.log


def test_sums_of_a_frustum_s_sections_are_added(without_verilog, tmp_path, capfd):
    machine = RegisterMachine(SIZE)
    machine.sums = {tag: pack_sums(*map(np.array, zip(*sums, strict=True))) for tag, sums in {
        1: [(7, 1 << 33), (3, 5)], 2: [(3, 30), (9, 2)]}.items()}
    write_core("engine", config=CONFIG.replace({"noc.columns": 2}), preset="tiny", folder=tmp_path)
    assert compiled(tmp_path)(machine) == 0
    assert [line for line in capfd.readouterr().out.splitlines() if line.startswith("sum")] == [
        "sum 0 3 35", f"sum 0 7 {1 << 33}", "sum 0 9 2"]

"""The exported example of the driver casts its job at a machine of registers, and fails if a descriptor does."""

import ctypes
import re

import numpy as np
import pytest

from golden.jobs.result_formats import pack_sums
from hw.package.core_files import write_core
from hw.registers.error_code import ErrorCode
from tb.package.driver_library import FLAGS, complaints
from tb.package.exported_engine import CONFIG
from tb.package.register_machine import RegisterMachine

SIZE = 1 << 22
DESCRIPTORS = 2


def example(config, tmp_path):
    """Casts the sample of a configuration at a machine: the result of the example."""
    write_core("engine", config=config, preset="tiny", folder=tmp_path)
    return compiled(tmp_path)


def compiled(tmp_path):
    """The example beside an exported engine."""
    assert not complaints(tmp_path, "gcc", *FLAGS, "-fPIC", "-shared", "-o", "cast.so", "-Idriver", "-Ijob",
                          "example/cast_job.c", "driver/radiosity.c")
    library = ctypes.CDLL(str(tmp_path / "cast.so"))
    return lambda machine: library.cast_job(machine.port, str(tmp_path / "job" / "job.bin").encode())


@pytest.fixture
def cast_job(without_verilog, tmp_path):
    """That of the engine with a cluster."""
    return example(CONFIG, tmp_path)


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


def test_a_job_of_another_core_is_refused_before_any_access(without_verilog, tmp_path, capfd):
    write_core("engine", config=CONFIG, preset="tiny", folder=tmp_path)
    header = tmp_path / "job" / "job.h"
    core = re.search(r'JOB_CORE "(\w{8})', header.read_text())[1]
    header.write_text(header.read_text().replace(core, "01234567"))
    machine = RegisterMachine(SIZE)
    assert compiled(tmp_path)(machine) == 2
    assert capfd.readouterr().err == (f"error: job.h must be of the core {core}, not 01234567: give `radiosity image` "
                                      "this core's --manifest\n")
    assert not machine.log


def test_sums_of_a_frustum_s_sections_are_added(without_verilog, tmp_path, capfd):
    machine = RegisterMachine(SIZE)
    machine.sums = {tag: pack_sums(*map(np.array, zip(*sums, strict=True))) for tag, sums in {
        1: [(7, 1 << 33), (3, 5)], 2: [(3, 30), (9, 2)]}.items()}
    assert example(CONFIG.replace({"noc.columns": 2}), tmp_path)(machine) == 0
    assert [line for line in capfd.readouterr().out.splitlines() if line.startswith("sum")] == [
        "sum 0 3 35", f"sum 0 7 {1 << 33}", "sum 0 9 2"]

"""The exported example of the driver casts its job at a machine of registers, and fails if a descriptor does."""

import ctypes

import pytest

from hw.package.core_files import write_core
from hw.registers.error_code import ErrorCode
from tb.package.driver_library import FLAGS, complaints
from tb.package.exported_engine import CONFIG
from tb.package.register_machine import RegisterMachine

SIZE = 1 << 22
DESCRIPTORS = 2


@pytest.fixture
def cast_job(without_verilog, tmp_path):
    """Casts the sample at a machine: the result of the example."""
    write_core("engine", config=CONFIG, preset="tiny", folder=tmp_path)
    assert not complaints(tmp_path, "gcc", *FLAGS, "-fPIC", "-shared", "-o", "cast.so", "-Idriver", "-Ijob",
                          "example/cast_job.c", "driver/radiosity.c")
    library = ctypes.CDLL(str(tmp_path / "cast.so"))
    return lambda machine: library.cast_job(machine.port, str(tmp_path / "job" / "job.bin").encode())


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

"""Builds are made once, leave nothing but the program, and are made again for another text or when they are gone."""

from contextlib import nullcontext

import pytest
from cocotb_tools.runner import Icarus

from hw.lib.skid_buffer import SkidBuffer
from radiosity.flow.verilog.export import verilog_of
from tb.lib import runner
from tb.lib.runner import Simulation


@pytest.fixture
def simulation(tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "BUILD", tmp_path)
    builds = []
    monkeypatch.setattr(Simulation, "_build", lambda self, one, build=Simulation._build: (
        builds.append(self._folder.name), build(self, one)))
    text = verilog_of(SkidBuffer(8), "top")

    def run(comment=""):
        with Simulation(f"{text}// {comment}\n", "icarus")._built():
            return builds, tmp_path / "builds"

    return run


@pytest.mark.icarus
def test_the_same_text_is_built_once(simulation):
    for _ in range(2):
        builds, folder = simulation()
    assert len(builds) == 1
    assert {path.name for path in (folder / builds[0]).iterdir()} == {"sim.vvp", "build.log"}
    simulation("another")
    assert len(set(builds)) == 2


@pytest.mark.icarus
def test_runs_of_one_build_do_not_wait_for_each_other(simulation, monkeypatch):
    """They request shared access to it and no other."""
    simulation()
    accesses = []
    monkeypatch.setattr(runner, "locked", lambda _, *, shared=False: accesses.append(shared) or nullcontext())
    simulation()
    assert accesses == [True]


@pytest.mark.icarus
def test_a_build_that_is_gone_is_made_again(simulation, monkeypatch):
    monkeypatch.setattr(runner, "_MOST_BYTES", 1)
    builds, folder = simulation()
    simulation("another")
    assert not (folder / builds[0]).exists()
    simulation()
    assert builds[2] == builds[0]


@pytest.mark.icarus
def test_an_interrupted_build_is_made_again(simulation, monkeypatch):
    """Whatever the compiler had written when it was killed."""
    def killed(self, build_dir, **options):
        (build_dir / "sim.vvp").write_text("half a program")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Icarus, "build", killed)
        with pytest.raises(KeyboardInterrupt):
            simulation()
    builds, folder = simulation()
    assert len(builds) == 2
    assert (folder / builds[0] / "sim.vvp").read_text().startswith("#!")


def test_a_missing_simulator_fails_and_says_how_to_install_it(monkeypatch):
    monkeypatch.setattr(runner.shutil, "which", lambda name: None)
    runner._version.cache_clear()
    with pytest.raises(FileNotFoundError, match="apt-get install iverilog"):
        Simulation("module top; endmodule", "icarus")


@pytest.mark.parametrize(("drawn", "test", "command"), [
    (True, "tb/icu/test_a.py::test_b[x 1-y@z]@machine 2 (call)", "SEED=7 pytest 'tb/icu/test_a.py::test_b[x 1-y@z]'"),
    (False, "tb/icu/test_a.py::TestA::test_b (call)", "pytest tb/icu/test_a.py::TestA::test_b")])
def test_a_failing_bench_names_the_command_that_repeats_it(drawn, test, command, monkeypatch):
    """As a shell takes it, whatever the processes that the tests were shared out to; the seed if there was one."""
    monkeypatch.setattr(runner, "SEED", 7)
    monkeypatch.setattr(runner, "IS_DRAWN", drawn)
    monkeypatch.setattr(Simulation, "run", lambda self, *_, **__: ["failed"])
    with monkeypatch.context() as patch:
        patch.setenv("PYTEST_CURRENT_TEST", test)
        with pytest.raises(pytest.fail.Exception, match=r"failed in verilator; waves in .*") as failure:
            runner.simulate("module top; endmodule", "tb.lib.test_runner", ("bench",))
    assert failure.value.msg.splitlines()[-1] == f"again: {command}"

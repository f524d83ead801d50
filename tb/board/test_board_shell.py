"""The whole shell, seen through its serial line."""

import dataclasses
from pathlib import Path

import cocotb
import numpy as np
import pytest
from amaranth.hdl import ClockDomain, Elaboratable, Fragment, Module
from cocotb.triggers import ClockCycles, FallingEdge
from PIL import Image

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import PRESETS
from golden.engine.jobs.completion import NO_CLUSTER, patch_sources
from golden.engine.jobs.result_formats import HitFormat, pack_hits
from golden.light.image import write_png
from hw.board.board_shell import BoardShell
from hw.board.frame import FrameKind
from hw.board.program import Operation, Step
from hw.cluster import Cluster
from hw.engine import CLUSTER
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from radiosity.flow.board.record import record
from radiosity.flow.board.view import board_view
from radiosity.flow.host import EngineError
from radiosity.flow.verilog.export import verilog_of
from tb.board.decoder import frames, hit_picture, results
from tb.board.serial_line import SerialLine
from tb.lib.clocking import start
from tb.lib.runner import BUILD, options, simulate

BOARD = PRESETS["board"]
DIVISOR = 4
PIXELS = 32, 32
PICTURE = Path("out") / "board" / "simulated.png"


@cocotb.test()
async def casts_twice(dut):
    """After reset, and again on request; all that is sent goes into a file."""
    dut.again.value = 0
    await start(dut, cycles=options()["cycles"])
    line = SerialLine(dut.tx, divisor=DIVISOR)
    for number in range(2):
        await FallingEdge(dut.busy)
        await ClockCycles(dut.clk, 12 * DIVISOR)
        assert int(dut.failed.value), "the program ends with an error"
        if number == 0:
            dut.again.value = 1
            await ClockCycles(dut.clk, 2)
            dut.again.value = 0
            assert int(dut.busy.value)
            assert not int(dut.failed.value)
    Path(options()["result"]).write_bytes(line.received)


def with_an_error(job):
    """The program of a job, with a doorbell beyond the ring at its end."""
    program, offsets = record(job), addresses(ENGINE_REGISTERS)
    beyond = len(job.descriptors) + (1 << job.ring_bits) + 1
    *usual, halt = program.steps[:program.error]
    more = (Step(operation=Operation.WRITE, address=offsets["doorbell"], value=beyond),
            Step(operation=Operation.WAIT, address=offsets["status"]))
    return dataclasses.replace(program, steps=(*usual, *more, halt, *program.steps[program.error:]),
                               error=program.error + len(more))


class WithoutReset(Elaboratable):
    """A shell in the clock domain of a board that has no reset."""

    def __init__(self, shell):
        self._shell = shell

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain(reset_less=True)
        m.submodules.shell = self._shell
        return m


@pytest.mark.nightly
def test_a_board_may_have_no_reset():
    job = board_view(BOARD, scene="cornell", pixels=(8, 8), cell=0.5).job
    shell = BoardShell(config=BOARD, program=record(job), divisor=DIVISOR, black_boxes=True)
    design = Fragment.get(WithoutReset(shell), None).prepare()
    assert design.fragment.domains["sync"].rst is None


@pytest.mark.sim
def test_hits_come_out_of_the_serial_line():
    view = board_view(BOARD, scene="cornell", pixels=PIXELS, cell=0.25)
    expected = NaiveFixed(view.geometry, BOARD).cast(view.record)
    shell = BoardShell(config=BOARD, program=with_an_error(view.job), divisor=DIVISOR, black_boxes=True)
    result = (BUILD / "vectors" / "board.bin").resolve()
    result.parent.mkdir(parents=True, exist_ok=True)
    simulate(verilog_of(shell, "top") + verilog_of(Cluster(config=BOARD), CLUSTER), "tb.board.test_board_shell",
             ("casts_twice",), name="board", visible=("clk", "rst", "tx", "again", "busy", "failed"), cycles=4_000_000,
             result=str(result))
    sent = frames(result.read_bytes())
    kinds = [FrameKind.COMPLETIONS, FrameKind.DESCRIPTORS, FrameKind.HITS, FrameKind.ERROR]
    assert [frame.kind for frame in sent] == 2 * kinds
    with pytest.raises(EngineError) as raised:
        results(sent)
    assert raised.value.code == ErrorCode.RING
    # The second time the machine is as it was: also its cycle counter and its rings.
    assert sent[:len(kinds)] == sent[len(kinds):]
    cast = results(sent[:len(kinds) - 1])
    assert sent[1].payload == view.job.descriptors.tobytes()
    load, *sections = np.sort(cast.completions, order="tag")
    assert (load["tag"], load["cluster"]) == (0, NO_CLUSTER)
    # The cluster casts all of it, and needs patches of the patch node, which it requests once each.
    assert [one["cluster"] for one in sections] == [0]
    assert [(one["tag"], one["sums"], one["lap"]) for one in (load, *sections)] == [(tag, 0, 1) for tag in range(2)]
    sources = patch_sources(cast.completions[1:])
    assert sources["own"].all()
    assert sources["remote"].all()
    assert 0 < cast.completions["cycles"][1:].max() <= cast.cycles < 1_000_000
    for name, values in vars(expected).items():
        different = np.flatnonzero(getattr(cast.hits, name) != values)
        assert not len(different), f"{len(different)} of {len(values)} rays differ in {name}"
    assert sent[2].payload == pack_hits(expected, HitFormat.FULL).tobytes()
    assert (expected.patch >= 0).mean() > 0.8
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    write_png(PICTURE, hit_picture(cast))
    with Image.open(PICTURE) as picture:
        colours = np.asarray(picture)
    patches = expected.patch.reshape(PIXELS[1], PIXELS[0])
    assert colours.shape == (PIXELS[1], PIXELS[0], 3)
    assert len(np.unique(colours.reshape(-1, 3), axis=0)) == len(np.unique(patches))
    assert (colours[patches < 0] == 0).all()

"""The whole shell, seen through its serial line."""

import dataclasses
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, FallingEdge
from PIL import Image

from golden.cast.naive_fixed import NaiveFixed
from golden.image import write_png
from hw.board.board_shell import BoardShell
from hw.board.frame import FrameKind, region_kind
from hw.board.program import Operation, Step
from hw.board.record import record
from hw.board.view import BOARD, board_view
from hw.cluster import Cluster
from hw.engine import CLUSTER
from hw.export import verilog_of
from hw.host import EngineError
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from tb.board.decoder import frames, hit_picture, results
from tb.board.serial_line import SerialLine
from tb.lib.clocking import start
from tb.lib.runner import BUILD, options, simulate

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


def with_an_error(program):
    """The program, with a command that means nothing at its end."""
    offsets = addresses(ENGINE_REGISTERS)
    *usual, halt = program.steps[:program.error]
    more = (Step(operation=Operation.WRITE, address=offsets["command"], value=0),
            Step(operation=Operation.WAIT, address=offsets["status"]))
    return dataclasses.replace(program, steps=(*usual, *more, halt, *program.steps[program.error:]),
                               error=program.error + len(more))


@pytest.mark.sim
def test_hits_come_out_of_the_serial_line():
    view = board_view(BOARD, scene="cornell", pixels=PIXELS, cell=0.25)
    expected = NaiveFixed(view.geometry, BOARD).cast(view.record)
    shell = BoardShell(config=BOARD, program=with_an_error(record(view.image, BOARD)), divisor=DIVISOR,
                       black_boxes=True)
    result = (BUILD / "vectors" / "board.bin").resolve()
    result.parent.mkdir(parents=True, exist_ok=True)
    simulate(verilog_of(shell, "top") + verilog_of(Cluster(config=BOARD), CLUSTER), "tb.board.test_board_shell",
             ("casts_twice",), name="board", visible=("clk", "rst", "tx", "again", "busy", "failed"), cycles=4_000_000,
             result=str(result))
    sent = frames(result.read_bytes())
    one = [FrameKind.CYCLES.value, *map(region_kind, ("frustum", "hits", "sums")), FrameKind.ERROR.value]
    assert [frame.kind for frame in sent] == 2 * one
    with pytest.raises(EngineError) as raised:
        results(sent)
    assert raised.value.code == ErrorCode.COMMAND
    written = view.image.with_results(expected)
    times = []
    for first in (0, len(one)):
        cycles, regions = results(sent[first:first + len(one) - 1])
        times.append(cycles)
        assert regions["frustum"].tobytes() == view.image["frustum"].tobytes()
        different = np.flatnonzero(regions["hits"] != written["hits"])
        assert not len(different), f"{len(different)} of {len(written['hits'])} rays differ"
        for name in "hits", "sums":
            assert regions[name].tobytes() == written[name].tobytes(), name
        assert (regions["hits"]["patch"] >= 0).mean() > 0.8
    # The second time the caches are as they were left.
    assert 0 < times[1] <= times[0] < 1_000_000
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    write_png(PICTURE, hit_picture(regions))
    with Image.open(PICTURE) as picture:
        colours = np.asarray(picture)
    patches = expected.patch.reshape(PIXELS[1], PIXELS[0])
    assert colours.shape == (PIXELS[1], PIXELS[0], 3)
    assert len(np.unique(colours.reshape(-1, 3), axis=0)) == len(np.unique(patches))
    assert (colours[patches < 0] == 0).all()

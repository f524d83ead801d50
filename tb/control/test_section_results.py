"""The results of each section are read out, written and reported once, with what was known when its cast ended."""

import random

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.jobs.completion import COMPLETION, parse_completions
from hw.control.section_results import COUNTS, SectionResults
from hw.memsys.fault import Fault
from hw.memsys.result_formats import HitFormat
from hw.registers.error_code import ErrorCode
from tb.lib.payload import unpack
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
# Cycles after which a run has failed.
LIMIT = 3000


def run(sections, *, seed=1, slow=5):
    """What is commanded and reported; a cast may begin while the results of the one before are written."""
    dut, draw = SectionResults(config=CONFIG), random.Random(seed)
    commands, records, log = [], [], []

    async def bench(ctx):
        state, begun, words, pause, ended, done, cleared = "idle", -1, [], 0, False, None, False
        offered, event = dict.fromkeys(("o_command", "o"), 0), None
        for cycle in range(LIMIT):
            if len(records) == len(sections):
                break
            ctx.set(dut.cycle, cycle)
            begins = state == "idle" and begun + 1 < len(sections) and draw.random() < 0.5
            ctx.set(dut.begins, int(begins))
            if begins:
                begun, state, ended = begun + 1, "cast", False
                one = sections[begun]
                ctx.set(dut.results, results_of(begun, one))
                log.append([cycle])
            else:
                # The slot may have the next section already.
                ctx.set(dut.results, results_of(begun + 40, {"hit_format": 1 + cycle % 3, "sums": cycle & 1}))
            ends = state == "cast" and not begins and (ended or draw.random() < 0.3)
            ctx.set(dut.i.valid, int(ends))
            if ends and not ended:
                ended, one = True, sections[begun]
                ctx.set(dut.cycles, one["cycles"])
                ctx.set(dut.fault, {"code": one["fault"], "number": one["number"]})
                ctx.set(dut.counts, {name: one["cycles"] + k for k, name in enumerate(COUNTS)})
            ctx.set(dut.o_read_out.ready, int(draw.random() < 0.5))
            ctx.set(dut.o_command.ready, int(draw.random() < 0.5))
            ctx.set(dut.o.ready, int(draw.random() < 0.6))
            pause = max(0, pause - 1)
            ctx.set(dut.i_done.valid, int(done is not None and pause == 0))
            if done is not None:
                ctx.set(dut.i_done.payload, done)
            read_out = ctx.get(dut.o_read_out.valid) and ctx.get(dut.o_read_out.ready)
            if read_out:
                assert ctx.get(dut.i.ready), "the cast is over when its read-out begins"
                assert ctx.get(dut.clear), "the fault has been kept"
                state, cleared = "idle", True
            else:
                assert not ctx.get(dut.clear), "a fault is cleared when it has been kept"
            if ctx.get(dut.o_command.valid) and ctx.get(dut.o_command.ready):
                one = dut.o_command.payload
                commands.append(unpack(one.shape(), ctx.get(one.as_value())))
                given = sections[len(commands) - 1]
                done = {"code": given["written"], "address": given["address"], "sums": given["words"]}
                pause = 1 + draw.randrange(slow)
            if ctx.get(dut.i_done.valid) and ctx.get(dut.i_done.ready):
                log[len(records)].append(cycle)
                done = None
            if ctx.get(dut.o.valid) and ctx.get(dut.o.ready):
                words.append(ctx.get(dut.o.payload))
                if len(words) == 8:
                    records.append(b"".join(word.to_bytes(8, "little") for word in words))
                    words = []
            offers = {name: ctx.get(getattr(dut, name).valid) for name in ("o_command", "o")}
            for name, offer in offers.items():
                if offer and not offered[name]:
                    assert cycle - event == documented_latency(SectionResults, CONFIG), f"{name} comes in time"
            offered = offers
            if read_out or (ctx.get(dut.i_done.valid) and ctx.get(dut.i_done.ready)):
                event = cycle
            await ctx.tick()
        else:
            raise AssertionError(f"{len(records)} of {len(sections)} sections were reported in {LIMIT} cycles")
        assert cleared

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return commands, parse_completions(b"".join(records)), log


def drawn(seed):
    draw = random.Random(seed)
    return [{"hit_format": draw.choice([*HitFormat]).value, "sums": draw.randrange(2),
             "cycles": draw.randrange(1 << 31),
             "fault": (fault := draw.choice([ErrorCode.NONE, ErrorCode.NONE, ErrorCode.PATH_BUS])),
             "number": draw.randrange(1, 1 << 20) if fault is not ErrorCode.NONE else 0,
             "written": (written := draw.choice([Fault.NONE, Fault.NONE, Fault.WRITE_REPLY])),
             "address": draw.randrange(1, 1 << 20) if written is not Fault.NONE else 0,
             "words": draw.randrange(1, 1 << 10)} for _ in range(15)]


def results_of(number, one):
    """What a section's results are and where, by its number: no two fields are alike."""
    return {"hit_format": one["hit_format"], "sums": one["sums"], "hits": 64 * number,
            "sums_address": 640 + 64 * number, "columns": 9 + 2 * number,
            "section": {"first_column": number, "end_column": number + 5, "first_row": 2 * number + 1,
                        "end_row": 3 * number + 4}}


@pytest.mark.parametrize("seed", range(4))
def test_each_section_is_written_and_reported_once(seed):
    sections = drawn(seed)
    commands, records, log = run(sections, seed=seed)
    assert len(records) == len(commands) == len(sections)
    for number, (one, command, record) in enumerate(zip(sections, commands, records, strict=True)):
        good = one["fault"] is ErrorCode.NONE
        written = {} if good else {"hit_format": HitFormat.NONE.value, "sums": 0}
        assert command == results_of(number, one) | written, "of a cast with a fault nothing is written"
        code = one["fault"] if not good else ErrorCode(one["written"].value)
        assert (int(record["error"]), int(record["address"])) == (
            code.value, one["address"] if good else one["number"]), "the cast's fault comes first"
        assert record["sums"] == (one["words"] if good and one["sums"] else 0)
        assert [int(record["begin"]), int(record["end"])] == log[number]
        assert int(record["cycles"]) == one["cycles"]
        assert [int(record[name]) for name in COUNTS] == [one["cycles"] + k for k in range(len(COUNTS))]
        assert {int(record[name]) for name in ("tag", "cluster", "lap")} == {0}, "others fill these in"


def test_all_fields_of_a_record_are_known():
    assert {*COMPLETION.dtype.names} == {"tag", "error", "cluster", "lap", "address", "sums", "cycles", "begin", "end",
                                         *COUNTS}

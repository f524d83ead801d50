"""Beats of sections of any alignment.

`tb.memsys.results.test_result_writer` compares the memory that they make, and has the wider beats.
"""

import pytest

from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat
from hw.memsys.results.result_packer import ResultPacker
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.memsys.results.extent import extent_of, saturated
from tb.memsys.section_results import Packing, drawn_section, joined

CHANGES = [{"memory.data_bits": bits} for bits in (64, 128)]


def vectors(config, sections):
    """Of several sections."""
    bits = config.memory.data_bits
    last = config.memory.address_bits - (bits // 8).bit_length() + 1
    beats = [{**beat, "number": saturated(beat["number"], last)} for one in sections for beat in one.beats(bits)]
    return Vectors(inputs=joined(sections) | {"i": [extent_of(one.command_item, config) for one in sections]},
                   expected={"o": beats}, ports={"discard": 0}, after={"busy": 0}, about=sections)


def written(beats):
    """Beats with what is written alone."""
    for beat in beats:
        beat["data"] &= sum(0xFFFFFFFF << 32 * k for k in range(beat["lanes"].bit_length()) if beat["lanes"] >> k & 1)
    return beats


class TestResultPacker(Bench):
    """Random sections, some of which reach beyond the end of memory."""

    component, arguments = ResultPacker, {"group_bits": 4}
    variants, splits = [*CHANGES, {"memory.address_bits": 16}], False
    count = 14

    def vectors(self, config):
        return self.drawn(config, 5)

    def drawn(self, config, seed):
        top = 1 << config.memory.address_bits
        near = {"base": 4096, "sums_address": 8192}, {"base": top - 1024, "sums_address": top - 32}
        sections = [drawn_section(100 * seed + k, config, **near[k % 2]) for k in range(self.count)]
        # Its hits reach around the whole of a small memory.
        sections.append(drawn_section(seed, config, columns=1024, section=Sector(0, 2, 0, 40), **near[1]))
        return vectors(config, sections)

    def check(self, given, came):
        assert written(self.values("o", came)) == given.expected["o"]

    def predict(self, given, trace, component, config):
        """A cycle lies between the last sum of a section and the next one."""
        found, now = {name: [] for name in trace.cycles}, 0

        def leave(cycle, beat):
            found["o"].append(trace.ready("o", cycle))
            return found["o"][-1]

        packing = Packing(config.memory.data_bits, trace, found, leave)
        for one, offered in zip(given.about, trace.offered["i"], strict=True):
            found["i"].append(max(offered, now + 1))
            now = packing.add(one, found["i"][-1])
        return found


@pytest.fixture(scope="module", params=CHANGES, ids=lambda changes: str(changes["memory.data_bits"]))
def packer(request):
    config = config_of(request.param)
    return config, ScheduleBench(ResultPacker(config=config, group_bits=4), watched=("words", "wrong", "overflow"))


def schedule(config, items):
    """Without gaps; of commands the extents."""
    extents = [extent_of(one.command_item, config) for one in items["i"]]
    return Schedule(items={name: [(0, item) for item in values] for name, values in (items | {"i": extents}).items()})


def test_what_is_discarded(packer):
    """The rest of a section, and its count of sums; nothing of it is in a beat of the next section."""
    config, bench = packer
    sections = [drawn_section(300 + k, config, base=1 << 20, columns=9, hit_format=HitFormat.IDS, sums=True)
                for k in range(8)]
    second = next(k for k, one in enumerate(sections[1:-1], start=1) if len(one.sums) > 4)
    sections = sections[second - 1:second + 2]
    items = joined(sections) | {"i": sections}
    before, hits, sums = (len(sections[0].hit_items) + len(sections[0].sum_items), len(sections[1].hit_items),
                          len(sections[1].sums))
    first, *_, last = (one.beats(config.memory.data_bits) for one in sections)
    for kept in (1, 2, 3, hits - 1, hits, hits + 1, hits + sums - 1):
        came = written(bench.run(schedule(config, items), discard=lambda cycles, kept=kept: len(cycles["i"]) == 2 and (
            len(cycles["i_hit"]) + len(cycles["i_sum"]) >= before + kept))["o"])
        beats = sections[1].beats(config.memory.data_bits)
        assert came == [*first, *beats[:len(came) - len(first) - len(last)], *last]
        assert len(came) < len(first) + len(beats) + len(last)
        counts = [bench.history["words"][cycle - 1] for cycle in bench.cycles["i"][1:]] + [bench.history["words"][-1]]
        assert counts == [len(sections[0].sums), 0, len(sections[2].sums)]


def test_what_is_wrong(packer):
    """A sum that is to be written and has overflowed, but no item without a sum; a last hit that ends no row."""
    config, bench = packer
    sections = [drawn_section(400 + k, config, base=1 << 20) for k in range(24)]
    items = joined(sections)
    items["i_sum"] = [{**one, "overflow": int(number % 4 == 3 or not one["is_sum"])}
                      for number, one in enumerate(items["i_sum"])]
    assert {(one["overflow"], one["is_sum"]) for one in items["i_sum"]} == {(0, 1), (1, 0), (1, 1)}
    for one in items["i_hit"]:
        one["column"] ^= one["last"] and one["row"] & 1
    bench.run(schedule(config, items | {"i": sections}))
    ends = {(one.command.section.end_row - 1) & 1 for one in sections}
    assert ends == {0, 1}
    sums, hits = bench.cycles["i_sum"], bench.cycles["i_hit"]
    is_written = [one.command.sums for one in sections for _ in one.sum_items]
    assert {*is_written} == {False, True}
    assert _cycles(bench, "overflow") == [cycle for cycle, one, is_written in zip(
        sums, items["i_sum"], is_written, strict=True) if one["overflow"] and one["is_sum"] and is_written]
    assert _cycles(bench, "wrong") == [cycle for cycle, one in zip(hits, items["i_hit"], strict=True) if (
        one["last"] and one["row"] & 1)]


def _cycles(bench, name):
    """In which an output was 1."""
    return [cycle for cycle, value in enumerate(bench.history[name], start=1) if value]

"""Beats of sections of any alignment; `tb.memsys.test_result_writer` compares the memory that they make."""

from itertools import pairwise

from golden.jobs.result_formats import HitFormat
from hw.memsys.result_packer import ResultPacker
from tb.lib.bench import Bench, Vectors
from tb.lib.runner import SIMULATORS
from tb.memsys.section_results import drawn_section, joined
from tb.memsys.test_result_address import expected as extent_of

CHANGES = [{"memory.data_bits": bits} for bits in (64, 128)]


def vectors(config, sections):
    """Of several sections."""
    bits = config.memory.data_bits
    beats = [beat for one in sections for beat in one.beats(bits)]
    return Vectors(inputs=joined(sections) | {"i": [extent_of(one, bits) for one in sections]},
                   expected={"o": beats}, ports={"discard": 0}, after={"busy": 0}, about=sections)


class TestResultPacker(Bench):
    """Random sections."""

    component, arguments = ResultPacker, {"group_bits": 4}
    variants, splits = CHANGES, False
    count = 14

    def vectors(self, config):
        return self.drawn(config, 5)

    def drawn(self, config, seed):
        return vectors(config, [drawn_section(100 * seed + k, config, base=1 << 20) for k in range(self.count)])

    def check(self, given, came):
        found = self.values("o", came)
        for beat in found:
            kept = sum(0xFFFFFFFF << 32 * k for k in range(beat["lanes"].bit_length()) if beat["lanes"] >> k & 1)
            beat["data"] &= kept
        assert found == given.expected["o"]

    def check_times(self, given, cycles, latency):
        """A hit per cycle, or a beat; a sum per cycle; nothing between them, and a cycle before the next section."""
        whole = 2 if self.now_bits == 64 else 1
        hits, sums, taken, beats = (iter(cycles[name]) for name in ("i_hit", "i_sum", "i", "o"))
        before, timed = None, 0
        for one in given.about:
            interval = whole if one.command.hit_format == HitFormat.FULL else 1
            begins, hit = next(taken, None), [next(hits, None) for _ in one.hit_items]
            found = [*hit, *(next(sums, None) for _ in one.sum_items)]
            if None in (begins, *found, *(next(beats, None) for _ in one.beats(self.now_bits))):
                break
            timed += 1
            assert {b - a for a, b in pairwise(hit)} <= {interval}
            assert {b - a for a, b in pairwise(found[len(hit) - 1:])} == {1}
            assert hit[0] == begins + interval
            assert before is None or begins == before + 1
            before = found[-1]
        assert timed >= 3

    def make(self, config):
        self.now_bits = config.memory.data_bits
        return super().make(config)

    def unstalled(self, given, cycles, half):
        """The first half of each stream: what belongs to later sections is missing in one of them."""
        return {name: cycles[name][:half[name]] for name in given.inputs} | {"o": cycles["o"][:len(cycles["o"]) // 2]}


class TestWideBeats(TestResultPacker):
    """Beats of 512 bits."""

    test_in_amaranth = None
    simulators = SIMULATORS[1:]
    changes = {"memory.data_bits": 512}


class TestBeatsOf32Bytes(TestWideBeats):
    changes = {"memory.data_bits": 256}

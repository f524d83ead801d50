"""The results of each section are read out, written and reported once, with what was known when its cast ended."""

import numpy as np

from golden.engine.jobs.completion import COMPLETION
from hw.control.section_results import COUNTS, SectionResults
from hw.lib.payload import unpack
from hw.memsys.port.fault import Fault
from hw.memsys.results.result_formats import HitFormat
from hw.registers.error_code import ErrorCode
from tb.lib.bench import Bench


class TestSectionResults(Bench):
    component, variants, span = SectionResults, ({},), 300

    def model(self, config):
        """A cast may begin, and its section may follow another one in the slot, while results are written."""
        step, begin, words = "wait", 0, []
        present = results = unpack(self.make(config).signature.members["results"].shape, 0)
        given = yield
        while True:
            ends = step == "wait" and given.i is not None and given.o_read_out
            outputs = {
                "i": step == "wait" and given.o_read_out, "clear": ends, "i_done": step == "write",
                "o_read_out": 0 if step == "wait" and given.i is not None else None,
                "o_command": results if step == "command" else None, "o": words[0] if step == "report" else None}
            if ends:
                good = given.fault["code"] == ErrorCode.NONE.value
                results = present | ({} if good else {"hit_format": HitFormat.NONE.value, "sums": 0})
                record = {"error": given.fault["code"], "address": given.fault["number"], "begin": begin,
                          "cycles": given.cycles, **given.counts}
                step = "command"
            elif step == "command" and given.o_command:
                step = "write"
            elif step == "write" and given.i_done is not None:
                done, step = given.i_done, "report"
                record |= {"end": given.cycle, "sums": done["sums"] if results["sums"] else 0}
                if good and done["code"] != Fault.NONE.value:
                    record |= {"error": done["code"], "address": done["address"]}
                words = np.array([tuple(record.get(name, 0) for name in COMPLETION.dtype.names)],
                                 COMPLETION.dtype).view("<u8").tolist()
            elif step == "report" and given.o:
                del words[0]
                step = "report" if words else "wait"
            if given.begins:
                present, begin = given.results, given.cycle
            given = yield outputs

    def drive(self, given, random):
        """Half of the casts have no fault."""
        given.begins = random.random() < 0.1
        given.fault = {"code": random.choice((ErrorCode.NONE, ErrorCode.PATH_BUS)).value, "number": given.cycle}

    def items(self, name, shape, random):
        """Half of the results are written without a fault."""
        for item in super().items(name, shape, random):
            yield item if name == "i" else item | {
                "code": random.choice((Fault.NONE, Fault.WRITE_REPLY)).value}


def test_all_fields_of_a_record_are_known():
    assert {*COMPLETION.dtype.names} == {"tag", "error", "cluster", "lap", "address", "sums", "cycles", "begin", "end",
                                         *COUNTS}

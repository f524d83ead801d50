from hw.lib.arbiter import ArbiterPolicy
from hw.noc.output_port import OutputPort
from tb.lib.bench import Bench
from tb.lib.grants import LongestWaiting, RoundRobin
from tb.lib.shift_registers import ShiftRegisters

CHANNELS, SOURCES, DEPTH = 2, 3, 2


class TestOutputPort(Bench):
    component, variants, span = OutputPort, ({},), 400
    arguments = {"bits": 8, "channels": CHANNELS, "sources": SOURCES, "depth": DEPTH}
    rule, is_single_cycle = RoundRobin, False

    def model(self, config):
        """A packet holds its channel from its first flit to its last one; each flit takes a credit."""
        self.free, self.credits, rule = [True] * CHANNELS, [DEPTH] * CHANNELS, self.rule()
        crossing, sent = ShiftRegisters(0 if self.is_single_cycle else 1), None
        given = yield
        while True:
            heads = {k: head for k, head in enumerate(given.heads) if head["valid"]}
            granted = rule.grant(heads, [k for k, head in heads.items() if self.credits[head["channel"]] and (
                self.free[head["channel"]] or not head["first"])])
            outputs = {"grant": 0 if granted is None else 1 << granted, "o": sent,
                       "stalls": bool(heads) and granted is None}
            flit = None if granted is None else (granted, heads[granted])
            crosses = flit if self.is_single_cycle else crossing.end
            sent = crosses and {"channel": crosses[1]["channel"], "flit": {
                "data": given.data[crosses[0]], **{name: crosses[1][name] for name in ("first", "last")}}}
            if not self.is_single_cycle:
                crossing.step(flit, True)
            if flit:
                rule.accept(granted)
                self.credits[flit[1]["channel"]] -= 1
                self.free[flit[1]["channel"]] = bool(flit[1]["last"])
            for channel in range(CHANNELS):
                self.credits[channel] += given.i_credit >> channel & 1
            given = yield outputs

    def drive(self, given, random):
        """Credits of flits that have been sent."""
        given.i_credit = sum(1 << channel for channel, count in enumerate(self.credits)
                             if count < DEPTH and random.random() < 0.4)


class TestInOneCycle(TestOutputPort):
    arguments, is_single_cycle = {**TestOutputPort.arguments, "single_cycle": True}, True
    test_in_the_simulator = None


class TestOldestFirst(TestOutputPort):
    arguments, rule = {**TestOutputPort.arguments, "policy": ArbiterPolicy.LONGEST_WAITING}, LongestWaiting
    test_in_the_simulator = None

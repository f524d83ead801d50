"""Records of all sources in turn, written to a ring; resets, withdrawn words, refused writes and late answers."""

from collections import deque

import numpy as np

from golden.engine.jobs.completion import COMPLETION, lap
from hw.control.completion_writer import RECORDS, CompletionWriter
from hw.control.job_formats import COMPLETION_WORDS
from tb.control.job_descriptors import WIDTHS
from tb.lib.bench import Bench
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency
from tb.memsys.results.extent import saturated

SIZE = COMPLETION.dtype.itemsize


class TestCompletionWriter(Bench):
    component, span = CompletionWriter, 600
    changes = {"noc.columns": 3, "noc.rows": 1}
    variants = [{"memory.data_bits": width} for width in WIDTHS]

    def model(self, config):
        """A record is held from its last word to the answer to its last request; a reset or a failure repeats all."""
        size, clusters = config.memory.beat_bytes, config.noc.clusters
        length, bits = min(SIZE // size, 1 << config.memory.length_bits), config.memory.address_bits
        beats, parts = SIZE // size, SIZE // size // length
        # The last source, and the one whose record is being collected; of records that are held the requests, beats
        # and answers since the last reset.
        last, source, words, held, done = clusters, None, [], deque(), 0
        requested = sent = answers = 0
        wrong = self.failed = self.stopped = self.is_repaired = False
        self.empty, self.unanswered, self.registers = True, 0, (0x5C0, 3)
        given = yield
        while True:
            offers = [*(getattr(given, f"i__{k}") for k in range(clusters)), given.i_record]
            runs, own = not given.stops, source == clusters
            moves = runs and source is not None and offers[source] is not None
            ends = moves and len(words) == COMPLETION_WORDS - 1
            asks = requested < parts * len(held) and runs and not self.failed
            sends = sent < length * requested and runs

            def address(number, part=0, given=given):
                return given.completions + SIZE * (number % (1 << given.ring_bits)) + part * length * size

            beat = sent % beats * size
            outputs = {
                **{f"i__{k}": runs and k == source for k in range(clusters)}, "i_record": ends and own,
                "source": None if source is None or own else source, "completed": done, "empty": self.empty,
                "o_collected": source if ends and not own else None, "failed": self.failed,
                "address": address(done) % (1 << bits),
                "o_request": {"address": saturated(address(done + requested // parts, requested % parts), bits),
                              "length": length - 1, "tag": 0} if asks else None,
                "o_data": {"data": int.from_bytes(held[sent // beats][beat:beat + size], "little"),
                           "strobe": (1 << size) - 1} if sends else None}
            if moves:
                words.append(0 if own else offers[source])
            free = len(held) + (source is not None) < RECORDS
            if ends:
                held.append(record(words, lap(done + len(held), given.ring_bits), **(
                    {"own": given.i_record} if own else {"tag": given.tag, "cluster": source})))
            asking = [k for k in range(last + 1, last + clusters + 2) if offers[k % (clusters + 1)] is not None
                      and k % (clusters + 1) != source]
            if runs and (source is None or ends) and free and asking:
                last = source = asking[0] % (clusters + 1)
                words = []
            elif ends or not runs:
                source = None
            requested += bool(asks and given.o_request)
            if sends and given.o_data:
                sent += 1
                self.unanswered += sent % length == 0
            was_failed, self.failed = self.failed, self.failed and not given.retry
            if given.i_written is not None:
                self.unanswered -= 1
                if runs and not was_failed:
                    answers, wrong = answers + 1, wrong or given.i_written["error"]
            if answers == parts:
                if wrong:
                    self.failed, self.is_repaired = True, False
                else:
                    held.popleft()
                    done, requested, sent = done + 1, requested - parts, sent - beats
                answers, wrong = 0, False
            if not runs:
                requested = sent = answers = self.unanswered = 0
                wrong, self.is_repaired = False, True
            self.stopped, self.empty = not runs, source is None and not held
            given = yield outputs

    def items(self, name, shape, random):
        """Sources and memory pause now and then; memory answers what has been written, or refuses it."""
        pauses = (0, 0, 3, 60) if name in ("i_record", "i_written") else (0,) * 15 + (90,)
        for item in super().items(name, shape, random):
            for _ in range(random.choice(pauses)):
                yield None
            while name == "i_written" and not self.unanswered:
                yield None
            yield {"error": int(random.random() < 0.08)} if name == "i_written" else item

    def drive(self, given, random):
        """A reset loses the clusters' records; a retry follows it. The ring may change while it is not used, and
        may reach beyond the end of memory.
        """
        given.stops = int(random.random() < (0.5 if self.stopped else 0.1 if self.failed else 0.01))
        given.retry = int(random.random() < 0.1 and (self.is_repaired or not self.failed))
        if self.stopped:
            for name in [name for name in vars(given) if name.startswith("i__")]:
                setattr(given, name, None)
        if (self.empty or self.failed) and random.random() < 0.1:
            top = 1 << self.config().memory.address_bits
            self.registers = 64 * random.choice((random.randrange(1 << 20), top // 64 - random.randrange(1, 9))), (
                random.choice((0, 1, 2, 5, 31)))
        given.completions, given.ring_bits = self.registers


class TestShortRequests(TestCompletionWriter):
    """Some requests make a record: it is written again if any of them fails."""

    changes = {**TestCompletionWriter.changes, "memory.length_bits": 1}
    variants = ({},)


class TestOneCluster(TestCompletionWriter):
    changes, variants, constant = {"noc.columns": 1, "noc.rows": 1}, ({},), ("source", "o_collected__payload")
    test_in_the_simulator = None


class TestFiveClusters(TestOneCluster):
    changes, constant = {"noc.columns": 5, "noc.rows": 1}, ()


def record(words, number, *, own=None, **last):
    """The bytes of a record: a cluster's words, of which the last one has the error alone, or one without a cluster."""
    found = np.array(words, "<u8").view(COMPLETION.dtype)[0].copy()
    fields = {"lap": number, **last}
    if own is not None:
        fields |= {"tag": own["tag"], "error": own["code"], "cluster": own["cluster"], "address": own["number"],
                   "begin": own["begin"], "end": own["end"]}
    for name, value in fields.items():
        found[name] = value
    return found.tobytes()


def test_latency():
    """From the offer of a record to its request."""
    config = TestCompletionWriter().config()
    bench = ScheduleBench(CompletionWriter(config=config))
    bench.run(Schedule(items={"i_record": [(0, {})]}))
    latency, = (request - offer for request, offer in zip(
        bench.cycles["o_request"], bench.trace.offered["i_record"], strict=True))
    assert latency == documented_latency(CompletionWriter, config) == CompletionWriter.latency

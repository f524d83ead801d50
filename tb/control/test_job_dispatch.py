"""Descriptors that keep golden's rules or break one, for clusters that request sections in any order."""

from random import Random

from golden.engine.jobs.completion import NO_CLUSTER
from golden.engine.jobs.descriptor import ANY_CLUSTER, RULES, Kind, check_descriptor
from hw.control.job_dispatch import JobDispatch
from hw.control.job_formats import DESCRIPTOR_WORDS, NEAR_INDEX, JobFormats, byte_of
from hw.registers.error_code import ErrorCode
from tb.control.job_descriptors import changed, descriptor, near_words, words_of
from tb.lib.bench import Bench
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CLUSTERS = 3
NODES = {"noc.columns": CLUSTERS, "noc.rows": 1}
CONFIG = config_of(NODES)
SIDE = 1 << CONFIG.icu.side_bits
TILES = CONFIG.icu.rays >> 2 * CONFIG.icu.tile_bits
TILE = 1 << CONFIG.icu.tile_bits
WHOLE, BITS = {"first_column": 0, "first_row": 0}, {"bundle": 2, "hit_format": 0, "sums": 0}
# Numbers that do not fit all formats of results.
WIDE = {"icu.uv_bits": 9, "icu.patch_bits": 23}
# Changes of a good descriptor: each limit, one below and one above it.
LIMITS = [
    *({"version": value} for value in (0, 1, 2, 257)), *({"kind": value} for value in (0, 1, 2, 255)),
    *({"hit_format": value} for value in (0, 1, 2, 3, 4, 255)), *({"sums": value} for value in (0, 1, 2)),
    *({"context": value} for value in (1, 128)),
    *({"cluster": value} for value in (0, CLUSTERS - 1, CLUSTERS, ANY_CLUSTER - 1, ANY_CLUSTER)),
    *({name: value} for name in ("hits", "sums_address") for value in (
        0, 32, 63, 64, (1 << 40) - 64, 1 << 40, (1 << 64) - 64)),
    *({"near_cells": value} for value in (4, 8, (1 << 40) - 8, 1 << 40)),
    *({"near_count": value} for value in (0, 1, 2, (1 << 9) - 1, 1 << 9, (1 << 9) + 1, 1 << 31)),
    *({"last_shell": value} for value in (0, 1, 63, 64, 1 << 31)), *({"reserved": value} for value in (1, 1 << 31)),
    *({"ray_count": value} for value in (1, 1 << 31)), *({"bundle": value} for value in (0, 1, 2, 1 << 31)),
    *({"columns": value, "end_column": 1} for value in (SIDE, SIDE + 1, 1 << 31)),
    *({"rows": value, "end_row": 1} for value in (SIDE, SIDE + 1)),
    *({**WHOLE, "end_column": end, "columns": 12, "end_row": 1} for end in (0, 1, 12, 13)),
    *({**WHOLE, "end_row": end, "rows": 12, "end_column": 1} for end in (0, 1, 12, 13)),
    *({**WHOLE, "first_column": first, "end_column": 8, "columns": 12} for first in (7, 8, 9)),
    *({**WHOLE, "first_row": first, "end_row": 8, "rows": 12} for first in (7, 8, 9)),
    *({**WHOLE, "end_column": SIDE + more, "columns": SIDE, "end_row": 1} for more in (-1, 0, 1)),
    # In a frustum as large, the section is the first field that breaks a rule.
    *({"first_column": SIDE - 1, "end_column": SIDE + more, "columns": SIDE + more, "first_row": 0, "end_row": 1}
      for more in (0, 1)),
    *({"first_row": SIDE - 1, "end_row": SIDE + more, "rows": SIDE + more, "first_column": 0, "end_column": 1}
      for more in (0, 1)),
    # Tiles of the whole ray memory, and a row or a column more; unfinished tiles count.
    *({**WHOLE, "end_column": 16 * TILE + more, "columns": SIDE, "end_row": TILES // 16 * TILE + below, "rows": SIDE}
      for more in (-1, 0, 1) for below in (-1, 0, 1)),
    # As many columns and rows as there are numbers for.
    *({**WHOLE, "end_column": SIDE, "columns": SIDE, "end_row": end, "rows": SIDE}
      for end in (TILES * TILE * TILE // SIDE, TILES * TILE * TILE // SIDE + 1, SIDE)),
    {"kind": 1, "hit_format": 9, "sums": 9, "near_cells": 1, "near_count": 1 << 20, "last_shell": 0, "end_column": 0},
    {"kind": 1, "hits": 32}, {"kind": 1, "context": 1}, {"kind": 1, "reserved": 2},
    *({"kind": 1, "cluster": value} for value in (0, 1, CLUSTERS - 1, CLUSTERS, 77, ANY_CLUSTER - 1, ANY_CLUSTER)),
    {"kind": 1, "hits": 1 << 40}, {"version": 7, "kind": 9}, {"sums": 2, "reserved": 1}, {"kind": 9, "reserved": 1},
    # Lists of rays.
    *({**BITS, "bundle": value} for value in (1, 2, 3)),
    *({**BITS, "hit_format": hits, "sums": sums} for hits in range(4) for sums in range(2)),
    *({**BITS, "ray_count": value} for value in (1, 16, 17, 1 << 31)),
    {"bundle": 0, "ray_count": 1}, {"bundle": 1, "ray_count": 16}, {**BITS, "near_count": 0, "ray_count": 3}]


class TestJobDispatch(Bench):
    component, changes, variants, span = JobDispatch, NODES, ({},), 500
    # Shares of descriptors with words of near cells, or with any word, that could not be read; reasons of refusals;
    # parts of the table so far.
    unread, broken, parts = (0.3, 0.02), frozenset(), 0

    def model(self, config):
        """A descriptor begins a cycle before its first word is taken; a word is passed on when the next one is."""
        regions = (1 << JobFormats(config).load_job["regions"].shape) - 1
        step, waiting, load, refused = "begin", [], None, None
        self.present, self.busy, self.requesting = config, 0, 1
        given = yield
        while True:
            outputs = {
                "i": step == "words", "o": None, "o_sent": None, "failed": step == "failed", "busy": self.busy,
                "o_load": load if step == "load" else None, "o_refused": refused if step == "refuse" else None}
            served, returned, following = None, None, step
            if step == "begin" and given.i is not None and given.enable:
                one = self.one
                load = {"tag": one["tag"], "image": int(one["hits"]), "regions": int(one["regions"]) & regions,
                        "copies": int(one["cluster"] == 0)}
                needs = (not given.i["error"] and given.loaded and one["kind"] == Kind.FRUSTUM
                         and (one["cluster"] < config.noc.clusters or one["cluster"] == ANY_CLUSTER))
                served = next((k for k in waiting if one["cluster"] in (k, ANY_CLUSTER)), None) if needs else None
                if not needs or served is not None:
                    following, cluster, unloaded = "words", served, not given.loaded
                    word, unread, near_unread = None, False, False
            elif step == "words" and given.i is not None:
                if word is not None and cluster is not None:
                    outputs["o"] = word | {"cluster": cluster, "void": 0}
                word = {name: given.i[name] for name in ("index", "data", "last")}
                unread |= given.i["error"] and word["index"] != NEAR_INDEX
                near_unread |= given.i["error"] and word["index"] == NEAR_INDEX
                following = "end" if word["last"] else "words"
            elif step == "end":
                reason = self.reason(one, near_unread, unloaded, given.last_shell)
                following = ("failed" if unread else "refuse" if reason else "load" if one["kind"] == Kind.LOAD
                             else "begin")
                refused = {"tag": one["tag"], "cluster": NO_CLUSTER, "code": reason and reason[0],
                           "number": reason and reason[1], "begin": 0, "end": 0}
                if cluster is not None:
                    outputs["o"] = word | {"cluster": cluster, "void": following != "begin"}
                    returned = cluster if following != "begin" else None
                if following == "begin":
                    outputs["o_sent"] = {"cluster": cluster, "tag": one["tag"]}
            elif (step == "load" and given.o_load) or (step == "refuse" and given.o_refused):
                following = "begin"
            waiting = [k for k in waiting if k != served]
            waiting += [k for k in range(config.noc.clusters)
                        if k not in waiting and (given.requests >> k & 1 or k == returned)]
            step, self.busy = following, following in ("words", "end", "refuse")
            given = yield outputs

    def reason(self, one, near_unread, unloaded, last_shell):
        """The code and the number of a refusal, or None: first golden's."""
        refusal, is_section = check_descriptor(one, self.present), one["kind"] == Kind.FRUSTUM
        self.broken |= {refusal and refusal.reason}
        if refusal:
            return ErrorCode[refusal.code].value, refusal.byte
        if near_unread:
            return ErrorCode.READ_REPLY.value, int(one["near_cells"])
        if is_section and (unloaded or one["last_shell"] > last_shell):
            return ErrorCode.NOT_LOADED.value, 0 if unloaded else byte_of("last_shell")
        return None

    def fields(self, random):
        """What is changed of each descriptor."""
        while True:
            yield random.choice(({}, {"cluster": random.randrange(CLUSTERS)}, {"kind": Kind.LOAD}, {
                "kind": Kind.LOAD, "cluster": 0}, random.choice(LIMITS)))

    def items(self, name, shape, random):
        """Words; some of near cells, and few others, could not be read: whatever is drawn, of the last part's fourth
        descriptor.
        """
        self.parts += 1
        is_last = self.parts % len(self.chances) == 0
        for count, fields in enumerate(self.fields(random)):
            self.one = one = changed(descriptor(self.present, random), **fields)
            words = [*words_of(one), *(random.getrandbits(64) for _ in range(near_words(one, self.present)))]
            unread = {random.randrange(first, len(words)) for first, share in zip((DESCRIPTOR_WORDS, 0), self.unread,
                      strict=True) if first < len(words) and random.random() < share}
            if is_last and count == 3 and self.unread[1]:
                unread |= {0}
            self.requesting = random.choice((0.004, 0.02, 0.3))
            for number, data in enumerate(words):
                yield {"index": min(number, NEAR_INDEX), "data": data, "last": int(number == len(words) - 1),
                       "error": int(number in unread)}

    def drive(self, given, random):
        """Clusters request sections, sometimes late; tables are loaded between descriptors."""
        given.requests = sum(1 << k for k in range(CLUSTERS) if random.random() < self.requesting)
        if not self.busy:
            self.tables = int(random.random() < 0.9), random.choice((63, random.randrange(1, 64)))
        given.loaded, given.last_shell = self.tables


class TestLimits(TestJobDispatch):
    """Each rule at its limit, in a machine with shadow frusta and numbers that do not fit all formats of results."""

    changes, unread, span, chances = {**NODES, **WIDE, "icu.shadow_bits": 4}, (0, 0), 4600, ((1, 1),)
    constant = ("failed",)

    def fields(self, random):
        """Those of the list."""
        yield from ({"hit_format": 0, "sums": 0} | one for one in LIMITS)

    def drive(self, given, random):
        """All shells are loaded, and clusters always request a section."""
        super().drive(given, random)
        given.enable, given.requests = 1, (1 << CLUSTERS) - 1
        given.loaded, given.last_shell = 1, 63

    def test_in_amaranth(self, changes):
        """Every rule of golden's is broken, and none of a descriptor."""
        super().test_in_amaranth(changes)
        assert self.broken == {None, *(rule.about for rule in RULES)}


class TestOthers(TestJobDispatch):
    """One cluster; a node without one, whose sections are refused; numbers that do not fit one format; many tiles."""

    variants = ({"noc.columns": 1}, {"noc.patch_nodes": 1}, *({name: bits} for name, bits in WIDE.items()),
                {"icu.side_bits": 16, "icu.tile_bits": 1})
    test_in_the_simulator = None


def test_latency():
    """From a first word to its first word for a cluster that has requested it."""
    words = [{"index": k, "data": word, "last": int(k == DESCRIPTOR_WORDS - 1), "error": 0}
             for k, word in enumerate(words_of(descriptor(CONFIG, Random(1), near_count=0)))]
    bench = ScheduleBench(JobDispatch(config=CONFIG))
    bench.run(Schedule(items={"i": [(2, words[0]), *((0, word) for word in words[1:])]}),
              enable=1, loaded=1, last_shell=63, requests=1)
    assert len(bench.cycles["o"]) == DESCRIPTOR_WORDS
    latency = bench.cycles["o"][0] - bench.trace.offered["i"][0]
    assert latency == documented_latency(JobDispatch, CONFIG) == JobDispatch.latency

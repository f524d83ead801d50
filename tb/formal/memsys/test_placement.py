from amaranth.hdl import Array, Assert, Assume, Const, Cover, Mux, Signal

from hw.lib.update_memory import UpdateMemory
from hw.memsys.bus.lfu_placement import LfuPlacement
from hw.memsys.bus.set_placement import SetPlacement
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import with_parts
from tb.formal.stream_rules import add_rules

KEY = 3


def follows_the_rule(m, bench, dut, rule, direct=None):
    """Answers come in order, one for each request, with the hits and the lines of the rule.

    The rule is that of golden, one request after the other, each at once. It is evaluated when an answer comes: the
    key is the tag. ``rule``: from a module, a key, whether it is requested now, and whether all lines are emptied, to
    whether it hits, and its line. ``direct``: always that policy of the set placement.
    """
    add_rules(m, dut.i_start, Assume)
    sends, inside, begun, starts = Signal(), Signal(4), Signal(), transfers(dut.i_start)
    m.d.comb += [sends.eq(transfers(dut.i)), Assume(dut.i.payload.tag == dut.i.payload.key)]
    m.d.sync += [inside.eq(inside + sends - dut.o.valid), begun.eq(begun | starts)]
    if direct is not None:
        m.d.comb += dut.direct.eq(direct)
    with m.If(dut.i_start.valid | ~begun):
        m.d.comb += Assume(~dut.i.valid)
    with m.If(dut.i_start.valid):
        m.d.comb += Assume(inside == 0)
    got = dut.o.payload
    hit, line = rule(m, got.tag, dut.o.valid, starts)
    with m.If(dut.o.valid):
        m.d.comb += [Assert(inside != 0, "once"), Assert(got.hit == hit, "hit"), Assert(got.line == line, "line")]
    hits, misses = Signal(2), Signal(3)
    m.d.sync += [hits.eq(hits + (dut.o.valid & got.hit & (hits != 3))),
                 misses.eq(misses + (dut.o.valid & ~got.hit & (misses != 7)))]
    m.d.comb += Cover((hits >= 1) & (misses >= 3) & dut.o.valid & got.hit, "hits after misses")


def used_last(sets, ways, direct):
    """Each set keeps its keys in the order of their last use; ``direct`` when each key has one way."""
    def rule(m, key, requested, starts):
        set_index = Mux(Const(1) if sets > 1 else Const(0), key[:sets.bit_length() - 1] if sets > 1 else 0, 0)
        content = Array(Array(Signal(KEY, name=f"content_{s}_{w}") for w in range(ways)) for s in range(sets))
        full = Array(Signal(ways, name=f"full_{s}") for s in range(sets))
        # Of two ways: which one was used last.
        last = Array(Signal(init=1, name=f"last_{s}") for s in range(sets))
        found = [full[set_index][way] & (content[set_index][way] == key) for way in range(ways)]
        if direct:
            forced = key[sets.bit_length() - 1]
            found = [one & (forced == way) for way, one in enumerate(found)]
        way = Signal()
        hit = Signal()
        m.d.comb += [hit.eq(found[0] | found[1]),
                     way.eq(Mux(hit, found[1], forced if direct else ~last[set_index]))]
        for s in range(sets):
            for w in range(ways):
                with m.If(requested & (set_index == s) & (way == w)):
                    m.d.sync += [content[s][w].eq(key), full[s][w].eq(1), last[s].eq(w)]
            with m.If(starts):
                m.d.sync += [full[s].eq(0), last[s].eq(1)]
        return hit, way * sets + set_index

    return rule


def used_least(lines, top):
    """Each line counts; of those with the least count the one goes that comes first after the line filled last."""
    def rule(m, key, requested, starts):
        content = [Signal(KEY, name=f"content_{k}") for k in range(lines)]
        count = [Signal(range(top + 1), name=f"count_{k}") for k in range(lines)]
        after, line, hit = Signal(range(lines)), Signal(range(lines)), Signal()
        found = [(count[k] != 0) & (content[k] == key) for k in range(lines)]
        # How late each line would go: its count, then its distance.
        late = []
        for k in range(lines):
            distance = Signal(range(lines), name=f"distance_{k}")
            m.d.comb += distance.eq(k - after)
            late.append(count[k] * lines + distance)
        m.d.comb += line.eq(0)
        for k in range(lines):
            first = Const(1)
            for other in range(lines):
                if other != k:
                    first = first & (late[k] < late[other])
            with m.If(Mux(hit, found[k], first)):
                m.d.comb += line.eq(k)
        m.d.comb += hit.eq(sum(found) != 0)
        with m.If(requested & ~hit):
            m.d.sync += after.eq(line + 1)
        for k in range(lines):
            with m.If(requested & (line == k)):
                m.d.sync += [content[k].eq(key), count[k].eq(Mux(hit, Mux(count[k] == top, top, count[k] + 1), 1))]
            with m.If(starts):
                m.d.sync += count[k].eq(0)
        with m.If(starts):
            m.d.sync += after.eq(0)
        return hit, line

    return rule


class Blind(UpdateMemory):
    """Does not look at the request just in front."""

    def _same_as(self, m, addresses, ahead, *, age):
        return Const(0) if ahead == 1 else super()._same_as(m, addresses, ahead, age=age)


def of_sets(direct=0, taken_for=None, kind=SetPlacement):
    rule = used_last(2, 2, direct if taken_for is None else taken_for)
    return Bench(follows_the_rule, kind(lines=4, ways=2, key=KEY, tag=KEY, generation_bits=1), rule=rule, direct=direct)


def of_counts(lines=2, count_bits=2, alter=lambda hit, line: (hit, line)):
    def rule(*given):
        return alter(*used_least(lines, 3)(*given))

    return Bench(follows_the_rule, LfuPlacement(lines=lines, key=KEY, tag=KEY, count_bits=count_bits), rule=rule)


test_sets = declare(
    of_sets, cycles=18, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(direct=direct) for direct in (0, 1)],
    controls={
        "does not see the request in front": Control("hit", kind=with_parts(SetPlacement, UpdateMemory=Blind)),
        "least recently used instead of direct": Control("line", direct=0, taken_for=1),
        "direct instead of least recently used": Control("line", direct=1, taken_for=0, nightly=True),
        "a start that empties nothing": Control("hit", {"i_start__ready": lambda dut: 1}, nightly=True),
        "an answer twice": Control("once", {"o__valid": lambda dut: dut.o.valid | dut.i.valid}),
    })
test_counts = declare(
    of_counts, cycles=28, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(lines=2),
            *(Claim(lines=lines, cycles=34, nightly=True) for lines in (2, 4))],
    controls={
        "counters of another width": Control("line", count_bits=3, nightly=True),
        "lines in another order": Control("line", alter=lambda hit, line: (hit, ~line)),
    })

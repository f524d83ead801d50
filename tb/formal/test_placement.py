import pytest
from amaranth.hdl import Array, Assert, Assume, Const, Cover, Module, Mux, Signal
from amaranth.lib import wiring

from hw.lib.update_memory import UpdateMemory
from hw.memsys import set_placement
from hw.memsys.lfu_placement import LfuPlacement
from hw.memsys.set_placement import SetPlacement
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

KEY = 3


class PlacementRule(wiring.Component):
    """Answers come in order, one for each request, with the hits and the lines of the rule.

    The rule is that of golden, one request after the other, each at once. It is asked when an answer comes: the key
    is the tag.

    Parameters
    ----------
    dut
        The placement.
    rule
        From a module, a key, whether it is asked now and whether all lines are emptied to whether it hits and its line.
    """

    def __init__(self, dut, rule):
        self._dut, self._rule = dut, rule
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, dut.i_start, Assume)
        sends, inside, begun = Signal(), Signal(4), Signal()
        starts = dut.i_start.valid & dut.i_start.ready
        m.d.comb += [sends.eq(dut.i.valid & dut.i.ready), Assume(dut.i.payload.tag == dut.i.payload.key)]
        m.d.sync += [inside.eq(inside + sends - dut.o.valid), begun.eq(begun | starts)]
        with m.If(dut.i_start.valid | ~begun):
            m.d.comb += Assume(~dut.i.valid)
        with m.If(dut.i_start.valid):
            m.d.comb += Assume(inside == 0)
        got = dut.o.payload
        hit, line = self._rule(m, got.tag, dut.o.valid, starts)
        with m.If(dut.o.valid):
            m.d.comb += [Assert(inside != 0), Assert(got.hit == hit), Assert(got.line == line)]
        hits, misses = Signal(2), Signal(3)
        m.d.sync += [hits.eq(hits + (dut.o.valid & got.hit & (hits != 3))),
                     misses.eq(misses + (dut.o.valid & ~got.hit & (misses != 7)))]
        m.d.comb += Cover((hits >= 1) & (misses >= 3) & dut.o.valid & got.hit)
        return m


def used_last(sets, ways, direct):
    """Each set keeps its keys in the order of their last use; ``direct`` when each key has one way."""
    def rule(m, key, asked, starts):
        place = Mux(Const(1) if sets > 1 else Const(0), key[:sets.bit_length() - 1] if sets > 1 else 0, 0)
        content = Array(Array(Signal(KEY, name=f"content_{s}_{w}") for w in range(ways)) for s in range(sets))
        full = Array(Signal(ways, name=f"full_{s}") for s in range(sets))
        # Of two ways: which one was used last.
        last = Array(Signal(init=1, name=f"last_{s}") for s in range(sets))
        found = [full[place][way] & (content[place][way] == key) for way in range(ways)]
        if direct:
            forced = key[sets.bit_length() - 1]
            found = [one & (forced == way) for way, one in enumerate(found)]
        way = Signal()
        hit = Signal()
        m.d.comb += [hit.eq(found[0] | found[1]),
                     way.eq(Mux(hit, found[1], forced if direct else ~last[place]))]
        for s in range(sets):
            for w in range(ways):
                with m.If(asked & (place == s) & (way == w)):
                    m.d.sync += [content[s][w].eq(key), full[s][w].eq(1), last[s].eq(w)]
            with m.If(starts):
                m.d.sync += [full[s].eq(0), last[s].eq(1)]
        return hit, way * sets + place

    return rule


def used_least(lines, top):
    """Each line counts; of those with the least count the one goes that comes first after the line filled last."""
    def rule(m, key, asked, starts):
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
        with m.If(asked & ~hit):
            m.d.sync += after.eq(line + 1)
        for k in range(lines):
            with m.If(asked & (line == k)):
                m.d.sync += [content[k].eq(key), count[k].eq(Mux(hit, Mux(count[k] == top, top, count[k] + 1), 1))]
            with m.If(starts):
                m.d.sync += count[k].eq(0)
        with m.If(starts):
            m.d.sync += after.eq(0)
        return hit, line

    return rule


class Fixed(wiring.Component):
    """A set placement that is always direct, or never."""

    def __init__(self, dut, direct):
        self._dut, self._direct = dut, direct
        members = dict(dut.signature.members.items())
        del members["direct"]
        super().__init__(members)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        m.d.comb += dut.direct.eq(self._direct)
        for name in self.signature.members:
            port = getattr(self, name)
            wiring.connect(m, getattr(dut, name), wiring.flipped(port))
        return m


def of_sets(*, direct, kind=SetPlacement, lines=4):
    return Fixed(kind(lines=lines, ways=2, key=KEY, tag=KEY, generation_bits=1), direct)


def of_counts(lines=2, count_bits=2):
    return LfuPlacement(lines=lines, key=KEY, tag=KEY, count_bits=count_bits)


@pytest.mark.parametrize("direct", [0, 1])
def test_sets(direct):
    assert prove(PlacementRule(of_sets(direct=direct), used_last(2, 2, direct)), mode="bmc", depth=18,
                 engine="abc bmc3")


@pytest.mark.parametrize(("lines", "depth"), [
    (2, 24), pytest.param(2, 34, marks=pytest.mark.nightly), pytest.param(4, 34, marks=pytest.mark.nightly)])
def test_counts(lines, depth):
    assert prove(PlacementRule(of_counts(lines), used_least(lines, 3)), mode="bmc", depth=depth, engine="abc bmc3")


@pytest.mark.parametrize("name", ["sets", pytest.param("counts", marks=pytest.mark.nightly)])
def test_reaches_hits_after_misses(name):
    bench = {"sets": lambda: PlacementRule(of_sets(direct=0), used_last(2, 2, 0)),
             "counts": lambda: PlacementRule(of_counts(), used_least(2, 3))}[name]()
    assert prove(bench, mode="cover", depth=34)


class Blind(UpdateMemory):
    """Does not look at the request just in front."""

    def _same_as(self, m, addresses, ahead, *, age):
        return Const(0) if ahead == 1 else super()._same_as(m, addresses, ahead, age=age)


def test_a_set_that_does_not_see_the_request_in_front(monkeypatch):
    monkeypatch.setattr(set_placement, "UpdateMemory", Blind)
    assert not prove(PlacementRule(of_sets(direct=0), used_last(2, 2, 0)), mode="bmc", depth=16, engine="abc bmc3")


@pytest.mark.parametrize(("direct", "taken_for"), [(0, 1), (1, 0)])
def test_one_policy_is_not_the_other(direct, taken_for):
    assert not prove(PlacementRule(of_sets(direct=direct), used_last(2, 2, taken_for)), mode="bmc", depth=16,
                     engine="abc bmc3")


@pytest.mark.nightly
def test_counters_of_another_width():
    assert not prove(PlacementRule(of_counts(2, 3), used_least(2, 3)), mode="bmc", depth=40, engine="abc bmc3")


def test_lines_in_another_order():
    def rule(*given):
        hit, line = used_least(2, 3)(*given)
        return hit, ~line

    assert not prove(PlacementRule(of_counts(), rule), mode="bmc", depth=24, engine="abc bmc3")


FAULTS = {"a start that empties nothing": {"i_start__ready": lambda dut: 1},
          "an answer twice": {"o__valid": lambda dut: dut.o.valid | dut.i.valid}}


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    control = NegativeControl(of_sets(direct=0), FAULTS[fault])
    assert not prove(PlacementRule(control, used_last(2, 2, 0)), mode="bmc", depth=16, engine="abc bmc3")

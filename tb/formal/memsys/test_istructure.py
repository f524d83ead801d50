"""The I-structure: each read is answered once, with the data that was written first in its version.

One location is proved at a time, among any number of others, whose rows may say anything: with an abstract store, of
which no more is known than what test_deferred_store.py proves of the store for owners who use it as they should; and it
is proved that the location does.
"""

from types import SimpleNamespace

from amaranth.hdl import Assert, Assume, Cat, Const, Cover, Elaboratable, Fragment, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.memsys.patches.istructure import IStructure
from tb.formal.bench import Bench, transfers
from tb.formal.connect_ports import connect_ports
from tb.formal.declare import Claim, Control, declare
from tb.formal.memsys.istructure_cycles import CLOSING, REFUSAL
from tb.formal.source_fault import with_parts
from tb.formal.stream_rules import add_rules


def written_once(m, bench, dut, depth, deferred=None):
    """Any one location, and any one read of it at a time, whose tag is 1.

    Bounds are asserted only if ``deferred`` is given.
    """
    location = bench.choose(m, range(depth), "location")
    if hasattr(dut, "location"):
        m.d.comb += dut.location.eq(location)
    for given in (dut.i_start, dut.i_read, dut.i_write):
        add_rules(m, given, Assume)
    add_rules(m, dut.o_read, Assert)
    read_request, answer = dut.i_read.payload, dut.o_read.payload
    starts, reads, writes, gives = (transfers(port) for port in (dut.i_start, dut.i_read, dut.i_write, dut.o_read))
    m.d.comb += [Assume(location < depth), Assume(read_request.address < depth),
                 Assume(dut.i_write.payload.address < depth)]

    # The location.
    begun, written, data, refuses = Signal(), Signal(), Signal(), Signal(REFUSAL)
    here = writes & (dut.i_write.payload.address == location)
    with m.If(here & ~written):
        m.d.sync += [written.eq(1), data.eq(dut.i_write.payload.data)]
    with m.If(starts):
        m.d.sync += written.eq(0)
    m.d.sync += [refuses.eq((refuses << 1) | (here & written)), begun.eq(begun | starts)]
    m.d.comb += [Assert((dut.o_refused.valid & (dut.o_refused.payload == location)) == refuses[-1], "refusal"),
                 Assert(begun | ~(reads | writes), "begun")]
    with m.If(begun & ~dut.i_start.valid):
        m.d.comb += Assert(dut.i_write.ready, "write")

    # The read: it is due when its location is written; then it is answered once, with the data.
    mine = reads & read_request.tag
    out, due, expected = Signal(), Signal(), Signal()
    m.d.comb += Assume(~mine | (~out & (read_request.address == location)))
    with m.If(mine):
        m.d.sync += out.eq(1)
    with m.If((out | mine) & ~due & (written | here)):
        m.d.sync += [due.eq(1), expected.eq(data)]
        with m.If(~written):
            m.d.sync += expected.eq(dut.i_write.payload.data)
    with m.If(dut.o_read.valid & answer.tag):
        m.d.comb += [Assert(out, "once"), Assert(~out | due, "early"), Assert(~due | (answer.data == expected), "data")]
    with m.If(gives & answer.tag):
        m.d.sync += [out.eq(0), due.eq(0)]
    with m.If(starts):
        m.d.comb += Assert(~out | due, "start")

    # Answers with 1: of a read that waited, where the store was full, and in a second version.
    waited, again, answered = Signal(), Signal(), gives & answer.tag & expected
    m.d.sync += [waited.eq(waited | (dut.waiting == (deferred or 1))), again.eq(again | (starts & begun))]
    m.d.comb += [Cover(answered & waited, "waited"), Cover(answered & again, "again")]
    if deferred is not None:
        _bound(m, dut, depth, deferred, out, due, starts, reads, gives, begun)


def _bound(m, dut, depth, deferred, out, due, starts, reads, gives, begun):
    """Bounds, in cycles in which answers can leave: of a read that is due while the store is not full or once it waits
    itself; of an offered read while the store is not full; of a start when no reads are inside.
    """
    inside, waits = Signal(range(deferred + 12)), Signal()
    m.d.sync += inside.eq(inside + reads - gives)
    m.d.comb += Assert(inside <= deferred + 6, "capacity")
    # All that are inside wait, so this one does.
    all_wait = out & ~due & (inside == dut.waiting)
    m.d.sync += waits.eq((waits | all_wait) & ~(gives & dut.o_read.payload.tag))
    not_full = dut.waiting != deferred
    for name, counts, idles, bound in (
            ("answer", due & dut.o_read.ready & (not_full | waits), ~due, deferred + 11),
            ("offer", dut.o_read.ready & not_full, ~(begun & dut.i_read.valid & ~dut.i_read.ready) | dut.i_start.valid,
             deferred + 6),
            ("start", inside == 0, ~dut.i_start.valid | starts, depth + CLOSING)):
        late = Signal(range(bound + 2), name=f"late_{name}")
        with m.If(idles):
            m.d.sync += late.eq(0)
        with m.Elif(counts & (late != bound + 1)):
            m.d.sync += late.eq(late + 1)
        m.d.comb += Assert(late <= bound, f"late {name}")


class Row(Elaboratable):
    """Instead of a memory: the row of the location; others say anything, and so does one that is being written."""

    def __init__(self, *, shape, depth, init, attrs):
        self.location, self._shape, self._depth, self._reads = Signal(range(depth)), shape, depth, []
        self._write = self._port()
        self._write.en = Signal()

    def _port(self):
        port = SimpleNamespace()
        port.addr, port.data = Signal(range(self._depth)), Signal(self._shape)
        return port

    def write_port(self):
        return self._write

    def read_port(self, *, domain):
        port = self._port()
        port.noise = Signal.like(port.data)
        self._reads.append(port)
        return port

    @property
    def noise(self):
        """All that is said instead of a row."""
        return Cat(port.noise for port in self._reads)

    @property
    def version(self):
        """What is written into the row."""
        return self._write.data.version

    @property
    def written(self):
        """The row of the location is written."""
        return self._write.en & (self._write.addr == self.location)

    def elaborate(self, platform):
        m = Module()
        row = Signal(self._shape, reset_less=True)
        with m.If(self.written):
            m.d.sync += row.eq(self._write.data)
        for port in self._reads:
            m.d.comb += port.data.eq(port.noise)
            with m.If((port.addr == self.location) & ~self.written):
                m.d.comb += port.data.eq(row)
        return m


class AbstractStore(wiring.Component):
    """All that a store may do, as far as one read can tell. A chain is a stamp, another one with each item, perhaps.

    ``moods``: whether an entry is free, another read leaves, it is the last one, this one leaves; the next stamp.
    ``adds``, ``frees``: the chain is the location's.
    """

    def __init__(self, shape, *, depth, tag):
        self.chain = StructLayout({"some": 1, "stamp": 1})
        items = StructLayout({"tag": tag, "data": shape})
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "chain": self.chain}))), "longer": Out(self.chain),
            "i_release": In(stream.Signature(StructLayout({"chain": self.chain, "data": shape}), always_ready=True)),
            "o": Out(stream.Signature(items)), "waiting": Out(1),
            "moods": In(5), "adds": In(1), "frees": In(1), "lives": Out(1)})

    def elaborate(self, platform):
        m = Module()
        has_entry, other_leaves, last_leaves, leaves, stamp = self.moods
        others, waits, due, expected, moves = Signal(), Signal(), Signal(), Signal(), Signal()
        lives, last = self.lives, Signal()
        mine, takes = self.i.payload.tag, self.i.valid & self.i.ready
        m.d.comb += [self.i.ready.eq(has_entry), self.longer.some.eq(1), self.longer.stamp.eq(stamp),
                     self.waiting.eq(others | waits | due | lives), moves.eq(self.o.ready | ~self.o.valid)]
        with m.If(takes & mine):
            m.d.sync += waits.eq(1)
        with m.If(self.frees & waits):
            m.d.sync += [waits.eq(0), due.eq(1), expected.eq(self.i_release.payload.data)]
        with m.If(moves):
            m.d.sync += [self.o.valid.eq(others & other_leaves), self.o.payload.tag.eq(0)]
            with m.If(due & leaves):
                m.d.sync += [due.eq(0), self.o.valid.eq(1), self.o.payload.tag.eq(1), self.o.payload.data.eq(expected)]
            with m.Elif(other_leaves & last_leaves):
                m.d.sync += others.eq(0)
        with m.If(takes & ~mine):
            m.d.sync += others.eq(1)

        # The location uses the store as it should: with the chain's last stamp, and not when it is released.
        given, released = self.i.payload.chain, self.i_release.payload.chain
        m.d.comb += Assert(~(self.adds & self.frees), "use")
        with m.If(self.adds):
            m.d.sync += [lives.eq(1), last.eq(stamp)]
            m.d.comb += [Assert(takes, "use"), Assert(given.some == lives, "chain"),
                             Assert(~lives | (given.stamp == last), "chain")]
        with m.If(self.frees):
            m.d.sync += lives.eq(0)
            m.d.comb += [Assert(lives, "use"), Assert(released.stamp == last, "chain")]
        m.d.comb += Assert(lives | ~waits, "use")
        return m


class OneLocation(wiring.Component):
    """An I-structure of which only one location is real.

    ``location`` stays, ``noise`` and ``moods`` may be anything.
    """

    def __init__(self, *, depth, version_bits, access=None, to=None):
        self._rows = []

        def make_row(**options):
            self._rows.append(Row(**options))
            return self._rows[-1]

        self._store = AbstractStore(1, depth=1, tag=1)
        real = with_parts(IStructure, DeferredStore=lambda *_, **__: self._store, Memory=make_row)

        class Blind(real):
            """An access does not notice what another one does to its location."""

            def _meet(self, one, other):
                names = one.as_value().name, other.as_value().name
                return Const(0) if names == (access, to) else super()._meet(one, other)

        self._dut = Blind(1, depth=depth, version_bits=version_bits, deferred=1, tag=1)
        super().__init__({**dict(self._dut.signature.members.items()), "location": In(range(depth)),
                          "noise": In(4 * version_bits + 5), "moods": In(5)})

    def elaborate(self, platform):
        m = Module()
        # Its rows exist when it has been elaborated.
        m.submodules.dut = Fragment.get(self._dut, platform)
        connect_ports(m, self, self._dut)
        values, _, chains = self._rows
        for row in self._rows:
            m.d.comb += row.location.eq(self.location)
        store, noise = self._store, Cat(row.noise for row in self._rows)
        assert len(noise) == len(self.noise)
        m.d.comb += [noise.eq(self.noise), store.moods.eq(self.moods)]
        takes = transfers(store.i)
        m.d.comb += [store.adds.eq(chains.written & takes), store.frees.eq(values.written & store.i_release.valid)]

        # What waits before the write is released by it, and nothing waits after it.
        done = Signal()
        with m.If(values.written & (values.version != 0)):
            m.d.sync += done.eq(1)
            m.d.comb += [Assert(~done, "written once"), Assert(store.frees == store.lives, "released")]
        with m.If(transfers(self.i_start)):
            m.d.sync += done.eq(0)
        m.d.comb += Assert(~(store.adds & done), "late")
        return m


def make_location(depth=2, version_bits=1, **given):
    return Bench(written_once, OneLocation(depth=depth, version_bits=version_bits, **given), depth=depth)


def make(depth=2, deferred=2):
    return Bench(written_once, IStructure(1, depth=depth, version_bits=1, deferred=deferred, tag=1), depth=depth,
                 deferred=deferred)


# Accesses that do not notice another one, by the assertion that fails; of late and released one in a commit's tests.
FIRST = {("read_3", "write_3"): "late", ("write_3", "read_4"): "released"}
PAIRS = FIRST | {
    ("read_2", "write_4"): "late", ("write_1", "write_4"): "released", ("read_4", "write_3"): "use",
    ("read_1", "write_4"): "late", ("read_3", "write_4"): "late",
    **{(f"read_{stage}", "read_4"): "chain" for stage in (1, 2, 3)}, ("write_1", "read_4"): "chain",
    ("write_2", "read_4"): "released", ("write_2", "write_4"): "refusal", ("write_3", "write_4"): "refusal"}

test_one_location = declare(
    make_location, cycles=16, engine="abc bmc3", covers_nightly=True,
    # A sweep takes a cycle for each location; with one bit each start waits for one.
    claims=[Claim(depth=4, version_bits=2), *(
        Claim(depth=depth, version_bits=bits, unbounded=True, nightly=True, **given)
        for depth, bits, given in ((2, 1, {}), (4, 1, {"cycles": 20}), (2, 2, {})))],
    controls={f"{access} does not notice {to}": Control(breaks, access=access, to=to, nightly=(access, to) not in FIRST)
              for (access, to), breaks in PAIRS.items()})
test_with_the_store = declare(
    make, cycles=16, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(), Claim(depth=4, deferred=4, cycles=19)],
    controls={
        "answers before the write": Control(
            "early", {"o_read__valid": lambda dut: dut.o_read.valid | (dut.waiting == 2)}),
        "answers twice": Control("once", {"o_read__valid": lambda dut: dut.o_read.valid | dut.o_refused.valid}),
        "loses an answer": Control("capacity", {"i_read__ready": lambda dut: dut.i_read.ready | (dut.waiting == 2)}),
        "gives other data": Control(
            "data", {"o_read__payload": lambda dut: dut.o_read.payload.as_value() ^ ((dut.waiting == 2) << 1)}),
        "writes twice": Control("refusal", {"o_refused__valid": lambda dut: dut.o_refused.valid & (dut.waiting == 0)}),
        "stops writes when full": Control(
            "write", {"i_write__ready": lambda dut: dut.i_write.ready & (dut.waiting != 2)}),
        "begins while reads wait": Control("start", {
            "i_start__ready": lambda dut: dut.i_start.ready | (dut.waiting == 1)}),
    })

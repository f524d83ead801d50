"""Ray memory of cell traversal: what becomes of any request, whatever comes, leaves and returns meanwhile."""

from amaranth.hdl import Assert, Assume, Cover, ResetSignal, Signal

from hw.ctu.ray_memory import RayMemory
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import source_fault
from tb.formal.stream_rules import add_rules


def first_come_first_served(m, bench, dut, slots, deferred):
    """The requests for any one slot; of them any one, and any later one: their tags are 1 and 2, others 0.

    A frustum begins when no request is inside and no ray is absent; a ray returns after it has left. Of one slot what
    leaves is accepted at once, and no reset comes between.

    Asserts, by name:

    ``alone``
        A ray leaves only while no other one of its slot is absent.
    ``again``
        It has another version than the last one of its slot that left in this frustum.
    ``once``
        A request leaves or is dropped at most once, with its slot and its version; no other one does.
    ``order``
        Requests for a slot leave in their order.
    ``dropped``
        A request is dropped only if the last ray of its slot, or the next one that leaves, is the ray it requests.
    ``count``
        No more requests are deferred than there are inside, nor than may be.
    """
    slot = bench.choose(m, range(slots), "slot")
    for port, check in ((dut.i_start, Assume), (dut.i, Assume), (dut.o, Assert)):
        add_rules(m, port, check)
    request, left, back = dut.i.payload, dut.o.payload, dut.i_return
    starts, asks, leaves = (transfers(port) for port in (dut.i_start, dut.i, dut.o))
    passes, passed = dut.o_passed.valid, dut.o_passed.payload

    absent, inside, begun = Signal(slots), Signal(range(deferred + 32)), Signal()
    with m.If(leaves):
        m.d.sync += absent.bit_select(left.slot, 1).eq(1)
    with m.If(back.valid):
        m.d.sync += absent.bit_select(back.payload, 1).eq(0)
    m.d.sync += [inside.eq(inside + asks - leaves - passes), begun.eq(begun | starts)]
    m.d.comb += [
        *(Assume(one < slots) for one in (slot, request.slot, back.payload)), Assume(request.version != 0),
        Assume(~back.valid | absent.bit_select(back.payload, 1)),
        Assume(~dut.i_start.valid | ((inside == 0) & ~absent.any()))]

    here, last = dut.o.valid & (left.slot == slot), Signal.like(left.version)
    with m.If(leaves & here):
        m.d.sync += last.eq(left.version)
    with m.If(starts):
        m.d.sync += last.eq(0)
    m.d.comb += [Assert(~here | ~absent.bit_select(slot, 1), "alone"), Assert(~here | (left.version != last), "again"),
                 Assert((inside >= dut.waiting) & (dut.waiting <= deferred), "count")]

    mine, later = asks & request.tag[0], asks & request.tag[1]
    out, second, version, other = Signal(), Signal(), Signal.like(last), Signal.like(last)
    m.d.comb += [Assume(~mine | ~(out | second)), Assume(~later | (out & ~second)), Assume(request.tag != 3),
                 Assume(~(mine | later) | (request.slot == slot))]
    gone, gone_later = ((leaves & left.tag[bit]) | (passes & passed[bit]) for bit in range(2))
    m.d.sync += [out.eq((out | mine) & ~gone), second.eq((second | later) & ~gone_later)]
    with m.If(mine):
        m.d.sync += version.eq(request.version)
    with m.If(later):
        m.d.sync += other.eq(request.version)
    for bit, (there, of) in enumerate(((out, version), (second, other))):
        right = there & (left.slot == slot) & (left.version == of)
        m.d.comb += [Assert(~(dut.o.valid & left.tag[bit]) | right, "once"),
                     Assert(~(passes & passed[bit]) | there, "once"),
                     Assert(~(dut.o.valid & left.tag[bit] & passes & passed[bit]), "once")]
    m.d.comb += [Assert((inside != 0) | ~(dut.o.valid | passes), "once"),
                 Assert(~(dut.o.valid & left.tag[1] & out), "order")]

    # What has been decided earlier leaves before what is decided later.
    drops, promised, ray = passes & passed[0], Signal(), Signal.like(last)
    with m.If(drops & (last != version)):
        m.d.sync += [promised.eq(1), ray.eq(version)]
    with m.If((leaves & here) | starts):
        m.d.sync += promised.eq(0)
    with m.If(drops & leaves & here):
        m.d.sync += promised.eq(0)
        m.d.comb += Assert((left.version == version) | (last == version), "dropped")
    m.d.comb += [Assert(~(promised & here) | (left.version == ray), "dropped"),
                 Assert(~(promised & starts), "dropped"), Assert(~drops | (inside != 1) | (last == version), "dropped")]

    # What occurs while the request is inside.
    waited, frusta = Signal(), Signal(2)
    m.d.sync += [waited.eq(out & (waited | ((dut.waiting != 0) & (inside == dut.waiting)))),
                 frusta.eq(frusta + (starts & (frusta != 3)))]
    m.d.comb += [Cover(out & second & (dut.waiting == 2), "two requests are deferred"),
                 Cover(drops & (last == version), "a request is dropped")]
    if slots == 1:
        # Otherwise a proof does not reach what leaves after it was deferred.
        after_reset = Signal(init=1)
        m.d.sync += after_reset.eq(0)
        m.d.comb += [Assume(dut.o.ready), Assume(after_reset | ~ResetSignal()),
                     Cover(leaves & left.tag[0] & waited, "a deferred request leaves"),
                     Cover(leaves & left.tag[0] & (frusta == 2), "a ray leaves in the second frustum")]


def make(kind=RayMemory, slots=2, deferred=2):
    component = kind(slots=slots, version_bits=2, deferred=deferred, generation_bits=1, tag=2)
    return Bench(first_come_first_served, component, slots=slots, deferred=deferred)


def fault(breaks, right, wrong, *, nightly=False, **options):
    return Control(breaks, kind=source_fault(RayMemory, right, wrong), nightly=nightly, **options)


# A deferred request leaves in cycle 31 at the earliest.
test_grid_ray_memory = declare(
    make, cycles=20, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(), Claim(only="order", cycles=22), Claim(slots=1, cycles=33, nightly=True)],
    controls={
        "a ray leaves while another one of its slot is absent": fault(
            "alone", '(access.kind == _Kind.REQUEST) & ~state["away"])', "access.kind == _Kind.REQUEST)",
            nightly=True),
        "a ray leaves twice": fault(
            "again", 'other, served = access.version != state["version"],', 'other, served = access.version != 0,',
            nightly=True),
        "what leaves is dropped too": fault(
            "once", "self.o_passed.valid.eq(resolved & ~leaves)", "self.o_passed.valid.eq(resolved)", nightly=True),
        "a request overtakes those that are deferred": fault(
            "order", '"away": leaves | Mux(returns | ends, held, state["away"])',
            '"away": leaves | (~(returns | ends) & state["away"])'),
        "a request is dropped instead of deferred": fault(
            "dropped", 'retries, ~served, (access.kind == _Kind.REQUEST) & other & state["away"])',
            "retries, ~served, 0)"),
        "a request that leaves counts as deferred": fault(
            "count", "self.waiting, up=requested & defers", "self.waiting, up=requested", nightly=True),
        "a version outlives its frustum": fault(
            "dropped", '"version": Mux(now, old.version, 0)', '"version": old.version', nightly=True, slots=1),
    })

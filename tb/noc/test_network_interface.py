"""The interface alone, against golden's packets; what is corrupted on the way is reported."""

import random
from functools import partial

import pytest

from golden.engine.config import PRESETS
from golden.engine.noc.packing import reply_flits, request_flits
from golden.engine.noc.routing import route
from hw.noc.network_fault import NetworkFault
from hw.noc.network_interface import NetworkInterface
from tb.lib.simulator import simulator_of

NODE = 1
VARIANTS = [{"noc.flit_bits": 72, "noc.check": "parity", "noc.networks": "physical", "noc.virtual_channels": 1},
            {"noc.flit_bits": 32, "noc.check": "crc", "noc.networks": "virtual", "noc.virtual_channels": 2},
            {"noc.flit_bits": 20, "noc.check": "none", "noc.networks": "physical", "noc.virtual_channels": 2}]


class InterfaceBench:
    """An interface whose router takes all flits and returns their credits, at any time if it is slow."""

    def __init__(self, changes, seed=1, requests=3):
        self.config = PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1, "noc.buffer_flits": 4,
                                               "noc.requests": requests, **changes})
        self.routing = route(self.config.noc.network(), self.config.noc.virtual_channels)
        self.dut = NetworkInterface(config=self.config, routing=self.routing, node=NODE)
        self.random = random.Random(seed)
        self.sent = {0: [], 1: []}
        self.received, self.answered, self.times = [], [], {}
        self.fault = None

    @property
    def virtual(self):
        return self.config.noc.networks == "virtual"

    def run(self, cycles, *, requests=(), replies=(), flits=((), ()), slow=False, most=1 << 20):
        """``flits``: of requests and of replies that the network brings; ``most`` vertices of replies are accepted."""
        dut, simulator = self.dut, simulator_of(self.dut)
        channels = self.config.noc.virtual_channels

        async def give(ctx, stream, items):
            for item in items:
                ctx.set(stream.payload, item)
                ctx.set(stream.valid, 1)
                # Not `until`: it cannot be left unfinished, and the run may end first.
                taken = False
                while not taken:
                    _, _, taken = await ctx.tick().sample(stream.ready)
                ctx.set(stream.valid, 0)
                if slow:
                    await ctx.tick().repeat(self.random.choice((1, 1, 3)))

        async def take(ctx, stream, items, read):
            while True:
                ctx.set(stream.ready, (not slow or self.random.random() < 0.3) and len(items) < most)
                _, _, valid, payload, ready = await ctx.tick().sample(stream.valid, stream.payload, stream.ready)
                if valid and ready:
                    items.append(read(payload))

        async def router(ctx, link):
            """Takes flits, of each channel at most as many as its queue holds; brings flits while there are credits."""
            kinds = (0, 1) if self.virtual else (link,)
            credits = dict.fromkeys(kinds, self.config.noc.buffer_flits)
            waiting = {kind: list(flits[kind]) for kind in kinds}
            held = [0] * len(dut.i_credit[link])
            while True:
                able = [kind for kind in kinds if waiting[kind] and credits[kind]]
                ctx.set(dut.i[link].valid, bool(able))
                if able:
                    kind = self.random.choice(able)
                    credits[kind] -= 1
                    data, first, last = waiting[kind].pop(0)
                    ctx.set(dut.i[link].payload, {"flit": {"data": data, "first": first, "last": last},
                                                  "channel": kind * channels if self.virtual else 0})
                _, _, valid, payload, credit = await ctx.tick().sample(
                    dut.o[link].valid, dut.o[link].payload, dut.o_credit[link])
                if valid:
                    held[payload.channel] += 1
                    assert held[payload.channel] <= self.config.noc.buffer_flits, "a flit is sent without a credit"
                returned = [some > 0 and (not slow or self.random.random() < 0.2) for some in held]
                held = [some - back for some, back in zip(held, returned, strict=True)]
                ctx.set(dut.i_credit[link], sum(back << channel for channel, back in enumerate(returned)))
                if valid:
                    kind = payload.channel // channels if self.virtual else link
                    self.sent[kind].append(((payload.flit.data, bool(payload.flit.first), bool(payload.flit.last)),
                                            payload.channel % channels))
                for kind in kinds:
                    credits[kind] += credit >> (kind * channels if self.virtual else 0) & 1

        async def end(ctx):
            await ctx.tick().repeat(cycles)
            self.fault = ctx.get(dut.fault)

        for bench in (partial(give, stream=dut.i_request, items=requests),
                      partial(give, stream=dut.i_reply, items=replies),
                      partial(take, stream=dut.o_request, items=self.received,
                              read=lambda item: (item.node, item.patch)),
                      partial(take, stream=dut.o_reply, items=self.answered,
                              read=lambda item: (item.patch, item.surface, tuple(item.vertex))),
                      *(partial(router, link=number) for number in range(len(dut.i)))):
            simulator.add_testbench(bench, background=True)
        simulator.add_testbench(end)
        simulator.run()
        return self


def patches(config, generator, count):
    scene = config.numbers.scene
    return [(generator.randrange(4), generator.randrange(1 << config.icu.patch_bits), generator.randrange(-9, 1 << 20),
             [tuple(generator.randrange(scene.high + 1) for _ in range(3)) for _ in range(4)]) for _ in range(count)]


def replies_of(config, given, **more):
    """Their flits at this node."""
    return [flit for node, patch, surface, vertices in given for flit in reply_flits(
        config, **{"source": node, "destination": NODE, **more}, patch=patch, surface=surface, vertices=vertices)]


def answers(given):
    return [(patch, surface, vertex) for _, patch, surface, vertices in given for vertex in vertices]


@pytest.mark.parametrize("slow", [False, True])
@pytest.mark.parametrize("changes", VARIANTS)
def test_packets_are_those_of_golden(changes, slow):
    bench = InterfaceBench(changes, requests=64)
    config, pairs = bench.config, [(2, 5), (0, 4095), (3, 0), (1, 77)]
    given = patches(config, bench.random, 3)
    come = patches(config, bench.random, 3)
    bench.run(
        400 if slow else 120, slow=slow, requests=[{"node": node, "patch": patch} for node, patch in pairs],
        replies=[{"node": node, "vertex": {"patch": patch, "surface": surface, "vertex": list(vertex)}}
                 for node, patch, surface, vertices in given for vertex in vertices],
        flits=([flit for node, patch in pairs
                for flit in request_flits(config, source=node, destination=NODE, patch=patch)],
               replies_of(config, come)))
    entry = bench.routing.entry[NODE]
    assert bench.sent[0] == [(flit, entry[node]) for node, patch in pairs
                             for flit in request_flits(config, source=NODE, destination=node, patch=patch)]
    assert bench.sent[1] == [(flit, entry[one[0]]) for one in given
                             for flit in replies_of(config, [one], source=NODE, destination=one[0])]
    assert bench.received == pairs
    assert bench.answered == answers(come)
    assert bench.fault == NetworkFault.NONE


def test_no_more_requests_than_reply_buffers():
    bench = InterfaceBench(VARIANTS[0], requests=2)
    pairs = [{"node": 0, "patch": number} for number in range(6)]
    bench.run(60, requests=pairs)
    assert len(bench.sent[0]) == 2
    bench = InterfaceBench(VARIANTS[0], requests=2)
    come = patches(bench.config, bench.random, 3)
    bench.run(120, requests=pairs, flits=((), replies_of(bench.config, come)))
    assert len(bench.sent[0]) == 5


@pytest.mark.parametrize("most", [0, 1, 3, 4, 7, 8])
def test_a_credit_returns_when_a_whole_reply_has_left(most):
    """A cluster that accepts the first vertices of a patch still needs its buffer."""
    bench = InterfaceBench(VARIANTS[0], requests=2)
    come = patches(bench.config, bench.random, 2)
    bench.run(80, requests=[{"node": 0, "patch": number} for number in range(6)], most=most,
              flits=((), replies_of(bench.config, come)))
    assert (len(bench.answered), len(bench.sent[0])) == (most, 2 + most // 4)


def broken(flits, how, config):
    """A packet with a fault."""
    (data, first, last), *rest = flits
    if how == "bit":
        return [(data ^ 1 << config.noc.flit_bits - 1, first, last), *rest]
    if how == "check":
        return [(data ^ 1 << config.noc.flit_bits, first, last), *rest]
    if how == "short":
        return rest
    return flits


@pytest.mark.parametrize(("how", "fault"), [("bit", NetworkFault.CHECK), ("check", NetworkFault.CHECK),
                                            ("short", NetworkFault.ORDER), ("address", NetworkFault.ADDRESS)])
@pytest.mark.parametrize("changes", VARIANTS[:2])
def test_faults_are_reported_and_block_nothing(changes, how, fault):
    bench = InterfaceBench(changes, requests=64)
    config = bench.config
    first, second = patches(config, bench.random, 2)
    wrong = broken(replies_of(config, [first], destination=NODE + 1 if how == "address" else NODE), how, config)
    bench.run(120, requests=[{"node": node, "patch": patch} for node, patch, *_ in (first, second)],
              flits=((), [*wrong, *replies_of(config, [second])]))
    assert bench.fault == fault
    # The packet after it comes as it is.
    assert bench.answered[-4:] == answers([second])


@pytest.mark.parametrize(("how", "fault"), [("bit", NetworkFault.CHECK), ("address", NetworkFault.ADDRESS)])
def test_faults_of_requests_are_reported_and_block_nothing(how, fault):
    bench = InterfaceBench(VARIANTS[0], requests=64)
    destination = NODE + 1 if how == "address" else NODE
    wrong = broken(request_flits(bench.config, source=2, destination=destination, patch=5), how, bench.config)
    bench.run(60, flits=([*wrong, *request_flits(bench.config, source=3, destination=NODE, patch=77)], ()))
    assert bench.fault == fault
    assert bench.received[-1] == (3, 77)


def test_the_first_fault_since_reset_stays():
    """Whatever comes after it, in requests or in replies; of two at once that of the requests."""
    bench = InterfaceBench(VARIANTS[0])
    config = bench.config
    given = patches(config, bench.random, 1)
    (node, patch, *_), = given
    request, elsewhere = (request_flits(config, source=node, destination=goal, patch=patch)
                          for goal in (NODE, NODE + 1))
    reply = replies_of(config, given)
    wrong_request, wrong_reply = (broken(one, "bit", config) for one in (request, reply))
    for requests, replies, fault in (([*wrong_request, *elsewhere], [], NetworkFault.CHECK),
                                     ([*request, *request, *elsewhere], wrong_reply, NetworkFault.CHECK),
                                     (elsewhere, [*reply, *wrong_reply], NetworkFault.ADDRESS),
                                     (elsewhere, wrong_reply, NetworkFault.ADDRESS)):
        bench = InterfaceBench(VARIANTS[0])
        bench.run(30, requests=2 * [{"node": node, "patch": patch}], flits=(requests, replies))
        assert bench.fault == fault


def test_init_wrong():
    bench = InterfaceBench(VARIANTS[0])
    with pytest.raises(ValueError, match="Node must be from 0 to 3, not 4"):
        NetworkInterface(config=bench.config, routing=bench.routing, node=4)

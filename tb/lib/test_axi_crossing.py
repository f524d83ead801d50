"""All channels of AXI4 and AXI4-Lite between two clocks."""

import random

import pytest
from amaranth.hdl import ClockDomain, Module

from golden.engine.config import PRESETS
from hw.lib.axi_crossing import AxiCrossing
from hw.memsys.port.axi_signature import AxiSignature
from hw.registers.axi_lite_signature import AxiLiteSignature
from tb.lib.seed import SEED
from tb.lib.simulator import simulator_of
from tb.lib.stall_patterns import STALLS

SIGNATURES = {"axi4": AxiSignature(config=PRESETS["tiny"]), "axi4-lite": AxiLiteSignature(address_bits=12)}
# Of each channel, whether it comes from the manager.
CHANNELS = {"aw": True, "w": True, "ar": True, "b": False, "r": False}
FIELDS = ("id", "addr", "len", "size", "burst", "cache", "prot", "data", "strb", "last", "resp")
COUNT = 25
WATCHDOG = 5000


def fields_of(signature, channel):
    """Names and widths, by the standard's prefixes."""
    known = {f"{channel}{field}" for field in FIELDS}
    return {name: member.shape for name, member in signature.members.items() if name in known}


@pytest.mark.parametrize("periods", [
    (7, 11), *(pytest.param(one, marks=pytest.mark.sim) for one in ((10, 10), (10, 3), (3, 10)))])
@pytest.mark.parametrize("name", SIGNATURES)
def test_every_channel_carries_its_fields_in_order(name, periods):
    signature, draw = SIGNATURES[name], random.Random(f"{name} {periods} {SEED}")
    dut = AxiCrossing(signature, manager="manager", subordinate="subordinate")
    m = Module()
    m.submodules.dut = dut
    m.domains += [ClockDomain("manager"), ClockDomain("subordinate")]
    simulator = simulator_of(m, period=None)
    for domain, period in zip(("manager", "subordinate"), periods, strict=True):
        simulator.add_clock(period * 1e-9, phase=draw.random() * period * 1e-9, domain=domain)
    items = {channel: [{field: draw.getrandbits(width) for field, width in fields_of(signature, channel).items()}
                       for _ in range(COUNT)] for channel in CHANNELS}
    came = {channel: [] for channel in CHANNELS}

    def end(channel, sends):
        is_manager = CHANNELS[channel] == sends
        return (dut.i, "manager") if is_manager else (dut.o, "subordinate")

    def sender(channel, pattern):
        port, domain = end(channel, True)
        valid, ready = getattr(port, f"{channel}valid"), getattr(port, f"{channel}ready")

        async def send(ctx):
            for item in items[channel]:
                while next(pattern):
                    await ctx.tick(domain)
                for field, value in item.items():
                    ctx.set(getattr(port, field), value)
                ctx.set(valid, 1)
                await ctx.tick(domain).until(ready)
                ctx.set(valid, 0)
            for _ in range(WATCHDOG):
                if len(came[channel]) == COUNT:
                    return
                await ctx.tick(domain)
            raise AssertionError(f"{channel}: {len(came[channel])} of {COUNT} items came")
        return send

    def receiver(channel, pattern):
        port, domain = end(channel, False)
        names = fields_of(signature, channel)
        pins = [getattr(port, f"{channel}{name}") for name in ("valid", "ready")] + [getattr(port, name)
                                                                                  for name in names]

        async def receive(ctx):
            while True:
                ctx.set(pins[1], not next(pattern))
                _, _, valid, ready, *values = await ctx.tick(domain).sample(*pins)
                if valid and ready:
                    came[channel].append(dict(zip(names, values, strict=True)))
        return receive

    for number, channel in enumerate(CHANNELS):
        assert set(items[channel][0]) or channel == "b"
        stalls = draw.sample(["none", "random", "bursts", "alternating"], 2)
        simulator.add_testbench(sender(channel, STALLS[stalls[0]](SEED + number)))
        simulator.add_testbench(receiver(channel, STALLS[stalls[1]](SEED + 9 * number)), background=True)
    simulator.run()
    assert came == items


@pytest.mark.parametrize("name", SIGNATURES)
def test_all_members_belong_to_a_channel(name):
    fields = {field for channel in CHANNELS for field in fields_of(SIGNATURES[name], channel)}
    handshakes = {f"{channel}{pin}" for channel in CHANNELS for pin in ("valid", "ready")}
    assert fields | handshakes == SIGNATURES[name].members.keys()

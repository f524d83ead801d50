"""Waveforms of the pages on units: short simulations with golden's stimuli, or with a few items that show a rule."""

from collections.abc import Callable
from dataclasses import dataclass

from amaranth.hdl import Cat

from golden.engine.config import PRESETS
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from hw.board.uart_transmitter import UartTransmitter
from hw.ctu.cell_traversal import CellTraversal
from hw.icu.screening import Screening
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.patches.filter import Filter
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.noc.router import Router
from hw.registers.engine_registers import ADDRESS_BITS, ENGINE_REGISTERS
from hw.registers.register import addresses
from hw.registers.registers import Registers
from tb.ctu.cell_rays import long_rays
from tb.docs.timing_diagram import Lane, draw_lanes, give, record, stream_lanes
from tb.icu import test_screening

__all__ = ["WAVEFORMS", "Waveform"]

CONFIG = PRESETS["tiny"]


@dataclass(frozen=True)
class Waveform:
    """What is shown, and how it is drawn."""

    about: str
    draw: Callable[[], str]


def _screening():
    """Rays one after the other, with a gap."""
    component = Screening(config=CONFIG, tag=9)
    items = test_screening.TestScreening().vectors(CONFIG).inputs["i"][:10]
    given, result = component.i.payload, component.o.payload
    lanes = [*stream_lanes("i", component.i, lambda tag: f"{tag}", given.tag),
             *stream_lanes("o", component.o, lambda value: f"{value >> 1} {'in' if value & 1 else 'out'}",
                           Cat(result.inside, result.tag))]

    async def drive(ctx):
        for item in [*items[:4], None, *items[4:]]:
            ctx.set(component.i.valid, item is not None)
            if item is not None:
                ctx.set(component.i.payload, item)
            await ctx.tick()
        ctx.set(component.i.valid, 0)

    return draw_lanes(lanes, record(component, lanes, drive, cycles=len(items) + component.latency + 2))


def _cell_traversal():
    """Rays into the ring; cells out."""
    component, given = CellTraversal(config=CONFIG, tag=12), long_rays(CONFIG)
    met = component.o.payload
    lanes = [*stream_lanes("i", component.i, str, component.i.payload.tag),
             *stream_lanes("o", component.o, lambda value: f"{value >> 1}{' end' if value & 1 else ''}",
                           Cat(met.last, met.tag))]

    async def drive(ctx):
        ctx.set(component.o.ready, 1)
        for name, value in given.ports.items():
            ctx.set(getattr(component, name), value)
        await give(ctx, component.i, given.inputs["i"][:6])

    latency = component.latency
    rows = record(component, lanes, drive, cycles=latency + 60)
    begin = next(cycle for cycle, (valid, _) in enumerate(rows[3]) if valid)
    return draw_lanes(lanes, rows, ranges=[range(6), range(begin - 2, begin + 18)])


def _filter():
    """Numbers, of which some have passed before."""
    component = Filter(bits=8, count=256, generation_bits=4)
    lanes = [*stream_lanes("i_start", component.i_start, str)[:2], *stream_lanes("i", component.i, str),
             *stream_lanes("o", component.o, str), Lane("dropped", component.dropped)]

    async def drive(ctx):
        ctx.set(component.o.ready, 1)
        ctx.set(component.limit, 200)
        ctx.set(component.i_start.valid, 1)
        await ctx.tick().until(component.i_start.ready)
        ctx.set(component.i_start.valid, 0)
        await give(ctx, component.i, [5, 7, 5, 9, 7, 12])

    rows = record(component, lanes, drive, cycles=60)
    # After the reset's sweep.
    begin = next(cycle for cycle in range(60) if rows[0][cycle][0] and rows[1][cycle][0])
    return draw_lanes(lanes, rows, ranges=[range(begin - 1, begin + 17)])


def _cache():
    """A miss, a hit on what is still being fetched, and a hit."""
    component = Cache(16, beats=2, config=CONFIG, lines=16, key=8, tag=4)
    lanes = [*stream_lanes("i", component.i, lambda key: f"key {key}", component.i.payload.key),
             *stream_lanes("o_fetch", component.o_fetch, lambda key: f"key {key}", component.o_fetch.payload.key),
             *stream_lanes("i_fill", component.i_fill, lambda beat: f"beat {beat}", component.i_fill.payload.beat),
             *stream_lanes("o", component.o, lambda hit: "hit" if hit else "miss", component.o.payload.hit)]

    async def drive(ctx):
        ctx.set(component.o.ready, 1)
        ctx.set(component.i_invalidate.payload, CachePolicy.DIRECT)
        ctx.set(component.i_invalidate.valid, 1)
        await ctx.tick().until(component.i_invalidate.ready)
        ctx.set(component.i_invalidate.valid, 0)
        keys = [3, 3, None, None, None, None, None, None, None, None, None, None, None, 3]
        await give(ctx, component.i, [None if key is None else {"tag": 0, "key": key} for key in keys])

    async def memory(ctx):
        ctx.set(component.o_fetch.ready, 1)
        *_, slot = await ctx.tick().sample(component.o_fetch.payload.slot).until(component.o_fetch.valid)
        await ctx.tick().repeat(4)
        for beat in range(2):
            ctx.set(component.i_fill.payload, {"slot": slot, "beat": beat, "data": 7 + beat, "error": 0})
            ctx.set(component.i_fill.valid, 1)
            await ctx.tick()
        ctx.set(component.i_fill.valid, 0)

    rows = record(component, lanes, drive, memory, cycles=120)
    begin = next(cycle for cycle, (valid, _) in enumerate(rows[0]) if valid)
    return draw_lanes(lanes, rows, ranges=[range(begin - 1, begin + 28)])


def _main_memory_port():
    """A read of four beats, from memory that answers after six cycles."""
    component = MainMemoryPort(config=CONFIG, tag=2)
    axi = component.axi
    lanes = [*stream_lanes("i_read", component.i_read, hex, component.i_read.payload.address),
             Lane("arvalid", axi.arvalid), Lane("arready", axi.arready), Lane("araddr", axi.araddr, axi.arvalid, hex),
             Lane("arlen", axi.arlen, axi.arvalid, str), Lane("rvalid", axi.rvalid), Lane("rready", axi.rready),
             Lane("rdata", axi.rdata, axi.rvalid, hex), Lane("rlast", axi.rlast),
             *stream_lanes("o_read", component.o_read, hex, component.o_read.payload.data)]

    async def drive(ctx):
        ctx.set(component.o_read.ready, 1)
        ctx.set(component.read_window, {"base": 0, "limit": 0x10000})
        await ctx.tick().repeat(2)
        await give(ctx, component.i_read, [{"address": 0x240, "length": 3, "tag": 1}])

    async def memory(ctx):
        ctx.set(axi.arready, 1)
        *_, slot, length = await ctx.tick().sample(axi.arid, axi.arlen).until(axi.arvalid)
        await ctx.tick().repeat(5)
        for beat in range(length + 1):
            ctx.set(axi.rid, slot)
            ctx.set(axi.rdata, 0xA0 + beat)
            ctx.set(axi.rlast, beat == length)
            ctx.set(axi.rvalid, 1)
            await ctx.tick().until(axi.rready)
        ctx.set(axi.rvalid, 0)

    return draw_lanes(lanes, record(component, lanes, drive, memory, cycles=28))


def _router():
    """A packet of three flits from the node itself to the one east of it, and a returned credit."""
    routing = route(Topology("mesh", 2, 1), 1)
    component = Router(routing=routing, node=0, bits=8, depth=8)
    east = routing.topology.ports.index("east")
    given, sent = component.i[0], component.o[east]

    def flit(value):
        return ("head " if value & 1 else "") + f"{value >> 2:#x}" + (" tail" if value & 2 else "")

    def lane(name, link):
        return stream_lanes(name, link, flit, Cat(link.payload.flit.first, link.payload.flit.last,
                                                  link.payload.flit.data))

    lanes = [*lane("i[local]", given), *lane("o[east]", sent), Lane("o_credit[local]", component.o_credit[0])]

    async def drive(ctx):
        await ctx.tick()
        for number, data in enumerate((0x01, 0x2B, 0x3C)):
            ctx.set(given.payload, {"flit": {"data": data, "first": number == 0, "last": number == 2}, "channel": 0})
            ctx.set(given.valid, 1)
            await ctx.tick()
        ctx.set(given.valid, 0)

    return draw_lanes(lanes, record(component, lanes, drive, cycles=10))


def _registers():
    """The host writes the watchdog and reads it again."""
    component = Registers(ENGINE_REGISTERS, address_bits=ADDRESS_BITS)
    host, address = component.host, addresses(ENGINE_REGISTERS)["watchdog"]
    lanes = [Lane(name, getattr(host, name)) for name in ("awvalid", "awready")]
    lanes += [Lane("awaddr", host.awaddr, host.awvalid, hex), Lane("wvalid", host.wvalid), Lane("wready", host.wready),
              Lane("wdata", host.wdata, host.wvalid, hex), Lane("bvalid", host.bvalid), Lane("bready", host.bready),
              Lane("arvalid", host.arvalid), Lane("arready", host.arready),
              Lane("araddr", host.araddr, host.arvalid, hex), Lane("rvalid", host.rvalid),
              Lane("rready", host.rready), Lane("rdata", host.rdata, host.rvalid, hex)]

    async def drive(ctx):
        ctx.set(host.bready, 1)
        ctx.set(host.rready, 1)
        await ctx.tick()
        for name, value in (("awaddr", address), ("awvalid", 1), ("wdata", 0x1000), ("wstrb", 15), ("wvalid", 1)):
            ctx.set(getattr(host, name), value)
        is_addressed = is_given = False
        while not (is_addressed and is_given):
            *_, addressed, given = await ctx.tick().sample(host.awvalid & host.awready, host.wvalid & host.wready)
            is_addressed, is_given = is_addressed or addressed, is_given or given
            ctx.set(host.awvalid, not is_addressed)
            ctx.set(host.wvalid, not is_given)
        await ctx.tick().until(host.bvalid)
        ctx.set(host.araddr, address)
        ctx.set(host.arvalid, 1)
        await ctx.tick().until(host.arready)
        ctx.set(host.arvalid, 0)

    return draw_lanes(lanes, record(component, lanes, drive, cycles=14))


def _uart():
    """Two bytes, of two cycles per bit."""
    component = UartTransmitter(divisor=2)
    lanes = [*stream_lanes("i", component.i, hex), Lane("tx", component.tx)]

    async def drive(ctx):
        await ctx.tick()
        await give(ctx, component.i, [0x4B, 0x31])

    return draw_lanes(lanes, record(component, lanes, drive, cycles=46))


# By pages of docs/.
WAVEFORMS = {
    "engine.md": Waveform("The host writes a register and reads it again (`Registers`, AXI4-Lite)", _registers),
    "intersection-unit.md": Waveform("Rays that are screened (`Screening`), one per cycle; by number, and whether they "
                                     "are inside their patch", _screening),
    "traversal-unit.md": Waveform("Six rays walk through a grid (`CellTraversal`, one pipeline): a cell per cycle, ray "
                                  "by number", _cell_traversal),
    "memory-path.md": Waveform("Numbers of cells at the filter (`Filter`): 5 and 7 come twice and pass once", _filter),
    "caches.md": Waveform("A miss, a hit on what is still being fetched, and a hit (`Cache`, direct mapped)", _cache),
    "main-memory.md": Waveform("Four beats are read (`MainMemoryPort`)", _main_memory_port),
    "network.md": Waveform("A packet of three flits passes a router of two cycles (`Router`)", _router),
    "board.md": Waveform("Two bytes on the serial line, two cycles per bit (`UartTransmitter`)", _uart),
}

"""Timing diagrams: what a component's streams show in a short simulation, as WaveDrom draws it."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import wavedrom
from amaranth.hdl import Value
from amaranth.sim import Simulator

__all__ = ["Lane", "draw_lanes", "give", "record", "stream_lanes"]


@dataclass(frozen=True)
class Lane:
    """A row: a bit, or with ``text`` what a value is called where ``shown`` is true."""

    name: str
    value: Value
    shown: Value | None = None
    text: Callable[[int], str] | None = None


async def give(ctx, stream, items: Sequence) -> None:
    """Offer items; None is a cycle without one."""
    for item in items:
        if item is None:
            ctx.set(stream.valid, 0)
            await ctx.tick()
            continue
        ctx.set(stream.payload, item)
        ctx.set(stream.valid, 1)
        await ctx.tick().until(stream.ready)
    ctx.set(stream.valid, 0)


def stream_lanes(name: str, stream, text: Callable[[int], str], value: Value | None = None) -> list[Lane]:
    """Of a stream: its handshake, and ``text`` of ``value``, by default of its payload."""
    value = Value.cast(stream.payload if value is None else value)
    ready = [] if stream.signature.always_ready else [Lane(f"{name}.ready", stream.ready)]
    return [Lane(f"{name}.valid", stream.valid), *ready, Lane(f"{name}.payload", value, stream.valid, text)]


def record(component, lanes: Sequence[Lane], *drivers: Callable, cycles: int) -> list[list[tuple[int, int]]]:
    """Of each lane, cycle by cycle, its value and whether it means anything.

    ``drivers`` are coroutines as testbenches of Amaranth's simulator are.
    """
    seen = [[] for _ in lanes]
    values = [lane.value for lane in lanes]
    shown = [lane.value if lane.shown is None else lane.shown for lane in lanes]

    async def watch(ctx):
        for _ in range(cycles):
            _, _, *sampled = await ctx.tick().sample(*values, *shown)
            for row, value, means in zip(seen, sampled[:len(lanes)], sampled[len(lanes):], strict=True):
                row.append((int(value), int(means)))

    simulator = Simulator(component)
    simulator.add_clock(1e-8)
    simulator.add_testbench(watch)
    for driver in drivers:
        simulator.add_testbench(driver, background=True)
    simulator.run()
    return seen


def draw_lanes(lanes: Sequence[Lane], rows: Sequence[Sequence[tuple[int, int]]], *,
               ranges: Sequence[range] | None = None) -> str:
    """SVG of what `record` gives; of some ranges of cycles only, with a gap between them."""
    ranges = ranges or [range(len(rows[0]))]
    cycles = [cycle for part in ranges for cycle in (*part, None)][:-1]
    signals = [{"name": "cycle", "wave": "".join("|" if cycle is None else "2" for cycle in cycles),
                "data": [str(cycle) for cycle in cycles if cycle is not None]}]
    signals += [_signal(lane, row, cycles) for lane, row in zip(lanes, rows, strict=True)]
    return wavedrom.render(json.dumps({"signal": signals})).tostring()


def _signal(lane, row, cycles):
    """A row in WaveDrom's letters; a bit that stays is a point, behind a gap too."""
    wave, data, before = "", [], None
    for cycle in cycles:
        if cycle is None:
            wave += "|"
            continue
        value, means = row[cycle]
        if lane.text is None:
            wave += "." if value == before else str(value)
            before = value
        else:
            wave += "=" if means else "x"
            data += [lane.text(value)] if means else []
    return {"name": lane.name, "wave": wave, "data": data}

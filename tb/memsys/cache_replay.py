"""Replays strings of requests on a cache and compares every answer with golden's."""

import json
from pathlib import Path

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge

from golden.engine.config import Config
from golden.engine.memsys.bus.cache import Cache as GoldenCache
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.cache_policy import CachePolicy
from tb.lib.clocking import start
from tb.lib.runner import BUILD, options, simulate
from tb.lib.stream import Sink, Source

__all__ = ["DELAY", "KEY_BITS", "replay"]

KEY_BITS, DELAY = 16, 20


def replay(strings: dict[str, np.ndarray], policies: list[str], *, lines: int, simulator: str = "verilator") -> dict:
    """Hits and cycles of each string under each policy, by name and policy, after every answer was golden's.

    Raises
    ------
    AssertionError
        An answer is not.
    """
    folder = (BUILD / "vectors").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    given, came = folder / f"cache-replay-{lines}.json", folder / f"cache-replay-{lines}-came.json"
    given.write_text(json.dumps({name: string.tolist() for name, string in strings.items()}))
    came.unlink(missing_ok=True)
    cache = Cache(KEY_BITS, beats=1, config=Config(), lines=lines, key=KEY_BITS, tag=1)
    simulate(cache, __name__, ("strings_under_policies",), simulator=simulator,
             name=f"cache-replay-{lines}-{simulator}", given=str(given), came=str(came), policies=policies, lines=lines)
    return json.loads(came.read_text())


@cocotb.test()
async def strings_under_policies(dut):
    """All strings under all policies; the record of a key is the key."""
    strings = json.loads(Path(options()["given"]).read_text())
    policies, came = options()["policies"], {name: {} for name in strings}
    await start(dut, cycles=40 * len(policies) * sum(map(len, strings.values())) + 10_000)
    memory = cocotb.start_soon(_memory(dut))
    for name, keys in strings.items():
        for policy in policies:
            await Source(dut, "i_invalidate").send([CachePolicy[policy].value])
            golden = GoldenCache.of(Config().replace({"memsys.cache_policy": policy.lower()}).memsys,
                                    lines=options()["lines"])
            hit, line, _ = golden.access(keys)
            # The fields of an answer: tag, record, line, hit, error.
            line_bits = (options()["lines"] - 1).bit_length()
            expected = [key << 1 | (int(address) | int(held) << line_bits) << KEY_BITS + 1
                        for key, address, held in zip(keys, line, hit, strict=True)]
            sink = Sink(dut, "o")
            await Source(dut, "i").send([key << 1 for key in keys])
            while len(sink.items) < len(keys):
                await RisingEdge(dut.clk)
            for number, (got, required) in enumerate(zip(sink.items, expected, strict=True)):
                assert got == required, f"{name}, {policy}: answer {number} is {got:x}, not {required:x}"
            assert int(dut.misses.value) == golden.misses
            came[name][policy] = {"misses": golden.misses, "cycles": sink.cycles[-1] - sink.cycles[0] + 1}
            sink.stop()
    memory.cancel()
    Path(options()["came"]).write_text(json.dumps(came))


async def _memory(dut):
    """Answers each fetch after `DELAY` cycles."""
    edge, due, now = RisingEdge(dut.clk), [], 0
    dut.o_fetch__ready.value = 1
    dut.i_fill__valid.value = 0
    while True:
        await edge
        now += 1
        if int(dut.o_fetch__valid.value):
            due.append((now + DELAY, int(dut.o_fetch__payload.value)))
        if due and due[0][0] <= now:
            _, fetch = due.pop(0)
            # Slot and key are where slot and data are.
            dut.i_fill__payload.value = fetch
            dut.i_fill__valid.value = 1
        elif int(dut.i_fill__valid.value):
            dut.i_fill__valid.value = 0

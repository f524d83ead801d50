"""A main memory behind AXI4, cycle by cycle, with any latency and order of replies, with errors, or silent."""

import random
from collections import deque
from collections.abc import Callable

from golden.engine.config import Config
from tb.lib.stall_patterns import STALLS

__all__ = ["ERROR", "MemoryModel"]

# SLVERR.
ERROR = 2


class MemoryModel:
    """What a memory does with the pins of a manager. Knows nothing of a simulator.

    `tb.axi.axi_protocol.AxiProtocol` checks that the manager keeps the rules of AXI.

    Parameters
    ----------
    config
        The configuration.
    data
        What it holds from ``base`` on; writes change it.
    base
        Address of the first byte.
    latency
        Cycles from an address to the first beat or answer, at least 1.
    spread
        Up to so many more, by chance.
    shuffles
        Beats of different ids come in any order; else in the order of the addresses.
    stalls
        By channel, ``ar``, ``aw``, ``w``, ``r`` and ``b``: the name of one of `STALLS`.
    fails
        Of an address, whether it is answered with an error.

    Members
    -------
    silent
        Channels, see above, on which nothing moves now.
    reads, writes
        Bursts: first address, beats.
    outstanding_reads, busy
        The number of outstanding reads; whether anything is outstanding.
    faulty
        It has broken rules of AXI.
    """

    def __init__(self, config: Config, data: bytes, *, base: int = 0, latency: int = 1, spread: int = 0,
                 shuffles: bool = False, stalls: dict[str, str] | None = None,
                 fails: Callable[[int], bool] = lambda address: False, seed: int = 1):
        self.config, self._bytes, self.faulty = config, config.memory.beat_bytes, False
        self.data, self.base = bytearray(data), base
        self._latency, self._spread, self._shuffles, self._fails = latency, spread, shuffles, fails
        self._random = random.Random(seed)
        self._stalls = {channel: STALLS[(stalls or {}).get(channel, "none")](seed + k)
                        for k, channel in enumerate(("ar", "aw", "w", "r", "b"))}
        self.silent = set()
        self.reads, self.writes = [], []
        self._now = 0
        # Reads: when they are due; of each beat still to come id, data, response, last. Writes: when, id, response.
        self._due_reads, self._due_writes = [], deque()
        self._open = deque()
        self.out = {"arready": 0, "awready": 0, "wready": 0, "rvalid": 0, "rid": 0, "rdata": 0, "rresp": 0, "rlast": 0,
                    "bvalid": 0, "bid": 0, "bresp": 0}

    @property
    def outstanding_reads(self) -> int:
        """See above."""
        return len(self._due_reads)

    @property
    def busy(self) -> bool:
        """See above."""
        return bool(self._due_reads or self._due_writes or self._open or self.out["rvalid"] or self.out["bvalid"])

    def inject(self, **pins: int) -> None:
        """Give an unrequested beat or answer: ``rid`` and so on, or ``bid`` and so on."""
        self.faulty = True
        if "bid" in pins:
            self._due_writes.appendleft((0, pins["bid"], pins.get("bresp", 0)))
        else:
            beat = pins["rid"], pins.get("rdata", 0), pins.get("rresp", 0), pins.get("rlast", 1)
            self._due_reads.insert(0, (0, deque([beat])))

    def cut(self, beats: int) -> None:
        """The last read gets so many beats too few or (if negative) too many."""
        self.faulty = True
        _, left = self._due_reads[-1]
        for _ in range(-beats):
            *beat, _ = left.pop()
            left.extend([(*beat, 0), (*beat, 1)])
        for _ in range(beats):
            left.pop()
            *beat, _ = left.pop()
            left.append((*beat, 1))

    def step(self, pins: dict[str, int]) -> dict[str, int]:
        """From the manager's pins in a cycle to what the memory gives in the next one."""
        self._now += 1
        out = self.out
        if pins["arvalid"] and out["arready"]:
            self._read(pins)
        if pins["awvalid"] and out["awready"]:
            self._accept(pins)
        if pins["wvalid"] and out["wready"]:
            self._write(pins)
        for channel in "ar", "aw":
            out[f"{channel}ready"] = self._moves(channel)
        # Data may come before their address.
        out["wready"] = int(self._moves("w") and any(beats for *_, beats, _ in self._open))
        if not out["rvalid"] or pins["rready"]:
            out.update(self._next_beat())
        if not out["bvalid"] or pins["bready"]:
            due = self._due_writes and self._due_writes[0][0] <= self._now and self._moves("b")
            out["bvalid"] = int(bool(due))
            if due:
                _, out["bid"], out["bresp"] = self._due_writes.popleft()
        return out

    def _moves(self, channel):
        return int(not next(self._stalls[channel]) and channel not in self.silent)

    def _due(self):
        return self._now + self._latency - 1 + self._random.randint(0, self._spread)

    def _check_range(self, address, length):
        end = address + (length + 1) * self._bytes
        assert self.base <= address, f"{address:#x} is outside the memory"
        assert end <= self.base + len(self.data), f"{address:#x} is outside the memory"

    def _accept(self, pins):
        self._check_range(pins["awaddr"], pins["awlen"])
        self._open.append([pins["awid"], pins["awaddr"], pins["awlen"] + 1, 0])
        self.writes.append((pins["awaddr"], pins["awlen"] + 1))

    def _read(self, pins):
        first, beats = pins["araddr"], pins["arlen"] + 1
        self._check_range(first, beats - 1)
        self.reads.append((first, beats))
        left = deque()
        for k in range(beats):
            at = first + k * self._bytes
            word = self.data[at - self.base:at - self.base + self._bytes]
            failed = self._fails(at)
            left.append((pins["arid"], 0 if failed else int.from_bytes(word, "little"), ERROR if failed else 0,
                         int(k == beats - 1)))
        self._due_reads.append((self._due(), left))

    def _next_beat(self):
        due = [read for read in self._due_reads if read[0] <= self._now]
        # Before others: later its id may be that of a new burst.
        unrequested = [read for read in due if read[0] == 0]
        if unrequested:
            due = unrequested
        elif not self._shuffles:
            due = due[:1] if due and due[0] is self._due_reads[0] else []
        if not due or not self._moves("r"):
            return {"rvalid": 0}
        read = self._random.choice(due)
        _, left = read
        number, data, response, last = left.popleft()
        if not left:
            self._due_reads.remove(read)
        return {"rvalid": 1, "rid": number, "rdata": data, "rresp": response, "rlast": last}

    def _write(self, pins):
        burst = next(burst for burst in self._open if burst[2])
        at = burst[1] - self.base
        for k in range(self._bytes):
            if pins["wstrb"] >> k & 1:
                self.data[at + k] = pins["wdata"] >> 8 * k & 255
        burst[3] |= self._fails(burst[1])
        burst[1], burst[2] = burst[1] + self._bytes, burst[2] - 1
        if not burst[2]:
            self._open.remove(burst)
            self._answer(burst)

    def _answer(self, burst):
        due = max([self._due(), *(when for when, _, _ in self._due_writes)])
        self._due_writes.append((due, burst[0], ERROR if burst[3] else 0))

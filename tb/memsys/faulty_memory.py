"""A main memory that answers one burst wrongly."""

from dataclasses import dataclass

from golden.engine.config import Config
from hw.memsys.port.fault import Fault
from tb.memsys.memory_model import ERROR, MemoryModel

__all__ = ["READ_FAULTS", "WRITE_FAULTS", "BusFault", "FaultyMemory"]

DECERR = 3
# By name, what the memory does to a burst: the fault that the port reports first.
READ_FAULTS = {
    "slverr": Fault.READ_REPLY, "decerr": Fault.READ_REPLY, "late": Fault.READ_TIMEOUT, "silent": Fault.READ_TIMEOUT,
    "free id": Fault.READ_PROTOCOL, "id of another read": Fault.READ_PROTOCOL, "unexpected beat": Fault.READ_PROTOCOL,
    "last beat not marked": Fault.READ_PROTOCOL, "another beat marked": Fault.READ_PROTOCOL,
    "a beat again": Fault.READ_PROTOCOL, "last beat again": Fault.READ_PROTOCOL}
WRITE_FAULTS = {
    "write slverr": Fault.WRITE_REPLY, "write decerr": Fault.WRITE_REPLY, "write late": Fault.WRITE_TIMEOUT,
    "write silent": Fault.WRITE_TIMEOUT, "write wrong id": Fault.WRITE_PROTOCOL,
    "unexpected answer": Fault.WRITE_PROTOCOL, "answer before the data": Fault.WRITE_PROTOCOL,
    "answer again": Fault.WRITE_PROTOCOL}
# After these the burst never ends.
_LOST = ("silent", "last beat not marked", "write silent", "write wrong id", "answer before the data")


@dataclass(frozen=True, kw_only=True)
class BusFault:
    """One fault.

    Parameters
    ----------
    kind
        Of `READ_FAULTS` or `WRITE_FAULTS`.
    burst
        At least so many bursts of reads, or of writes, come before. Not every fault can be that of every burst.
    beat
        The beat, modulo the number of beats of the burst.
    error
        A beat that is unexpected, or not marked as the last one, is an error too: the kind's code comes before.
    """

    kind: str
    burst: int
    beat: int
    error: bool = False


class FaultyMemory(MemoryModel):
    """A `MemoryModel` with one fault at a time.

    Parameters
    ----------
    config, data, given
        See `MemoryModel`.

    Members
    -------
    struck
        The fault has occurred.
    lost
        Its burst will never end.
    """

    def __init__(self, config: Config, data: bytes, **given):
        super().__init__(config, data, **given)
        self._fault, self._before, self._marked, self.struck, self.lost = None, {}, (None, ""), False, False
        self._ids = max(2, config.memory.outstanding)
        self._wait = 3 << config.memory.timeout_bits

    def arm(self, fault: BusFault | None) -> None:
        """Count bursts from now on."""
        self._fault, self._before = fault, {"reads": len(self.reads), "writes": len(self.writes)}
        self.struck = self.lost = False

    def _armed(self, kinds, bursts):
        """The kind of the fault, if the latest burst may have it."""
        fault = self._fault
        comes = fault and fault.kind in kinds and len(getattr(self, bursts)) - self._before[bursts] > fault.burst
        return fault.kind if comes else ""

    def _strike(self, *, lost):
        self._fault, self.struck, self.faulty, self.lost = None, True, True, lost

    def _read(self, pins):
        super()._read(pins)
        kind = self._armed(READ_FAULTS, "reads")
        if not kind:
            return
        due, left = self._due_reads[-1]
        most = len(left) - (kind in ("another beat marked", "id of another read"))
        used = sorted({beat[0] for _, beats in self._due_reads for beat in beats} - {pins["arid"]})
        free = [k for k in range(self._ids) if k not in used and k != pins["arid"] and not (
            self.out["rvalid"] and self.out["rid"] == k)]
        if not most or (kind == "id of another read" and not used) or (
                kind in ("free id", "unexpected beat") and not free):
            return
        at = self._fault.beat % most
        number, data, response, last = left[at]
        other, wrong = data ^ 0x5A, ERROR if self._fault.error else response
        if kind in ("slverr", "decerr"):
            left[at] = number, other, ERROR if kind == "slverr" else DECERR, last
        elif kind == "late":
            self._due_reads[-1] = due + self._wait, left
        elif kind == "silent":
            self._due_reads.pop()
        elif kind in ("free id", "id of another read"):
            # The id that is used last: a read that begins meanwhile would make it the id of another read.
            number = max(free, key=lambda k: (k - pins["arid"]) % self._ids) if kind == "free id" else used[0]
            left[at] = number, other, response, last
        elif kind == "unexpected beat":
            self.inject(rid=free[0], rdata=other, rlast=last, rresp=wrong)
        elif kind == "last beat not marked":
            left[-1] = *left[-1][:2], wrong, 0
        elif kind == "another beat marked":
            self.cut(most - at)
        elif kind == "a beat again":
            left.insert(at, (number, other, response, 0))
        elif kind == "last beat again":
            left.append((number, other, response, 1))
        self._strike(lost=kind in _LOST or (kind == "free id" and bool(last)))

    def _accept(self, pins):
        super()._accept(pins)
        kind = self._armed(WRITE_FAULTS, "writes")
        if not kind:
            return
        if kind == "answer before the data":
            # Else it is the answer of another burst: all have the same id.
            if len(self._open) > 1 or self._due_writes or self.out["bvalid"]:
                return
            self._due_writes.append((self._now, 0, 0))
        elif kind == "unexpected answer":
            self.inject(bid=1)
        self._marked = self._open[-1], kind
        self._strike(lost=kind in _LOST)

    def _answer(self, burst):
        super()._answer(burst)
        marked, kind = self._marked
        if burst is not marked:
            return
        due, number, response = self._due_writes.pop()
        answers = {"write slverr": [(due, number, ERROR)], "write decerr": [(due, number, DECERR)],
                   "write late": [(due + self._wait, number, response)], "write silent": [],
                   "write wrong id": [(due, 1, response)], "answer before the data": [],
                   "answer again": [(due, number, response)] * 2}
        self._due_writes.extend(answers.get(kind, [(due, number, response)]))

"""A machine as its driver sees it: registers and main memory, without cycles."""

import ctypes

import numpy as np

from golden.engine.jobs.completion import COMPLETION, lap
from golden.engine.jobs.descriptor import DESCRIPTOR
from hw.registers.engine_registers import ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.register import WORD_BYTES, Access, addresses
from tb.radiosity.flow.package.driver_library import PortFunctions

__all__ = ["RegisterMachine"]

_ADDRESSES = addresses(ENGINE_REGISTERS)
_NAMES = {address + WORD_BYTES * word: (one, word) for one in ENGINE_REGISTERS
          for address in (_ADDRESSES[one.name],) for word in range(one.words)}


class RegisterMachine:
    """Completes a descriptor each time that the driver waits, by the rules of docs/formats/registers.md.

    Parameters
    ----------
    size
        Bytes of main memory, from address 0 on.

    Members
    -------
    values
        The registers, which a test may set.
    memory
        Main memory.
    log
        What the driver has done: ("read", register), ("write", register, value), ("wait", is_interrupt).
    errors
        By tag: the error code with which a descriptor completes.
    sums
        By tag: the words of sums that a descriptor leaves at its address.
    settles
        Waits until a stop or a resume is over.
    broken
        Accesses from now on up to the one that fails; None: none fails.
    """

    def __init__(self, size: int):
        self.values = {one.name: one.reset for one in ENGINE_REGISTERS}
        self.values |= {"magic": MAGIC, "version": VERSION, "clusters": 2}
        self.status = dict.fromkeys((field.name for field in register("status").fields), 0)
        self.memory, self.log, self.errors, self.sums = bytearray(size), [], {}, {}
        self.settles, self.broken, self.stuck, self._due = 0, None, False, None
        self._functions = PortFunctions(None, *(
            kind(self._guarded(function)) for (_, kind), function in zip(PortFunctions._fields_[1:], (
                self._read, self._write, self._read_memory, self._write_memory, self._wait), strict=True)))
        self.port = ctypes.byref(self._functions)

    def _guarded(self, function):
        def call(context, *arguments):
            if self.broken is not None:
                self.broken -= 1
                if self.broken == -1:
                    return 1
            function(*arguments)
            return 0
        return call

    def _read(self, address, value):
        one, word = _NAMES.get(address, (None, 0))
        self.log.append(("read", one.name if one else address))
        if one is None:
            value[0] = address
            return
        number = register("status").pack(**self._status()) if one.name == "status" else self.values[one.name]
        value[0] = number >> 32 * word & 0xFFFF_FFFF

    def _status(self):
        waits = not self.status["halted"] and self.values["doorbell"] != self.values["taken"]
        return self.status | {"busy": int(waits or self.status["busy"]), "failed": int(self.values["error"] > 0)}

    def _write(self, address, value):
        one, word = _NAMES[address]
        assert one.access is not Access.READ, one.name
        assert value < 1 << min(32, one.width - 32 * word), (one.name, value)
        self.log.append(("write", one.name, value))
        if one.name == "command":
            self._command(value)
        elif one.name == "interrupt":
            self.values["interrupt"] = (value & 1) | (self.values["interrupt"] & ~value & 2)
        else:
            mask = 0xFFFF_FFFF << 32 * word
            self.values[one.name] = (self.values[one.name] & ~mask) | value << 32 * word

    def _command(self, value):
        """Of several the lowest bit counts."""
        if value & 1:
            self.status |= {"halted": 1, "stops": 1, "busy": 1, "loaded": 0}
            self._due = (self.settles, {"stops": 0, "busy": self.status["unwritten"]})
        elif value & 2:
            self.values["error"] = 0
        elif value & 4:
            assert self.status["halted"]
            assert not self.status["stops"]
            self._due = (self.settles, {"halted": 0, "loaded": 1, "busy": 0, "unwritten": 0})

    def _read_memory(self, address, data, size):
        ctypes.memmove(data, bytes(self.memory[address:address + size]), size)

    def _write_memory(self, address, data, size):
        self.memory[address:address + size] = ctypes.string_at(data, size)

    def _wait(self, is_interrupt):
        self.log.append(("wait", bool(is_interrupt)))
        if self._due:
            waits, status = self._due
            self._due = (waits - 1, status) if waits else None
            if not waits:
                self.status |= status
        elif not self.status["halted"] and not self.stuck:
            self._complete()

    def _complete(self):
        """Take the next descriptor, and write its record."""
        taken, values = self.values["taken"], self.values
        if taken == values["doorbell"]:
            return
        size, mask = DESCRIPTOR.dtype.itemsize, (1 << values["ring_bits"]) - 1
        entry = values["ring"] + (taken & mask) * size
        (descriptor,) = np.frombuffer(self.memory[entry:entry + size], dtype=DESCRIPTOR.dtype)
        record = np.zeros(1, dtype=COMPLETION.dtype)
        record["tag"], record["error"] = descriptor["tag"], self.errors.get(int(descriptor["tag"]), 0)
        words = self.sums.get(int(descriptor["tag"]), np.zeros(0, dtype="<u8"))
        record["sums"], place = len(words), int(descriptor["sums_address"])
        self.memory[place:place + words.nbytes] = words.tobytes()
        record["lap"] = lap(values["completed"], values["ring_bits"])
        entry = values["completions"] + (values["completed"] & mask) * COMPLETION.dtype.itemsize
        self.memory[entry:entry + COMPLETION.dtype.itemsize] = record.tobytes()
        values["taken"] = values["completed"] = (taken + 1) % (1 << 32)
        values["interrupt"] |= 2

    def halt(self, code: int, cluster: int, address: int) -> None:
        """The queue halts with an error of the machine itself."""
        self.status["halted"] = 1
        self.values |= {"error": code, "error_cluster": cluster, "error_address": address}

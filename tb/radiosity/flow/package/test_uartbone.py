"""The exported host of a SoC casts its job through a bridge whose replies arrive in parts, as over a serial line."""

import ctypes
import shutil
import socket
import struct
import subprocess
import threading
import time
from pathlib import Path

import pytest

from tb.radiosity.flow.package.driver_library import FLAGS, PortFunctions, complaints
from tb.radiosity.flow.package.register_machine import RegisterMachine

SIZE, WORD = 1 << 22, 4
SCRATCH, PENDING, RAM, REGISTERS = 0x4, 0x1000, 0x4000_0000, 0x8000_0000
WRITE, READ = 1, 2
# What LiteX writes for a SoC, as far as the host uses it.
HEADERS = {
    "csr.h": f"""
        #include <stdint.h>
        #define CSR_CTRL_SCRATCH_ADDR {SCRATCH}UL
        static inline uint32_t radiosity_ev_pending_read(void) {{ return (uint32_t)csr_read_simple({PENDING}UL); }}
        static inline void sdram_dfii_control_write(uint32_t value) {{ csr_write_simple(value, {SCRATCH}UL); }}
        """,
    # The memory's size is given to the compiler.
    "mem.h": f"""
        #define MAIN_RAM_BASE {RAM}UL
        #define RADIOSITY_BASE {REGISTERS}UL
        """,
    "sdram_phy.h": """
        #define DFII_CONTROL_SEL 1
        void cdelay(int cycles);
        static inline void init_sequence(void) { cdelay(1); }
        """}


class Bridge(threading.Thread):
    """UARTBone over TCP at a machine of registers, which works as long as the host looks for an interrupt.

    Parameters
    ----------
    machine
        The machine.
    polls
        The host looks so often in vain before the machine works.

    Members
    -------
    port
        Where it listens.
    replies
        Each is sent in two parts, but for those of events: how many there were.
    end
        In memory: the first byte after all that was read or written.
    """

    def __init__(self, machine: RegisterMachine, polls: int = 0):
        super().__init__(daemon=True)
        self._polls, self._waited = polls, 0
        self._machine, self._functions = machine, ctypes.cast(machine.port, ctypes.POINTER(PortFunctions)).contents
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port, self.replies, self.end = self._listener.getsockname()[1], 0, 0

    def run(self):
        """Serve one host."""
        with self._listener, self._listener.accept()[0] as connection, connection.makefile("rb") as requests:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            while head := requests.read(6):
                command, words, address = struct.unpack(">BBI", head)
                if RAM <= WORD * address < REGISTERS:
                    self.end = max(self.end, WORD * (address + words) - RAM)
                if command == WRITE:
                    for number, value in enumerate(struct.unpack(f">{words}I", requests.read(WORD * words))):
                        self._write(WORD * (address + number), value)
                    continue
                assert command == READ
                reply = struct.pack(f">{words}I", *(self._read(WORD * (address + number)) for number in range(words)))
                if WORD * address != PENDING:
                    connection.sendall(reply[:3])
                    time.sleep(1e-3)
                    reply = reply[3:]
                connection.sendall(reply)
                self.replies += 1

    def _read(self, address):
        if address >= REGISTERS:
            value = ctypes.c_uint32()
            assert not self._functions.read(None, address - REGISTERS, ctypes.byref(value))
            return value.value
        if address >= RAM:
            return int.from_bytes(self._machine.memory[address - RAM:address - RAM + WORD], "little")
        if address == PENDING:
            self._waited += 1
            if self._waited <= self._polls:
                return 0
            self._waited = 0
            assert not self._functions.wait(None, 1)
            return self._machine.values["interrupt"] >> 1
        return 0

    def _write(self, address, value):
        if address >= REGISTERS:
            assert not self._functions.write(None, address - REGISTERS, value)
        elif address >= RAM:
            self._machine.memory[address - RAM:address - RAM + WORD] = value.to_bytes(WORD, "little")


@pytest.fixture(scope="module")
def folder(exported, tmp_path_factory) -> Path:
    """That of an export, with the host compiled."""
    folder = shutil.copytree(exported, tmp_path_factory.mktemp("host") / "core")
    (folder / "generated").mkdir()
    for name, text in HEADERS.items():
        (folder / "generated" / name).write_text(text)
    compile_host(folder)
    return folder


def compile_host(folder, size=SIZE):
    """The program ``host``, for a memory of ``size`` bytes."""
    assert not complaints(folder, "gcc", *FLAGS, f"-DMAIN_RAM_SIZE={size}UL", "-Idriver", "-Iexample", "-Ijob",
                          "-isystem", ".", "-o", "host", "litex_soc/uartbone.c", "example/cast_job.c",
                          "driver/radiosity.c")


def cast_through_bridge(folder, polls=0):
    """The host has cast its job: the machine, its bridge, and how the host ended."""
    machine = RegisterMachine(SIZE)
    bridge = Bridge(machine, polls)
    bridge.start()
    done = subprocess.run([folder / "host", "127.0.0.1", str(bridge.port), folder / "job" / "job.bin"],
                          capture_output=True, text=True, check=False, timeout=60)
    bridge.join(10)
    return machine, bridge, done


def test_a_job_is_cast_though_replies_arrive_in_parts(folder):
    job = (folder / "job" / "job.bin").read_bytes()
    machine, bridge, done = cast_through_bridge(folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("hit ") == 256
    assert machine.values["completed"] == 2
    assert machine.memory[len(job) - 1024:len(job)] == job[-1024:]
    assert bridge.replies > len(job) // (64 * WORD)


@pytest.mark.parametrize("polls", [999, 1000, 1501])
def test_a_slow_machine_is_awaited(folder, polls):
    """The host looks a thousand times for an event; that none has come is no error."""
    machine, _, done = cast_through_bridge(folder, polls)
    assert (done.returncode, done.stderr) == (0, "")
    assert machine.values["completed"] == 2
    assert done.stdout.count("hit ") == 256


def test_a_job_may_fill_the_memory_and_not_a_word_more(folder, tmp_path):
    folder = shutil.copytree(folder, tmp_path / "core")
    end = cast_through_bridge(folder)[1].end
    assert WORD <= end < SIZE
    compile_host(folder, end)
    _, bridge, done = cast_through_bridge(folder)
    assert (done.returncode, done.stderr, bridge.end) == (0, "", end)
    compile_host(folder, end - WORD)
    _, bridge, done = cast_through_bridge(folder)
    assert done.returncode == 1
    assert done.stderr.startswith("error: ")
    assert bridge.end < end


@pytest.mark.parametrize(("arguments", "code", "message"), [
    (["127.0.0.1"], 2, "usage: "), (["missing", "job.bin"], 1, "error: missing cannot be opened\n")])
def test_a_host_without_a_bridge_says_so(folder, arguments, code, message):
    done = subprocess.run([folder / "host", *arguments], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == code
    assert done.stderr.startswith(message)

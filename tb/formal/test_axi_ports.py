"""The rules of AXI at the port of main memory, and of AXI-Lite at the registers: for all values of all other pins."""

import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal
from amaranth.lib import wiring

from golden.config import PRESETS
from hw.memsys import main_memory_port, read_buffer, read_engine, write_engine
from hw.memsys.fault import Fault
from hw.memsys.main_memory_port import MainMemoryPort
from hw.registers.register import Access, Register
from hw.registers.registers import Registers
from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.protocol_checker import ProtocolChecker
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.source_fault import source_fault
from tb.formal.stream_rules import add_rules

# Bursts of two beats, requests of up to four.
CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
ENGINE = "abc bmc3"
MANAGER_DEPTH, SUBORDINATE_DEPTH = 18, 10
ADDRESS_BITS = 5
TABLE = (Register(name="said", access=Access.READ, about="."), Register(name="go", access=Access.COMMAND, about="."),
         Register(name="mode", access=Access.WRITE, about="."))


def watched(bench, dut, protocol, port):
    """A module with the component, connected to the bench's ports, and a checker of one of these."""
    m = Module()
    m.submodules.dut = dut
    connect_ports(m, bench, dut)
    m.submodules.checker = checker = ProtocolChecker(protocol)
    checker.watch(m, port)
    return m, checker


class ManagerRules(wiring.Component):
    """The port keeps AXI's rules whatever its clients request and whatever memory does, faults and resets included.

    Parameters
    ----------
    rules
        Those that are asserted; default: all of the manager.
    never
        Of `REACHED`: asserted never to occur. Solvers of covers take ten times as long.
    """

    def __init__(self, dut, protocol, rules=None, never=()):
        self._dut, self._protocol, self._never = dut, protocol, never
        self._rules = protocol.manager if rules is None else rules
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m, checker = watched(self, self._dut, self._protocol, self.axi)
        for interface in (self.i_read, self.i_write, self.i_write_data):
            add_rules(m, interface, Assume)
        # The windows stay.
        for window in (self.read_window, self.write_window):
            m.d.comb += [Assume(window.base == 0), Assume(window.limit == 1 << CONFIG.memory.address_bits)]
        m.d.comb += [Assert(~checker.violated[rule]) for rule in self._rules]
        axi, reads, answered = self.axi, Signal(2), {}
        for name, reply in ("read", self.o_read), ("write", self.o_written):
            answered[name] = reply.valid & ~reply.payload.error
        with m.If(axi.arvalid & axi.arready & (reads != 3)):
            m.d.sync += reads.eq(reads + 1)
        reached = {"two beats written": answered["write"] & (axi.awlen == 1),
                   "two beats read while an id is used again": answered["read"] & (axi.arlen == 1) & (reads == 3),
                   "a read after a time-out": answered["read"] & (self.fault.code == Fault.READ_TIMEOUT),
                   "a write after a time-out": answered["write"] & (self.fault.code == Fault.WRITE_TIMEOUT)}
        m.d.comb += [Assert(~reached[name]) for name in self._never]
        return m


class SubordinateRules(wiring.Component):
    """The registers keep AXI-Lite's rules if the host does. Words of the window come at any time.

    Covers answers of both kinds that stall while the next access has been accepted.

    Parameters
    ----------
    rules
        Those that are asserted; default: all of the subordinate.
    """

    def __init__(self, dut, protocol, rules=None):
        self._dut, self._protocol = dut, protocol
        self._rules = protocol.subordinate if rules is None else rules
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m, checker = watched(self, self._dut, self._protocol, self.host)
        add_rules(m, self.i_window, Assume)
        m.d.comb += [
            *(Assume(~checker.violated[rule]) for rule in self._protocol.manager),
            *(Assert(~checker.violated[rule]) for rule in self._rules),
            *(Cover(valid & ~ready & (resp == answer) & ~free) for valid, ready, resp, free in (
                (self.host.bvalid, self.host.bready, self.host.bresp, self.host.awready | self.host.wready),
                (self.host.rvalid, self.host.rready, self.host.rresp, self.host.arready)) for answer in (0, 2))]
        return m


# In the nightly: that a commit's negative control fails needs two beats written.
REACHED = ("two beats written", "two beats read while an id is used again", "a read after a time-out",
           "a write after a time-out")
# By name: a rule, and an output that violates it. A commit's tests run the first one of each kind.
MANAGER_FAULTS = {
    "last beat marked early": ("w_last", {"axi__wlast": lambda dut: dut.axi.wvalid}),
    "one id": ("ar_id", {"axi__arid": lambda dut: 0}),
    "across a page": ("ar_page", {"axi__araddr": lambda dut: dut.axi.araddr ^ 8}),
    "last beat not marked": ("w_last", {"axi__wlast": lambda dut: 0}),
    "a beat without a burst": ("w_announced", {"axi__awvalid": lambda dut: 0}),
    "data change": ("w_stable", {"axi__wdata": lambda dut: dut.axi.wdata ^ dut.axi.arvalid}),
    "an address is withdrawn": ("ar_stable", {"axi__arvalid": lambda dut: dut.axi.arvalid & ~dut.axi.awvalid}),
    "a beat more": ("aw_length", {"axi__awlen": lambda dut: dut.axi.awlen + 1}),
    "after a reset": ("aw_reset", {"axi__awvalid": lambda dut: dut.axi.awvalid | ~dut.busy}),
}
# Faults inside that depend on what memory answers.
EXPECTED = "expected = (accepted > unaddressed) &"
INSIDE = {
    "a beat before its burst": (read_buffer.ReadBuffer, "bit_select(beat.id, 1) & ~early)", "bit_select(beat.id, 1))",
                                "ar_id"),
    "an answer before the data": (write_engine.WriteEngine, EXPECTED, "expected = (outstanding != 0) &", "aw_count"),
    "an answer before the address": (write_engine.WriteEngine, EXPECTED, "expected = (accepted != 0) &", "aw_count"),
    "forgets late beats": (read_engine.ReadEngine, "m.Elif(~buffer.outstanding.any())", "m.Elif(~timeout.expired)",
                           "ar_id"),
}
SUBORDINATE_FAULTS = {
    "answers without data": ("b_due", {"host__bvalid": lambda dut: dut.host.bvalid | ~dut.host.awready}),
    "answers again": ("r_due", {"host__rvalid": lambda dut: dut.host.rvalid | dut.go.valid}),
    "data change": ("r_stable", {"host__rdata": lambda dut: dut.host.rdata ^ dut.go.valid}),
    "accepts more": ("ar_count", {"host__arready": lambda dut: 1}),
    "after a reset": ("b_reset", {"host__bvalid": lambda dut: dut.host.bvalid | (dut.mode == 0)}),
}


def manager(faults=None, **checks):
    dut = MainMemoryPort(config=CONFIG, tag=1)
    return ManagerRules(NegativeControl(dut, faults) if faults else dut, AxiProtocol(CONFIG), **checks)


def subordinate(faults=None, **checks):
    dut = Registers(TABLE, address_bits=ADDRESS_BITS)
    return SubordinateRules(NegativeControl(dut, faults) if faults else dut, AxiLiteProtocol(ADDRESS_BITS), **checks)


def controls(faults):
    first, *others = faults
    return [first, *(pytest.param(fault, marks=pytest.mark.nightly) for fault in others)]


def holds(bench, depth=MANAGER_DEPTH):
    return prove(bench, mode="bmc", depth=depth, engine=ENGINE)


def test_rules_of_the_manager_port():
    assert holds(manager())


@pytest.mark.nightly
@pytest.mark.parametrize("name", REACHED)
def test_reaches_bursts(name):
    assert not holds(manager(rules=(), never=(name,)))


@pytest.mark.parametrize("fault", controls(MANAGER_FAULTS))
def test_negative_control_of_the_manager_port(fault):
    rule, faults = MANAGER_FAULTS[fault]
    assert not holds(manager(faults, rules=(rule,)))


@pytest.mark.parametrize("fault", controls(INSIDE))
def test_negative_control_inside(monkeypatch, fault):
    part, right, wrong, rule = INSIDE[fault]
    user = read_engine if part is read_buffer.ReadBuffer else main_memory_port
    monkeypatch.setattr(user, part.__name__, source_fault(part, right, wrong))
    assert not holds(manager(rules=(rule,)))


def test_rules_of_the_registers():
    assert holds(subordinate(), SUBORDINATE_DEPTH)


def test_reaches_answers():
    assert prove(subordinate(), mode="cover", depth=SUBORDINATE_DEPTH)


@pytest.mark.parametrize("fault", controls(SUBORDINATE_FAULTS))
def test_negative_control_of_the_registers(fault):
    rule, faults = SUBORDINATE_FAULTS[fault]
    assert not holds(subordinate(faults, rules=(rule,)), SUBORDINATE_DEPTH)

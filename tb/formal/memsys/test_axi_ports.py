"""The rules of AXI at the port of main memory, and of AXI-Lite at the registers: for all values of all other pins."""

from amaranth.hdl import Assert, Assume, Cover, Signal

from golden.engine.config import PRESETS
from hw.memsys.port.fault import Fault
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.memsys.port.read_buffer import ReadBuffer
from hw.memsys.port.read_engine import ReadEngine
from hw.memsys.port.write_engine import WriteEngine
from hw.registers.register import Access, Register
from hw.registers.registers import Registers
from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.protocol_checker import ProtocolChecker
from tb.formal.bench import Bench
from tb.formal.declare import Control, declare
from tb.formal.source_fault import source_fault, with_parts
from tb.formal.stream_rules import add_rules

# Bursts of two beats, requests of up to four.
CONFIG = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
ENGINE = "abc bmc3"
ADDRESS_BITS = 5
TABLE = (Register(name="said", access=Access.READ, about="."), Register(name="go", access=Access.COMMAND, about="."),
         Register(name="mode", access=Access.WRITE, about="."))


def checked(m, protocol, port):
    """Violations of a protocol's rules at a port."""
    m.submodules.checker = checker = ProtocolChecker(protocol)
    checker.watch(m, port)
    return checker.violated


def manager(m, bench, dut, protocol):
    """The port keeps AXI's rules whatever its clients request and whatever memory does, faults and resets included."""
    violated = checked(m, protocol, dut.axi)
    for interface in (dut.i_read, dut.i_write, dut.i_write_data):
        add_rules(m, interface, Assume)
    # The windows stay; half of all requests are outside of them.
    for window in (dut.read_window, dut.write_window):
        m.d.comb += [Assume(window.base == 0), Assume(window.limit == 1 << CONFIG.memory.address_bits - 1)]
    m.d.comb += [Assert(~violated[rule], rule) for rule in protocol.manager]
    axi, reads, (read, written) = dut.axi, Signal(2), (
        reply.valid & ~reply.payload.error for reply in (dut.o_read, dut.o_written))
    with m.If(axi.arvalid & axi.arready & (reads != 3)):
        m.d.sync += reads.eq(reads + 1)
    m.d.comb += [Cover(written & (axi.awlen == 1), "two beats written"),
                 Cover(read & (axi.arlen == 1) & (reads == 3), "two beats read while an id is used again"),
                 Cover(read & (dut.fault.code == Fault.READ_TIMEOUT), "a read after a time-out"),
                 Cover(written & (dut.fault.code == Fault.WRITE_TIMEOUT), "a write after a time-out")]


def subordinate(m, bench, dut, protocol):
    """The registers keep AXI-Lite's rules if the host does. Words of the window come at any time.

    Covers answers of both kinds that stall while the next access has been accepted.
    """
    violated, host = checked(m, protocol, dut.host), dut.host
    add_rules(m, dut.i_window, Assume)
    m.d.comb += [
        *(Assume(~violated[rule]) for rule in protocol.manager),
        *(Assert(~violated[rule], rule) for rule in protocol.subordinate),
        *(Cover(valid & ~ready & (resp == answer) & ~free, f"{name} of {answer}")
          for name, valid, ready, resp, free in (
              ("write", host.bvalid, host.bready, host.bresp, host.awready | host.wready),
              ("read", host.rvalid, host.rready, host.rresp, host.arready)) for answer in (0, 2))]


def inside(part, right, wrong):
    """The port with a fault in one of its parts."""
    faulty = source_fault(part, right, wrong)
    return with_parts(MainMemoryPort, **(
        {"ReadEngine": with_parts(ReadEngine, ReadBuffer=faulty)} if part is ReadBuffer else {part.__name__: faulty}))


EXPECTED = "expected = (accepted > unaddressed) &"
# In the nightly the covers: that the control of a commit fails needs two beats written.
test_manager_port = declare(
    lambda kind=MainMemoryPort: Bench(manager, kind(config=CONFIG, tag=1), protocol=AxiProtocol(CONFIG)),
    cycles=18, engine=ENGINE, covers_nightly=True, controls={
        "last beat marked early": Control("w_last", {"axi__wlast": lambda dut: dut.axi.wvalid}),
        "one id": Control("ar_id", {"axi__arid": lambda dut: 0}, nightly=True),
        "across a page": Control("ar_page", {"axi__araddr": lambda dut: dut.axi.araddr ^ 8}, nightly=True),
        "last beat not marked": Control("w_last", {"axi__wlast": lambda dut: 0}, nightly=True),
        "a beat without a burst": Control("w_announced", {"axi__awvalid": lambda dut: 0}, nightly=True),
        "data change": Control("w_stable", {"axi__wdata": lambda dut: dut.axi.wdata ^ dut.axi.arvalid}, nightly=True),
        "an address is withdrawn": Control(
            "ar_stable", {"axi__arvalid": lambda dut: dut.axi.arvalid & ~dut.axi.awvalid}, nightly=True),
        "a beat more": Control("aw_length", {"axi__awlen": lambda dut: dut.axi.awlen + 1}, nightly=True),
        "after a reset": Control("aw_reset", {"axi__awvalid": lambda dut: dut.axi.awvalid | ~dut.busy}, nightly=True),
        # Faults inside that depend on what memory answers.
        "a beat before its burst": Control("ar_id", kind=inside(
            ReadBuffer, "bit_select(beat.id, 1) & ~early)", "bit_select(beat.id, 1))")),
        "an answer before the data": Control("aw_count", nightly=True, kind=inside(
            WriteEngine, EXPECTED, "expected = (outstanding != 0) &")),
        "an answer before the address": Control("aw_count", nightly=True, kind=inside(
            WriteEngine, EXPECTED, "expected = (accepted != 0) &")),
        "forgets late beats": Control("ar_id", nightly=True, kind=inside(
            ReadEngine, "m.Elif(~buffer.outstanding.any())", "m.Elif(~timeout.expired)")),
    })
test_registers = declare(
    lambda: Bench(subordinate, Registers(TABLE, address_bits=ADDRESS_BITS), protocol=AxiLiteProtocol(ADDRESS_BITS)),
    cycles=10, controls={
        "answers without data": Control("b_due", {"host__bvalid": lambda dut: dut.host.bvalid | ~dut.host.awready}),
        "answers again": Control("r_due", {"host__rvalid": lambda dut: dut.host.rvalid | dut.go.valid}, nightly=True),
        "data change": Control("r_stable", {"host__rdata": lambda dut: dut.host.rdata ^ dut.go.valid}, nightly=True),
        "accepts more": Control("ar_count", {"host__arready": lambda dut: 1}, nightly=True),
        "after a reset": Control("b_reset", {"host__bvalid": lambda dut: dut.host.bvalid | (dut.mode == 0)},
                                 nightly=True),
    })

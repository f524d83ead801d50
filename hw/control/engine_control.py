"""Engine control: commands, their preconditions, and errors."""

from amaranth.hdl import Array, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.control.control_formats import ControlFormats
from hw.control.load_control import ALL
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import PathFormats
from hw.noc.network_fault import NetworkFault
from hw.registers.engine_registers import register
from hw.registers.error_code import NETWORK, ErrorCode

__all__ = ["EngineControl"]


class EngineControl(wiring.Component):
    """Accepts a command if its preconditions hold, latches the first error, and ends a command that takes too long.

    A load or a cast begins when nothing is in flight. Results of the frustum before the present one may be written
    while that one is cast. A stop holds all units in reset until main memory has no outstanding transaction: resets are
    synchronous, so one cycle is enough for all else. A command in the cycle of another one's start is refused, one in
    the cycle before a reset is lost.

    The watchdog counts the cycles since the last start in which an activity is in flight, the start among them. Of
    errors of one cycle the first of these is latched: watchdog, load, results, port, command, cluster, network. The
    watchdog and the end of a load or of results are events: in the cycle of a clear they are an error after it.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_command : In, stream of the register ``command``
        Commands. Always ready.
    regions : In(regions)
        The register.
    earlier : In(1)
        The register ``results`` selects the earlier frustum.
    watchdog : In(32)
        The register; 0: off.
    loads, casts, writes, memory_busy : In(1)
        Busy: the load, a cluster's cast, the results, the port of main memory.
    loading, casting, writing : Out(1)
        Start them, for one cycle; the started one is busy in the next cycle.
    stops, clear : Out(1)
        Reset all units but the port; clear the faults.
    load_over, write_over : In, stream of `MemoryFormats.fault`
        Ends of loads and of results. Always ready.
    memory_fault : In(MemoryFormats.fault)
        Fault of the port.
    clusters : In(ArrayLayout(ControlFormats.fault, nodes))
        Faults of the clusters.
    networks : In(ArrayLayout(NetworkFault, nodes))
        Faults of their network interfaces.
    status : Out(status)
        The register.
    error : Out(ControlFormats.error)
        The first error.

    Timing
    ------
    Latency: ``1`` cycle from a command to its start. An error is latched in the cycle after its event, the watchdog's 3
    cycles after the first cycle too many. A cluster's takes 2 to ``nodes + 1`` cycles: one cluster per cycle is polled.
    A reset begins in the cycle in which its error can be read.

    Golden counterpart: `golden.control.engine_control.EngineControl`.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, memory, control = config, MemoryFormats(config), ControlFormats(config)
        over = stream.Signature(memory.fault, always_ready=True)
        nodes, word = config.noc.nodes, 32
        self._cluster = PathFormats(config).cluster
        super().__init__({
            "i_command": In(stream.Signature(register("command").width, always_ready=True)),
            "regions": In(register("regions").width), "earlier": In(1), "watchdog": In(word),
            **{name: In(1) for name in ("loads", "casts", "writes", "memory_busy")},
            **{name: Out(1) for name in ("loading", "casting", "writing", "stops", "clear")},
            "load_over": In(over), "write_over": In(over), "memory_fault": In(memory.fault),
            "clusters": In(ArrayLayout(control.fault, nodes)), "networks": In(ArrayLayout(NetworkFault, nodes)),
            "status": Out(register("status").width), "error": Out(control.error)})

    def elaborate(self, platform):
        m = Module()
        command, nodes = register("command"), self._config.noc.nodes
        bits = {field.name: Signal(name=f"requests_{field.name}") for field in command.fields}
        before = 0
        for k, bit in enumerate(bits.values()):
            m.d.comb += bit.eq(self.i_command.valid & self.i_command.payload[k] & ~before)
            before = self.i_command.payload[:k + 1].any()
        nothing = self.i_command.valid & ~self.i_command.payload.any()

        loaded, present, earlier = Signal(), Signal(), Signal()
        begins = self.loading | self.casting | self.writing
        idle, free = Signal(), Signal()
        m.d.comb += [idle.eq(~(self.loads | self.casts | self.writes | self.stops | begins)),
                     free.eq(~(self.loads | self.writes | self.stops | begins) & (~self.casts | self.earlier)
                             & Mux(self.earlier, earlier, present))]
        obeyed, ends = {"load": idle, "cast": idle & loaded, "write": free}, Signal()
        m.d.sync += [getattr(self, target).eq(bits[name] & obeyed[name] & ~ends) for name, target in
                     (("load", "loading"), ("cast", "casting"), ("write", "writing"))]
        m.d.comb += self.clear.eq(bits["clear"] | self.stops)

        # Tables are complete after a load of all of them; after a load that fails they are undefined.
        complete = Signal()
        with m.If(self.loading):
            m.d.sync += complete.eq((self.regions & ALL) == ALL)
        with m.If(self.load_over.valid):
            m.d.sync += loaded.eq((self.load_over.payload.code == Fault.NONE) & (loaded | complete))
        with m.If(self.casting):
            m.d.sync += [present.eq(1), earlier.eq(present)]

        # Cycles of the present commands.
        cycles, late = Signal(32), Signal()
        m.d.sync += [cycles.eq(Mux(idle | begins | self.stops, 0, cycles + 1)),
                     late.eq(~self.stops & (self.watchdog != 0) & (cycles >= self.watchdog))]

        # Errors; one cluster per cycle.
        number, fault, network = Signal(self._cluster), Signal.like(self.clusters[0]), Signal(NetworkFault)
        previous = Signal.like(number)
        m.d.sync += [number.eq(Mux(number == nodes - 1, 0, number + 1)), previous.eq(number),
                     fault.eq(Array(self.clusters[k].as_value() for k in range(nodes))[number]),
                     network.eq(Array(self.networks[k].as_value() for k in range(nodes))[number])]
        with m.If(self.clear):
            m.d.sync += [fault.as_value().eq(0), network.eq(NetworkFault.NONE)]
        error = self.error
        wrong = {"command": (bits["load"] & ~idle) | (bits["cast"] & ~idle) | (bits["write"] & ~free) | nothing,
                 "not_loaded": bits["cast"] & idle & ~loaded}
        with m.If(bits["clear"]):
            m.d.sync += error.as_value().eq(0)
        # Faults that are events are reported once, so a clear in their cycle must not lose them.
        with m.If(bits["clear"] | (error.code == ErrorCode.NONE)):
            m.d.sync += error.cluster.eq(0)
            with m.If(late):
                m.d.sync += error.code.eq(ErrorCode.WATCHDOG)
            with m.Elif(self.load_over.valid & (self.load_over.payload.code != Fault.NONE)):
                m.d.sync += [error.code.eq(self.load_over.payload.code.as_value()),
                             error.number.eq(self.load_over.payload.address)]
            with m.Elif(self.write_over.valid & (self.write_over.payload.code != Fault.NONE)):
                m.d.sync += [error.code.eq(self.write_over.payload.code.as_value()),
                             error.number.eq(self.write_over.payload.address)]
            with m.Elif(bits["clear"]):
                # The other errors of this cycle are cleared with the earlier ones.
                pass
            with m.Elif(self.memory_fault.code != Fault.NONE):
                m.d.sync += [error.code.eq(self.memory_fault.code.as_value()),
                             error.number.eq(self.memory_fault.address)]
            with m.Elif(wrong["command"]):
                m.d.sync += error.code.eq(ErrorCode.COMMAND)
            with m.Elif(wrong["not_loaded"]):
                m.d.sync += error.code.eq(ErrorCode.NOT_LOADED)
            with m.Elif(fault.code != ErrorCode.NONE):
                m.d.sync += [error.code.eq(fault.code), error.cluster.eq(previous), error.number.eq(fault.number)]
            with m.Elif(network != NetworkFault.NONE):
                m.d.sync += [error.code.eq(network.as_value() + NETWORK), error.cluster.eq(previous)]

        # Errors that leave units in an undefined state end in a reset.
        m.d.comb += ends.eq(bits["stop"] | late | (fault.code == ErrorCode.PATH_TIMEOUT)
                            | (network != NetworkFault.NONE))
        with m.If(self.stops):
            m.d.sync += self.stops.eq(self.memory_busy)
        with m.Elif(ends):
            m.d.sync += self.stops.eq(1)
        with m.If(self.stops):
            m.d.sync += [loaded.eq(0), present.eq(0), earlier.eq(0), self.loading.eq(0), self.casting.eq(0),
                         self.writing.eq(0)]
        failed = error.code != ErrorCode.NONE
        bits_of = {"loads": self.loads | self.loading, "casts": self.casts | self.casting,
                "writes": self.writes | self.writing, "stops": self.stops, "loaded": loaded, "failed": failed,
                "present": present, "earlier": earlier}
        for k, field in enumerate(register("status").fields):
            m.d.comb += self.status[k].eq(bits_of[field.name])
        return m

"""Cluster watch: the watchdogs of clusters and of a load, and the faults that end in a reset."""

from amaranth.hdl import Array, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.data import ArrayLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.control_formats import ControlFormats
from hw.control.job_formats import JobFormats
from hw.noc.network_fault import NetworkFault
from hw.registers.error_code import NETWORK, ErrorCode

__all__ = ["ClusterWatch"]

_COUNT_BITS = 32


class ClusterWatch(wiring.Component):
    """Looks at one node per cycle: at its cluster, if it has one, and at its network interface.

    A cluster is late when its oldest section has been the oldest for ``watchdog`` cycles, counted in steps of ``nodes``
    up to the last number; a load when it has been read for so many. A fault of a cluster is a time-out of its memory
    path. Of several in one cycle the first of these is the culprit: a late cluster, a late load, a fault of a cluster,
    one of a node's network interface.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    live, stops : In(1)
        Sections are being cast; all units are in reset.
    waits, restarts : In(clusters)
        `SectionTable`'s.
    reads : In(1)
        A load is being read.
    watchdog : In(32)
        The register; 0: none is late.
    clusters : In(ArrayLayout(ControlFormats.fault, clusters))
        Faults of the clusters; only time-outs have an effect.
    networks : In(ArrayLayout(NetworkFault, nodes))
        Faults of the nodes' network interfaces.
    culprit : Out(JobFormats.culprit)
        What is wrong, with the code `ErrorCode.NONE` if nothing is.

    Timing
    ------
    Latency: ``1`` cycle, and up to ``nodes - 1`` until a node is polled.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._nodes, self._clusters, control = config.noc.nodes, config.noc.clusters, ControlFormats(config)
        super().__init__({
            "live": In(1), "stops": In(1), "waits": In(self._clusters),
            "restarts": In(self._clusters), "reads": In(1),
            "watchdog": In(_COUNT_BITS), "clusters": In(ArrayLayout(control.fault, self._clusters)),
            "networks": In(ArrayLayout(NetworkFault, self._nodes)), "culprit": Out(JobFormats(config).culprit)})

    def elaborate(self, platform):
        m, nodes = Module(), self._nodes
        number, previous, restarts = Signal(range(nodes)), Signal(range(nodes)), Signal(
            self._clusters, init=(1 << self._clusters) - 1)
        m.d.sync += [number.eq(Mux(number == nodes - 1, 0, number + 1)), previous.eq(number),
                     restarts.eq((restarts & ~(1 << number)) | self.restarts)]
        m.submodules.ages = ages = Memory(shape=_COUNT_BITS, depth=max(2, nodes), init=[],
                                          attrs={"ram_style": "distributed"})
        read, write, counts, limit = ages.read_port(domain="comb"), ages.write_port(), Signal(), self.watchdog
        age = read.data + nodes
        m.d.comb += [
            counts.eq(self.live & self.waits.bit_select(number, 1) & ~restarts.bit_select(number, 1)),
            read.addr.eq(number), write.addr.eq(number), write.en.eq(1),
            write.data.eq(Mux(counts, Mux(age[_COUNT_BITS], -1, age), 0))]
        late, load_late, load_age = Signal(), Signal(), Signal(_COUNT_BITS)
        m.d.sync += [late.eq(counts & (limit != 0) & (read.data >= limit)),
                     load_late.eq(self.reads & (limit != 0) & (load_age >= limit)),
                     load_age.eq(Mux(self.reads, load_age + 1, 0))]
        fault, polled, network = Signal.like(self.clusters[0]), Signal.like(self.clusters[0]), Signal(NetworkFault)
        m.d.comb += polled.eq(Array(self.clusters[k].as_value() if k < self._clusters else 0
                                    for k in range(nodes))[number])
        m.d.sync += [fault.as_value().eq(Mux(polled.code == ErrorCode.PATH_TIMEOUT, polled, 0)),
                     network.eq(Array(self.networks[k].as_value() for k in range(nodes))[number])]
        with m.If(self.stops):
            m.d.sync += [fault.as_value().eq(0), network.eq(NetworkFault.NONE)]

        culprit = self.culprit
        with m.If(late):
            m.d.comb += [culprit.code.eq(ErrorCode.WATCHDOG), culprit.cluster.eq(previous)]
        with m.Elif(load_late):
            m.d.comb += [culprit.code.eq(ErrorCode.WATCHDOG), culprit.is_load.eq(1)]
        with m.Elif(fault.code != ErrorCode.NONE):
            m.d.comb += [culprit.code.eq(fault.code), culprit.number.eq(fault.number), culprit.cluster.eq(previous),
                         culprit.newest.eq(1)]
        with m.Elif(network != NetworkFault.NONE):
            m.d.comb += [culprit.code.eq(network.as_value() + NETWORK), culprit.cluster.eq(previous),
                         culprit.newest.eq(1)]
        return m

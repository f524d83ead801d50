"""Section table: the sections in flight, cluster by cluster."""

from amaranth.hdl import Array, Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.job_formats import JobFormats
from hw.lib.checks import count_steps

__all__ = ["SectionTable"]


class SectionTable(wiring.Component):
    """How many sections each cluster has, how many of them have begun, and the tags of their descriptors.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    live : In(1)
        Sections are sent, begin and end; else they are only aborted.
    i_sent : In, stream of `JobFormats.sent`
        A section is sent to a cluster. Always ready.
    begins : In(clusters)
        A cluster begins the next one of its sections.
    i_collected : In, stream of a cluster
        Its oldest section is over. Always ready.
    cluster : In(range(clusters + 1))
        The cluster that the next members concern; ``clusters`` has no sections.
    aborts : In(1)
        Its oldest section ends.
    tag : Out(32)
        Of its oldest section.
    count, begun : Out(JobFormats.in_flight)
        Its sections, and how many of them have begun.
    waits : Out(clusters)
        Clusters that have sections.
    restarts : Out(clusters)
        Clusters whose oldest section is another one from now on.

    Timing
    ------
    Latency: ``1`` cycle. At most 3 sections of a cluster.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._clusters, formats = config.noc.clusters, JobFormats(config)
        self._index_bits = formats.in_flight.width

        def event(layout):
            return In(stream.Signature(layout, always_ready=True))

        super().__init__({
            "live": In(1), "i_sent": event(formats.sent), "begins": In(self._clusters),
            "i_collected": event(formats.cluster), "cluster": In(range(self._clusters + 1)), "aborts": In(1),
            "tag": Out(32), "count": Out(formats.in_flight), "begun": Out(formats.in_flight),
            "waits": Out(self._clusters), "restarts": Out(self._clusters)})

    def elaborate(self, platform):
        m, clusters = Module(), self._clusters
        m.submodules.tags = tags = Memory(shape=32, depth=clusters << self._index_bits, init=[],
                                          attrs={"ram_style": "distributed"})
        counts, begun, oldest = ([Signal(self._index_bits, name=f"{name}_{k}") for k in range(clusters)]
                                 for name in ("count", "begun", "oldest"))
        write, read, sent = tags.write_port(), tags.read_port(domain="comb"), self.i_sent.payload
        newest = Array(head + count for head, count in zip(oldest, counts, strict=True))
        m.d.comb += [
            read.addr.eq(Cat(Array(oldest)[self.cluster], self.cluster)), self.tag.eq(read.data),
            write.en.eq(self.i_sent.valid & self.live), write.data.eq(sent.tag),
            write.addr.eq(Cat(newest[sent.cluster][:self._index_bits], sent.cluster)),
            self.count.eq(Array([*counts, 0])[self.cluster]), self.begun.eq(Array([*begun, 0])[self.cluster])]
        for k in range(clusters):
            pushes, pops, aborts = Signal(name=f"pushes_{k}"), Signal(name=f"pops_{k}"), Signal(name=f"aborts_{k}")
            m.d.comb += [
                pushes.eq(write.en & (sent.cluster == k)), aborts.eq(self.aborts & (self.cluster == k)),
                pops.eq(aborts | (self.i_collected.valid & self.live & (self.i_collected.payload == k))),
                self.waits[k].eq(counts[k] != 0),
                self.restarts[k].eq((pushes & (counts[k] == 0)) | (pops & ~aborts))]
            begins, ends = self.begins[k] & self.live, pops & (begun[k] != 0)
            most = (1 << self._index_bits) - 1
            count_steps(m, counts[k], up=pushes, down=pops, most=most)
            m.d.sync += oldest[k].eq(oldest[k] + pops)
            count_steps(m, begun[k], up=begins, down=ends, most=most)
        return m

"""Job dispatch: each descriptor to a cluster that requests a section, or to the engine's control."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.completion import NO_CLUSTER
from golden.engine.jobs.descriptor import ANY_CLUSTER
from hw.control.descriptor_check import DescriptorCheck
from hw.control.job_formats import NEAR_INDEX, JobFormats, Kind, byte_of, elements
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.longest_waiting import LongestWaiting
from hw.registers.error_code import ErrorCode

__all__ = ["JobDispatch"]


class JobDispatch(wiring.Component):
    """Sends each section to the cluster whose request has waited longest, or to the one that its descriptor names.

    A descriptor is checked while its words are sent: the last one says whether they are ``void``, and the cluster is
    then offered the next section. A descriptor that needs no cluster is read to its end: a load, one with a wrong first
    word, and any before a load. A refused one of them gets a completion record: `ErrorCode.DESCRIPTOR` or ``SECTION``
    with the first byte of the field, ``READ_REPLY`` with the address of its near cells, or ``NOT_LOADED``: with 0 if no
    tables have been loaded, with the byte of ``last_shell`` if there are no grid rays for it.

    A descriptor that could not be read itself ends the dispatch, until a reset.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `JobFormats.fetched`
        `DescriptorFetch`'s ``o``.
    enable : In(1)
        The next descriptor may begin.
    loaded : In(1)
        All tables have been loaded. Stable while ``busy``.
    last_shell : In(CtuFormats.shell)
        The last shell of which they have grid rays. Likewise.
    requests : In(clusters)
        A request of the cluster for one more section, for one cycle each.
    o : Out, stream of `JobFormats.word`
        Words for the clusters. Always ready.
    o_sent : Out, stream of `JobFormats.sent`
        A section is the cluster's, together with its last word. Always ready.
    o_load : Out, stream of `JobFormats.load_job`
        Loads; accepted when they begin.
    o_refused : Out, stream of `JobFormats.record`
        Completion records of refused descriptors.
    failed : Out(1)
        The next descriptor could not be read.
    busy : Out(1)
        A section is being sent or checked, or a refusal waits.

    Timing
    ------
    Latency: ``2`` cycles from a first word, and a request for it, to its first word at ``o``. A section takes 26
    cycles and one for each word of near cells; stalls with ``i``.

    Golden counterpart: `golden.engine.jobs.descriptor.check_descriptor`.
    """

    latency = 2

    def __init__(self, *, config: Config):
        self._config, formats = config, JobFormats(config)
        super().__init__({
            "i": In(stream.Signature(formats.fetched)), "enable": In(1), "loaded": In(1),
            "last_shell": In(CtuFormats(config).shell), "requests": In(config.noc.clusters),
            "o": Out(stream.Signature(formats.word, always_ready=True)),
            "o_sent": Out(stream.Signature(formats.sent, always_ready=True)),
            "o_load": Out(stream.Signature(formats.load_job)), "o_refused": Out(stream.Signature(formats.record)),
            "failed": Out(1), "busy": Out(1)})

    def elaborate(self, platform):
        m = Module()
        clusters, word = self._config.noc.clusters, self.i.payload
        m.submodules.check = check = DescriptorCheck(config=self._config)
        m.submodules.longest = longest = LongestWaiting(count=clusters)

        # Which cluster: what the first word says is in front of the queue until it is granted.
        def first(name):
            (_, bits), = elements(name)
            return word.data[bits]

        pending, granted, sends = Signal(clusters), Signal(clusters), Signal()
        begins, returns, any_one, alone = (Signal(name=name) for name in ("begins", "returns", "any_one", "alone"))
        pinned = first("cluster")
        known = Signal()
        m.d.comb += [
            any_one.eq(pinned == ANY_CLUSTER), known.eq(any_one | (pinned < clusters)),
            alone.eq(word.error | ~known | ~self.loaded | (first("kind") != Kind.FRUSTUM)),
            longest.request.eq(pending),
            *(longest.eligible[k].eq(pending[k] & (any_one | (pinned == k))) for k in range(clusters)),
            longest.accept.eq(begins & ~alone)]
        m.d.sync += pending.eq((pending & ~Mux(longest.accept, longest.grant, 0)) | self.requests
                               | Mux(returns, granted, 0))

        # Numbers of the descriptor that its end needs.
        numbers = {name: Signal(bits.stop - bits.start, name=name) for name in (
            "cluster", "tag", "regions", "hits", "near_cells") for (_, bits), in [elements(name)]}
        is_load, unread, near_unread, unloaded, beyond = (
            Signal(name=name) for name in ("is_load", "unread", "near_unread", "unloaded", "beyond"))
        (shell_index, shell_bits), = elements("last_shell")
        takes, is_near = Signal(), Signal()
        m.d.comb += [takes.eq(self.i.valid & self.i.ready), is_near.eq(word.index == NEAR_INDEX),
                     check.i.valid.eq(takes & ~is_near), check.i.payload.index.eq(word.index),
                     check.i.payload.data.eq(word.data)]
        with m.If(takes):
            for name, number in numbers.items():
                (word_index, bits), = elements(name)
                with m.If(word.index == word_index):
                    m.d.sync += number.eq(word.data[bits])
            m.d.sync += [unread.eq(unread | (word.error & ~is_near)),
                         near_unread.eq(near_unread | (word.error & is_near))]
            with m.If(word.index == shell_index):
                m.d.sync += beyond.eq(word.data[shell_bits] > self.last_shell)

        # A word is kept until the next one has come, the last one until its refusal is known.
        kept, sent = Signal.like(word), Signal()
        refusal, good = check.refusal, Signal()
        m.d.comb += [
            good.eq((refusal.code == ErrorCode.NONE) & ~near_unread & ~unread & (is_load | ~beyond)),
            self.o.valid.eq(sent), self.o.payload.index.eq(kept.index), self.o.payload.data.eq(kept.data),
            self.o.payload.last.eq(kept.last), self.o.payload.void.eq(kept.last & ~good),
            self.o_sent.payload.tag.eq(numbers["tag"]), self.o_load.payload.tag.eq(numbers["tag"]),
            self.o_load.payload.image.eq(numbers["hits"]), self.o_load.payload.regions.eq(numbers["regions"]),
            self.o_load.payload.copies.eq(numbers["cluster"] == 0)]
        number = Signal(range(clusters))
        m.d.comb += [self.o.payload.cluster.eq(number), self.o_sent.payload.cluster.eq(number)]
        for k in range(clusters):
            with m.If(granted[k]):
                m.d.comb += number.eq(k)
        with m.If(takes):
            m.d.sync += kept.eq(word)
        self._add_record(m, refusal, near_unread, unloaded, numbers)
        m.d.comb += self.busy.eq(1)
        with m.FSM():
            with m.State("Begin"):
                m.d.comb += [self.busy.eq(0), begins.eq(self.i.valid & self.enable
                                                        & (alone | longest.eligible.any()))]
                m.d.sync += [unread.eq(0), near_unread.eq(0), unloaded.eq(~self.loaded),
                             is_load.eq(first("kind") == Kind.LOAD), sends.eq(~alone), granted.eq(longest.grant)]
                with m.If(begins):
                    m.next = "Words"
            with m.State("Words"):
                m.d.comb += [self.i.ready.eq(1), sent.eq(sends & takes & (word.index != 0))]
                with m.If(takes & word.last):
                    m.next = "End"
            with m.State("End"), m.If(check.known | unread):
                m.d.comb += sent.eq(sends)
                m.next = "Begin"
                with m.If(unread):
                    m.d.comb += returns.eq(sends)
                    m.next = "Failed"
                with m.Elif(~good | (unloaded & ~is_load)):
                    m.d.comb += returns.eq(sends)
                    m.next = "Refuse"
                with m.Elif(is_load):
                    m.next = "Load"
                with m.Else():
                    m.d.comb += self.o_sent.valid.eq(1)
            with m.State("Refuse"):
                m.d.comb += self.o_refused.valid.eq(1)
                with m.If(self.o_refused.ready):
                    m.next = "Begin"
            with m.State("Load"):
                m.d.comb += [self.o_load.valid.eq(1), self.busy.eq(0)]
                with m.If(self.o_load.ready):
                    m.next = "Begin"
            with m.State("Failed"):
                m.d.comb += [self.failed.eq(1), self.busy.eq(0)]
        return m

    def _add_record(self, m, refusal, near_unread, unloaded, numbers):
        """The completion record of a refused descriptor."""
        record = self.o_refused.payload
        m.d.comb += [record.tag.eq(numbers["tag"]), record.cluster.eq(NO_CLUSTER), record.code.eq(refusal.code),
                     record.number.eq(refusal.number)]
        with m.If(refusal.code == ErrorCode.NONE):
            m.d.comb += [record.code.eq(ErrorCode.NOT_LOADED),
                         record.number.eq(Mux(unloaded, 0, byte_of("last_shell")))]
            with m.If(near_unread):
                m.d.comb += [record.code.eq(ErrorCode.READ_REPLY), record.number.eq(numbers["near_cells"])]

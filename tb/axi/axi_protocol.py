"""The rules of AXI4 at the machine's port of main memory."""

from types import SimpleNamespace

from golden.engine.config import Config
from hw.memsys.port.axi_signature import AxiSignature
from hw.memsys.port.memory_formats import MemoryFormats
from tb.axi.channels import Operators, channel_rules, channel_state, no

__all__ = ["AxiProtocol"]

INCR, BUFFERABLE, EXOKAY, PAGE = 1, 3, 1, 4096
_ADDRESS = ("id", "addr", "len", "size", "burst", "cache", "prot")
_CHANNELS = {"aw": tuple(f"aw{name}" for name in _ADDRESS), "w": ("wdata", "wstrb", "wlast"), "b": ("bid", "bresp"),
             "ar": tuple(f"ar{name}" for name in _ADDRESS), "r": ("rid", "rdata", "rresp", "rlast")}
_OFFER, _BURST = ("stable", "reset"), ("burst", "size", "cache", "length", "page", "id", "count")
_MANAGER = tuple(f"{channel}_{rule}" for channel, rules in (
    ("aw", _OFFER + _BURST), ("w", (*_OFFER, "announced", "last")), ("ar", _OFFER + _BURST)) for rule in rules)
_SUBORDINATE = tuple(f"{channel}_{rule}" for channel, rules in (
    ("b", (*_OFFER, "id", "due", "resp")), ("r", (*_OFFER, "id", "last", "resp"))) for rule in rules)


class AxiProtocol:
    """Rules by name, stated once for `ProtocolChecker` and for `ProtocolMonitor`.

    ============================  =====================================================================================
    ``*_stable``, ``*_reset``     an offer stays unchanged until accepted or a reset; none in the cycles after one
    ``*_burst``, ``*_size``       type INCR; full beats at a multiple of a beat
    ``*_cache``                   normal memory, non-cacheable and bufferable
    ``*_length``, ``*_page``      at most ``burst_beats`` beats; no beat past a multiple of 4 KiB
    ``aw_id``, ``aw_count``       writes have id 0; at most ``outstanding`` have not been answered
    ``ar_id``, ``ar_count``       the id of a read is no outstanding read's; at most ``outstanding`` are outstanding
    ``w_announced``, ``w_last``   beats of bursts that have been offered; the last beat of each is marked, and no other
    ``b_id``, ``b_due``           id 0; one answer for each burst of which address and data have been accepted
    ``r_id``, ``r_last``          of an outstanding read; its last beat is marked, and no other
    ``b_resp``, ``r_resp``        never EXOKAY: no access is exclusive
    ============================  =====================================================================================

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    pins
        Widths by name.
    state
        What is remembered, by name: widths and initial values.
    manager, subordinate
        Rules of either side.
    """

    def __init__(self, config: Config):
        memory, formats = config.memory, MemoryFormats(config)
        self._memory, self._low = memory, formats.low_bits
        self.pins = {name: member.shape for name, member in AxiSignature(config=config).members.items()}
        ids, count = 1 << formats.slot_bits, memory.outstanding.bit_length()
        self.state = channel_state(self.pins, _CHANNELS) | {
            # Bursts that have been offered: lengths of those whose data have not all been accepted; the number of
            # these, of those whose data have, and of all that have not been answered.
            "lengths": [(8, 0)] * memory.outstanding, "announced": [(count, 0)], "due": [(count, 0)],
            "writes": [(count, 0)],
            # Beats of the present one that have been accepted.
            "beat": [(8, 0)],
            # By id: the read is outstanding, beats after the next one. Outstanding reads.
            "active": [(1, 0)] * ids, "left": [(8, 0)] * ids, "reads": [(count, 0)]}
        self.manager, self.subordinate = _MANAGER, _SUBORDINATE

    def step(self, pins: SimpleNamespace, state: dict, use: Operators) -> tuple[dict, dict]:
        """Violations in a cycle, and the next state if the pin ``reset`` is 0."""
        violated, following = channel_rules(pins, state, _CHANNELS)
        for part in (self._addresses, self._writes, self._reads):
            more, after = part(pins, state, use)
            violated |= more
            following |= after
        return violated, following

    def _addresses(self, pins, state, use):
        violated = {}
        for name in ("aw", "ar"):
            valid, address, length, size, burst, cache = (
                getattr(pins, f"{name}{what}") for what in ("valid", "addr", "len", "size", "burst", "cache"))
            low = self._low
            violated |= {
                f"{name}_burst": valid & (burst != INCR), f"{name}_cache": valid & (cache != BUFFERABLE),
                f"{name}_size": valid & ((size != low) | ((address & (1 << low) - 1) != 0)),
                f"{name}_length": valid & (length >= self._memory.burst_beats),
                f"{name}_page": valid & ((address & PAGE - (1 << low)) + (length << low) >= PAGE)}
        return violated, {}

    def _writes(self, pins, state, use):
        lengths, most = state["lengths"], self._memory.outstanding
        (level,), (due,), (writes,), (beat,), (waited,), (fresh,) = (
            state[name] for name in ("announced", "due", "writes", "beat", "aw_waited", "fresh"))
        new = pins.awvalid & no(waited)
        offers = new & (writes != most)
        known = offers | (level != 0)
        length = use.mux(level != 0, lengths[0], pins.awlen)
        ends = beat == length
        moves = pins.wvalid & pins.wready & known
        pops = moves & ends
        # The address of the newest burst may be accepted after its data.
        answerable = due > (waited & (level == 0))
        answers = pins.bvalid & pins.bready & (pins.bid == 0) & answerable
        pushed = [use.mux(offers & (level == k), pins.awlen, one) for k, one in enumerate(lengths)]
        return {
            "aw_id": pins.awvalid & (pins.awid != 0), "aw_count": new & (writes == most),
            "w_announced": pins.wvalid & no(known | fresh), "w_last": pins.wvalid & known & (pins.wlast != ends),
            "b_id": pins.bvalid & (pins.bid != 0), "b_due": pins.bvalid & (pins.bid == 0) & no(answerable | fresh),
            "b_resp": pins.bvalid & (pins.bresp == EXOKAY),
        }, {
            "lengths": [use.mux(pops, later, one) for one, later in zip(pushed, [*pushed[1:], 0], strict=True)],
            "announced": [level + offers - pops], "due": [due + pops - answers], "writes": [writes + offers - answers],
            "beat": [use.mux(moves, use.mux(ends, 0, beat + 1), beat)]}

    def _reads(self, pins, state, use):
        active, left, (reads,), (fresh,) = (state[name] for name in ("active", "left", "reads", "fresh"))
        most = self._memory.outstanding
        known, rest = use.select(active, pins.rid), use.select(left, pins.rid)
        used = use.select(active, pins.arid)
        enters = pins.arvalid & pins.arready & no(used) & (reads != most)
        moves = pins.rvalid & pins.rready & known
        leaves = moves & pins.rlast
        enters_at = [enters & (pins.arid == k) for k in range(len(active))]
        moves_at = [moves & (pins.rid == k) for k in range(len(active))]
        return {
            "ar_id": pins.arvalid & used, "ar_count": pins.arvalid & (reads == most),
            "r_id": pins.rvalid & no(known | fresh), "r_last": pins.rvalid & known & (pins.rlast != (rest == 0)),
            "r_resp": pins.rvalid & (pins.rresp == EXOKAY),
        }, {
            "active": [use.mux(enter, 1, use.mux(move & pins.rlast, 0, one))
                       for enter, move, one in zip(enters_at, moves_at, active, strict=True)],
            "left": [use.mux(enter, pins.arlen, use.mux(move & (one != 0), one - 1, one))
                     for enter, move, one in zip(enters_at, moves_at, left, strict=True)],
            "reads": [reads + enters - leaves]}

"""The rules of AXI4-Lite at the machine's registers."""

from types import SimpleNamespace

from hw.registers.axi_lite_signature import AxiLiteSignature
from tb.axi.channels import Operators, channel_rules, channel_state, no

__all__ = ["AxiLiteProtocol"]

EXOKAY = 1
# Most outstanding accesses of a kind: one whose answer is offered, and the next one.
MOST = 2
_CHANNELS = {"aw": ("awaddr", "awprot"), "w": ("wdata", "wstrb"), "b": ("bresp",), "ar": ("araddr", "arprot"),
             "r": ("rdata", "rresp")}
_MANAGER = tuple(f"{channel}_{rule}" for channel in ("aw", "w", "ar") for rule in ("stable", "reset"))


class AxiLiteProtocol:
    """Rules by name, stated once for `ProtocolChecker` and for `ProtocolMonitor`.

    =================================  ================================================================================
    ``*_stable``, ``*_reset``          an offer stays unchanged until accepted or a reset; none in the cycles after one
    ``aw_count, w_count, ar_count``    the subordinate accepts at most two accesses that it has not answered
    ``b_due``                          one answer for each address and data of a write
    ``r_due``                          one answer for each address of a read
    ``b_resp``, ``r_resp``             never EXOKAY
    =================================  ================================================================================

    Parameters
    ----------
    address_bits
        Of the port.

    Members
    -------
    pins, state, manager, subordinate
        As of `tb.axi.axi_protocol.AxiProtocol`.
    """

    def __init__(self, address_bits: int):
        self.pins = {name: member.shape for name, member in AxiLiteSignature(address_bits=address_bits).members.items()}
        self.state = channel_state(self.pins, _CHANNELS) | {
            name: [(MOST.bit_length(), 0)] for name in ("addresses", "data", "reads")}
        self.manager = _MANAGER
        self.subordinate = ("b_stable", "b_reset", "r_stable", "r_reset", "aw_count", "w_count", "ar_count", "b_due",
                            "r_due", "b_resp", "r_resp")

    def step(self, pins: SimpleNamespace, state: dict, use: Operators) -> tuple[dict, dict]:
        """Violations in a cycle, and the next state if the pin ``reset`` is 0."""
        violated, following = channel_rules(pins, state, _CHANNELS)
        written, read = (state["addresses"][0] != 0) & (state["data"][0] != 0), state["reads"][0] != 0
        answers = {"b": pins.bvalid & pins.bready & written, "r": pins.rvalid & pins.rready & read}
        for channel, name, answer in ("aw", "addresses", "b"), ("w", "data", "b"), ("ar", "reads", "r"):
            (count,) = state[name]
            comes = getattr(pins, f"{channel}valid") & getattr(pins, f"{channel}ready")
            violated[f"{channel}_count"] = comes & (count == MOST)
            following[name] = [count + (comes & (count != MOST)) - answers[answer]]
        (fresh,) = state["fresh"]
        violated |= {"b_due": pins.bvalid & no(written | fresh), "r_due": pins.rvalid & no(read | fresh),
                     "b_resp": pins.bvalid & (pins.bresp == EXOKAY), "r_resp": pins.rvalid & (pins.rresp == EXOKAY)}
        return violated, following

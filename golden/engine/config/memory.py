"""Parameters of the main memory port."""

from dataclasses import dataclass

from golden.engine.config.checks import check_power_of_two, check_range

__all__ = ["Memory"]

# A burst of AXI lies within one.
_PAGE = 4096


@dataclass(frozen=True, kw_only=True)
class Memory:
    """Parameters of the AXI4 port to main memory. The golden model reads none of them.

    Parameters
    ----------
    address_bits
        Bits of a byte address; 16 to 48. Hardware only.
    data_bits
        Bits of a beat; a power of two, 64 to 512. Hardware only.
    outstanding
        Outstanding bursts, of reads and of writes each; a power of two, 1 to 64. Hardware only.
    burst_beats
        Beats of the longest burst; a power of two, 2 to 256, and at most 4096 bytes. A read is issued when buffers for
        its whole burst are reserved. Hardware only.
    length_bits
        A request is for at most 2^b beats; 1 to 12. Hardware only.
    timeout_bits
        A transaction that memory does not complete in 2^b cycles ends with an error; 2 to 24. Hardware only.
    """

    address_bits: int = 40
    data_bits: int = 64
    outstanding: int = 16
    burst_beats: int = 16
    length_bits: int = 8
    timeout_bits: int = 12

    def __post_init__(self):
        check_power_of_two("memory", "data_bits", self.data_bits, 64, 512)
        check_power_of_two("memory", "outstanding", self.outstanding, 1, 64)
        check_power_of_two("memory", "burst_beats", self.burst_beats, 2, min(256, _PAGE // self.beat_bytes))
        for name, low, high in (("address_bits", 16, 48), ("length_bits", 1, 12), ("timeout_bits", 2, 24)):
            check_range("memory", name, getattr(self, name), low, high)

    @property
    def beat_bytes(self) -> int:
        """Bytes of a beat."""
        return self.data_bits // 8

"""How many rays of a picture are cast at once."""

from dataclasses import dataclass

__all__ = ["MEGABYTES", "InFlight"]

MEGABYTES = 64, 1 << 20
"""Least and most memory, in megabytes, that rays in flight can be given."""
# Bytes of a primary ray with what follows from it, and of a shadow ray or one that gathers. Each kind has half of the
# memory.
PRIMARY_BYTES, SHADOW_BYTES = 2048, 512


@dataclass(frozen=True, kw_only=True)
class InFlight:
    """How many rays are cast at once.

    Parameters
    ----------
    primary
        Primary rays whose successors are cast generation by generation.
    generation
        Rays of a generation beyond which its parts go on one after the other.
    shadow
        Shadow rays, or pairs of a point and a light.
    gather
        Rays that gather light.
    """

    primary: int = 1 << 16
    generation: int = 1 << 62
    shadow: int = 1 << 18
    gather: int = 1 << 17

    @classmethod
    def of(cls, memory: int | None, *, shares: bool, threads: int = 1) -> "InFlight":
        """Those of a picture.

        Parameters
        ----------
        memory
            Megabytes that they may take, or None.
        shares
            Whether shadow rays are cast as frusta, which many must share.
        threads
            So many cast, each its own rays.
        """
        if memory is not None:
            half = (memory << 19) // threads
            primary, other = max(1, half // PRIMARY_BYTES), max(1, half // SHADOW_BYTES)
            return cls(primary=primary, generation=primary, shadow=other, gather=other)
        return cls(primary=1 << 18, shadow=1 << 23, gather=1 << 19) if shares else cls()

"""Load cycles: those of the load of an image."""

from dataclasses import dataclass

from golden.engine.memory_map.image import MemoryImage
from golden.engine.memory_map.layout import ENTRY, HEADER, REGIONS
from radiosity.machines.common.timing_numbers import PositiveNumbers

__all__ = ["LoadTiming", "load_cycles"]

_WORD = 8
# Regions of which each cluster has a part of its own.
_OWN = ("clusters", "subshells", "residents", "patches")


@dataclass(frozen=True, kw_only=True)
class LoadTiming(PositiveNumbers):
    """Numbers of a load, in cycles unless stated otherwise.

    `radiosity.machines.engine.job_latencies.load_timing` takes them from the components of a configuration.

    Parameters
    ----------
    trip
        From the choice of a region to its first word, without the rest of the burst that the word is in.
    check
        Of a region when the header has been read, without the bits of its records' size.
    extents
        From the choice of patches to their first word, without the rest of the burst.
    patch_words, group
        Words of a patch; patches whose ids are read at once.
    burst
        Bytes of a burst, at whose multiples bursts end.
    end
        From the last word to the end of the load, as its completion record has it.

    Raises
    ------
    TypeError, ValueError
        See `PositiveNumbers`.
    """

    trip: int
    check: int
    extents: int
    patch_words: int
    group: int
    burst: int
    end: int


def load_cycles(image: MemoryImage, timing: LoadTiming) -> int:
    """The cycles of a load of all regions: once for all clusters, or what they share once and each its own.

    The header is read and checked. Then each region takes a round trip and a cycle a word: bursts are read ahead, the
    first one arrives whole. Ids of patches are words of a region too; a group of them takes a second round trip for the
    patches.

    Parameters
    ----------
    image
        The image.
    timing
        Latencies.
    """
    shared = _header(timing) + sum(_records(image, region, 0, len(image[region.name]), timing) for region in REGIONS
                                   if region.name not in _OWN)
    clusters = image["clusters"]
    # With copies one pass reads all of it.
    own = [_own(image, cluster, timing) for cluster in (range(1) if image.has_copies else range(len(clusters)))]
    return shared + sum(own) + (0 if image.has_copies else len(clusters) * _header(timing)) + timing.end


def _header(timing):
    size = HEADER.dtype.itemsize + len(REGIONS) * ENTRY.dtype.itemsize
    return _words(0, size, size // _WORD, timing) + sum(
        timing.check + region.dtype.itemsize.bit_length() for region in REGIONS)


def _own(image, cluster, timing):
    """What one cluster alone gets."""
    record = image["clusters"][cluster]
    by_name = {region.name: region for region in REGIONS}
    cycles = _records(image, by_name["clusters"], cluster, 1, timing)
    cycles += _records(image, by_name["subshells"], int(record["first_subshell"]), int(record["subshells"]), timing)
    first, count = int(record["first_resident"]), int(record["residents"])
    for done in range(0, count, timing.group):
        ids = min(timing.group, count - done)
        cycles += _records(image, by_name["residents"], first + done, ids, timing)
        cycles += timing.extents + timing.patch_words * (ids + 1)
    return cycles


def _records(image, region, first, count, timing):
    """Some records of a region."""
    size = region.dtype.itemsize
    if not count:
        return 0
    return _words(image.offsets[region.name] + first * size, count * size, count * -(-size // _WORD), timing)


def _words(address, size, words, timing):
    """Consecutive words: none leaves before the burst that it is in has arrived."""
    first = min(size, timing.burst - address % timing.burst)
    return timing.trip + first // _WORD + words

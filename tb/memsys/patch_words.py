"""Patches as the words in which they are loaded."""

from golden.engine.memory_map import COORDINATE_BITS

__all__ = ["load_of", "words_of"]


def words_of(patch: int, surface: int, vertices) -> list[int]:
    """The first six words of a patch's record in a memory image."""
    packed = [sum(int(part) << COORDINATE_BITS * axis for axis, part in enumerate(vertex)) for vertex in vertices]
    return [patch | (surface & 0xFFFFFFFF) << 32, sum((value >> 64) << 8 * (k + 1) for k, value in enumerate(packed)),
            *(value & (1 << 64) - 1 for value in packed)]


def load_of(address: int, patch: int, surface: int, vertices) -> list[dict]:
    """`PathFormats.geometry_load` of a patch."""
    return [{"address": address, "word": number, "record": word}
            for number, word in enumerate(words_of(patch, surface, vertices))]

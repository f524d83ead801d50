"""What the parts of a patch store pass to each other."""

from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import WritePort

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.validate import check_power_of_two

__all__ = ["StoreFormats"]


class StoreFormats:
    """Layouts and shapes of `PatchStore` and its parts.

    Parameters
    ----------
    config
        The configuration.
    frames
        Patches that are kept, a power of two, at least 2.
    requests
        Requests in flight, a power of two, at least 2.

    Members
    -------
    version_bits
        Of the version of tags and presence bits: after 2^b - 1 emptyings both are swept.
    frame, number
        Shapes of a frame and of an entry.
    entry, entries
        Layouts of a request in flight, from its lookup until its last vertex has left, and of all of them.
    head
        Layout of what the I-structure keeps of a patch: its fetch has failed; its vertices are all 0.
    vertex
        Layout of a vertex in its frame.
    write
        Signature of the port that writes vertices.

    Raises
    ------
    TypeError
        A number is no integer.
    ValueError
        A number is no power of two, or too small.
    """

    version_bits = 4

    def __init__(self, *, config: Config, frames: int, requests: int):
        check_power_of_two("Frames", frames, minimum=2)
        check_power_of_two("Requests", requests, minimum=2)
        formats = Formats(config)
        self.frame, self.number = range(frames), range(requests)
        self.entry = StructLayout({"patch": formats.patch, "frame": self.frame, "is_stored": 1})
        self.entries = ArrayLayout(self.entry, requests)
        self.head = StructLayout({"is_lost": 1, "is_void": 1})
        self.vertex = StructLayout({"vertex": formats.scene_vector, "surface": formats.surface})
        self.write = WritePort.Signature(addr_width=(VERTICES * frames - 1).bit_length(), shape=self.vertex)

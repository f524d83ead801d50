"""Patch slots: what the rays need of the patches that are in flight."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.pipeline import Pipeline
from hw.lib.struct_stream import struct_stream

__all__ = ["PatchSlots"]


class PatchSlots(wiring.Component):
    """One `IcuFormats.slot_record` for each of ``icu.slots`` patches, written in parts, read whole.

    Each block writes its part when it is ready, at the latest when the patch's window is sent to the ray generator.
    `PatchQueue` ensures that no slot is written again before its last ray has read it.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data of a read from ``i`` to ``o``.

    Members
    -------
    i_planes, i_winding, i_factor, i_exponents, i_patch : In, streams of ``slot``, ``part``, always ready
        Parts of records.
    i : In, stream of ``tag``, ``slot``, always ready
        Reads.
    o : Out, stream of ``tag``, ``record``, always ready
        `IcuFormats.slot_record`.

    Timing
    ------
    Latency: ``2`` cycles from ``i`` to ``o``. A part can be read in the cycle after it was written. One read and one
    write of each part per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.patch_setup.Patches`.
    """

    def __init__(self, *, config: Config, tag):
        formats = IcuFormats(config)
        self._slots = config.icu.slots
        self._parts = {key: field.shape for key, field in formats.slot_record}

        super().__init__({
            **{f"i_{name}": In(struct_stream({"slot": formats.slot, "part": shape}))
               for name, shape in self._parts.items()},
            "i": In(struct_stream({"tag": tag, "slot": formats.slot})),
            "o": Out(struct_stream({"tag": tag, "record": formats.slot_record}))})
        # Block RAM for few but wide records: with LUTs the read address would have a high fan-out.
        self._memories = {name: Memory(shape=shape, depth=self._slots, init=[],
                                       attrs={"ram_style": "block", "no_rw_check": 1})
                          for name, shape in self._parts.items()}
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        slot = pipeline.input(self.i.payload.slot)
        for name, memory in self._memories.items():
            part = pipeline.delay(pipeline.read(memory.read_port(), slot), 1)
            pipeline.output(self.o.payload.record[name], part)
        pipeline.output(self.o.payload.tag, pipeline.input(self.i.payload.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        for name, memory in self._memories.items():
            m.submodules[name] = memory
            port, given = memory.write_port(), getattr(self, f"i_{name}")
            m.d.comb += [port.addr.eq(given.payload.slot), port.data.eq(given.payload.part), port.en.eq(given.valid)]
        self._pipeline.add_to(m)
        return m

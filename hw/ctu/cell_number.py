"""Cell number: of a cell's position in the grid."""

from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.pipeline import Pipeline

__all__ = ["CellNumber"]


class CellNumber(wiring.Component):
    """``(x shape_y + y) shape_z + z``; of no cell anything.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband.

    Members
    -------
    i : In, stream of ``tag``, ``index``
        The cell along each axis.
    o : Out, stream of ``tag``, ``cell``
        Its number.
    shape : In, array of 3
        Cells along each axis, at most 2^17 along x and y together; constant while cells are in flight.

    Timing
    ------
    Latency: ``2 * product_registers + 2`` cycles. One cell per cycle; stalls while the cell at the end waits.

    Golden counterpart: `golden.engine.memsys.patches.cell_table.CellTable.number`.
    """

    def __init__(self, *, config: Config, tag):
        formats = CtuFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "index": ArrayLayout(formats.grid_index, 3)}))),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "cell": formats.cell}))),
            "shape": In(ArrayLayout(formats.grid_count, 3))})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        bits = len(self.shape[0])
        x, y, z = (pipeline.combine(lambda value: value[:bits], pipeline.input(self.i.payload.index[axis]))
                   for axis in range(3))
        for axis, following in ((1, y), (2, z)):
            product = pipeline.product(x, pipeline.constant(self.shape[axis]),
                                       registers=config.icu.product_registers)
            x = pipeline.register(lambda product, following: (product + following)[:len(self.o.payload.cell)], product,
                                  following)
            if axis == 1:
                # An operand of a multiplier.
                x = pipeline.combine(lambda value: value[:17], x)
        pipeline.output(self.o.payload.cell, x)
        pipeline.output(self.o.payload.tag, pipeline.input(self.i.payload.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()

"""Ray memory and nearest update: the best hit of each ray."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.checks import claim, count_entries, count_steps
from hw.lib.generations import Generations
from hw.lib.queue import Queue
from hw.lib.struct_stream import struct_stream
from hw.lib.update_memory import UpdateMemory

__all__ = ["RayMemory"]

BANKS = 2


class RayMemory(wiring.Component):
    """Larger 1/t wins, equal 1/t goes to the smaller patch id; so the order of updates does not matter.

    A row is compared as one integer: 1/t above the complement of the id, and the tag of the generation. (u, v) are
    written later, on a win only. In a shadow frustum a ray that has not been listed is never hit, and any hit before
    its end settles it: it then has the largest 1/t of patch 0, with (u, v) of 0.

    Of two banks one belongs to the frustum that is cast; the other one, or the same when nothing is in flight, is read
    out.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data of an update.

    Members
    -------
    i_start : In, stream without payload
        Begins a frustum in the other bank, which is empty then. The sender ensures that no update is in flight and that
        the other bank is not being read.
    rays : In(range(rays + 1))
        The rays of the frustum that begins are below it. Initially all. Stable while ``i_start`` is valid.
    is_shadow : In(1)
        A shadow frustum begins. Stable while ``i_start`` is valid. Only with ``shadow_bits``.
    i : In, stream of ``tag``, ``ray``, ``inverse``, ``patch``, ``hit``, always ready
        Updates; ``hit``: the ray meets the patch. With ``shadow_bits`` also ``lists``: the ray of a shadow frustum
        begins to exist, and ends at ``inverse``.
    o : Out, stream of ``tag``, ``ray``, ``inverse``, ``won``, always ready
        Replies; ``won``: the ray had nothing nearer.
    i_payload : In, stream of ``ray``, ``u``, ``v``, always ready
        Of wins, in the order of the updates. Without bits of u and v (``uv_bits`` 0) it does not matter.
    active : Out(1)
        The bank of the frustum that is cast.
    i_read : In, stream of ``bank``, ``ray``
        Reads of a bank without updates.
    o_read : Out, stream of `IcuFormats.hit`
        The replies, in order.

    Timing
    ------
    Latency: ``5`` cycles from ``i`` to ``o``, ``7`` from ``i_read`` to ``o_read``. One update and one read per cycle;
    updates never stall. A frustum begins ``1`` cycle after ``i_start``. The banks are swept after reset, and every
    2^``generation_bits`` - 1 frusta of a bank: then it begins when the rows below ``rays`` have been swept, one per
    cycle; the sweep of the others goes on in cycles without an update or a read. After reset the first bank is swept at
    once, and the other one when the first frustum has begun.

    Golden counterpart: `golden.engine.icu.ray_memory.RayMemory`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats, self._tag = config, IcuFormats(config), tag
        formats = self._formats

        self._shadow = config.icu.shadow_bits > 0
        lists = {"lists": 1} if self._shadow else {}
        super().__init__({
            "i_start": In(stream.Signature(0)),
            "rays": In(range(config.icu.rays + 1), init=config.icu.rays), **({"is_shadow": In(1)} if lists else {}),
            "i": In(struct_stream({"tag": tag, "ray": formats.ray, "inverse": formats.inverse, "patch": formats.patch,
                           "hit": 1, **lists})),
            "o": Out(struct_stream({"tag": tag, "ray": formats.ray, "inverse": formats.inverse, "won": 1})),
            "i_payload": In(struct_stream({"ray": formats.ray, "u": formats.uv, "v": formats.uv})),
            "active": Out(1),
            "i_read": In(stream.Signature(StructLayout({"bank": 1, "ray": formats.ray}))),
            "o_read": Out(stream.Signature(formats.hit))})
        self.latency = 5

    def elaborate(self, platform):
        m = Module()
        formats, icu = self._formats, self._config.icu
        row = StructLayout({"complement": formats.patch, "inverse": formats.inverse, "generation": icu.generation_bits})
        operand = StructLayout({"row": row, "hit": 1, "clear": 1, **({"settles": 1} if self._shadow else {})})

        def change(_, old, operand):
            """The row after an update: of the larger key, as one integer."""
            new_key = Cat(operand.row.complement, operand.row.inverse)
            old_key = Cat(old.complement, old.inverse)
            is_new, is_larger = old.generation != operand.row.generation, new_key > old_key
            if not self._shadow:
                return operand.row, operand.clear | (operand.hit & (is_new | is_larger))
            nearer = Mux(is_new, ~operand.settles, is_larger)
            settled = operand.row.inverse | operand.settles.replicate(len(operand.row.inverse))
            return Cat(operand.row.complement, settled, operand.row.generation), \
                operand.clear | (operand.hit & nearer)

        # Each outstanding read has an entry of the queue reserved: none is free when the highest bit
        # of their number is 1.
        capacity = 16
        m.submodules.found = found = Queue(formats.hit, depth=capacity)
        outstanding, accepts = Signal(range(capacity + 1)), Signal()
        wiring.connect(m, found.o, wiring.flipped(self.o_read))
        m.d.comb += [self.i_read.ready.eq(~outstanding[-1]), accepts.eq(self.i_read.valid & self.i_read.ready)]
        returns = found.o.valid & found.o.ready
        count_entries(outstanding)
        count_steps(m, outstanding, up=accepts, down=returns, most=capacity)
        claim(m, ~found.i.valid | found.i.ready, "a hit has an entry")

        m.d.comb += self.i_start.ready.eq(0)
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += self.active.eq(~self.active)
        won = Signal.like(self.i_payload.payload, reset_less=True)
        m.d.sync += won.eq(self.i_payload.payload)
        for bank in range(BANKS):
            m.submodules[f"generations_{bank}"] = generations = Generations(bits=icu.generation_bits, depth=icu.rays)
            tag = StructLayout({"update": self._tag, "updates": 1, "reads": 1})
            m.submodules[f"rows_{bank}"] = rows = UpdateMemory(row, depth=icu.rays, operand=operand, tag=tag,
                                                               change=change)
            # A frustum begins in the bank that is not active.
            mine, begun = self.active != bank, Signal(name=f"begun_{bank}")
            m.d.comb += [generations.i_start.valid.eq(self.i_start.valid & mine), generations.rows.eq(self.rays),
                         generations.idle.eq(mine & ~begun)]
            with m.If(generations.i_start.valid & generations.i_start.ready):
                m.d.sync += begun.eq(1)
            with m.If(mine):
                m.d.comb += self.i_start.ready.eq(generations.i_start.ready)

            updates = self.i.valid & (self.active == bank)
            reads = accepts & (self.i_read.payload.bank == bank)
            claim(m, ~(updates & reads), "a bank is updated or read")
            m.d.comb += generations.busy.eq(updates | reads)
            # There is no slack for a multiplexer in front of a block RAM. Whether a row is swept is known last.
            given, is_given = Signal.like(rows.i.payload, reset_less=True), Signal()
            m.d.sync += [
                is_given.eq(updates | reads | generations.sweeps),
                given.address.eq(Mux(updates, self.i.payload.ray,
                                     Mux(reads, self.i_read.payload.ray, generations.row))),
                given.operand.clear.eq(~(updates | reads)), given.operand.hit.eq(updates & self.i.payload.hit),
                given.operand.row.generation.eq(Mux(updates | reads, generations.generation, 0)),
                given.operand.row.inverse.eq(self.i.payload.inverse),
                given.operand.row.complement.eq(~self.i.payload.patch),
                given.tag.update.eq(self.i.payload.tag), given.tag.updates.eq(updates), given.tag.reads.eq(reads)]
            m.d.comb += [rows.i.valid.eq(is_given), rows.i.payload.eq(given)]

            is_shadow = self._add_shadow(m, bank, given, mine) if self._shadow else Const(0)
            made = rows.o.payload
            with m.If(rows.o.valid & made.tag.updates):
                m.d.comb += [self.o.valid.eq(1), self.o.payload.tag.eq(made.tag.update),
                             self.o.payload.ray.eq(made.address), self.o.payload.won.eq(made.written),
                             self.o.payload.inverse.eq(made.new.inverse)]
            some, answers = Signal(), Signal()
            hit = Signal.like(found.i.payload, reset_less=True)
            m.d.sync += [
                answers.eq(rows.o.valid & made.tag.reads),
                some.eq((made.old.generation == generations.generation)
                        & Mux(is_shadow, made.old.inverse.all(), made.old.inverse.any())),
                hit.inverse.eq(made.old.inverse), hit.patch.eq(~made.old.complement)]
            if icu.uv_bits:
                uv = self._add_payload(m, bank, won)
                m.d.sync += [hit.u.eq(Mux(is_shadow, 0, uv.u)), hit.v.eq(Mux(is_shadow, 0, uv.v))]
            with m.If(answers):
                m.d.comb += found.i.valid.eq(1)
                with m.If(some):
                    m.d.comb += found.i.payload.eq(hit)
        return m

    def _add_shadow(self, m, bank, given, begins):
        """What updates are in a bank of a shadow frustum; whether it is one."""
        is_shadow, update = Signal(name=f"is_shadow_{bank}"), self.i.payload
        with m.If(begins & self.i_start.valid & self.i_start.ready):
            m.d.sync += is_shadow.eq(self.is_shadow)
        updates = self.i.valid & (self.active == bank)
        m.d.sync += given.operand.settles.eq(updates & is_shadow & ~update.lists)
        with m.If(updates):
            m.d.sync += given.operand.clear.eq(update.lists)
            # Of the smallest id: a hit as near as the end is not larger.
            with m.If(is_shadow):
                m.d.sync += given.operand.row.complement.eq(~Const(0, len(update.patch)))
        return is_shadow

    def _add_payload(self, m, bank, won):
        """A bank's memory of (u, v); those of the read whose row is at its output."""
        uv_pair = StructLayout({"u": self._formats.uv, "v": self._formats.uv})
        m.submodules[f"payload_{bank}"] = payload = Memory(shape=uv_pair, depth=self._config.icu.rays, init=[],
                                                           attrs={"no_rw_check": 1})
        write, read = payload.write_port(), payload.read_port(domain="comb")
        writes = Signal()
        m.d.sync += writes.eq(self.i_payload.valid & (self.active == bank))
        m.d.comb += [write.addr.eq(won.ray), write.data.u.eq(won.u), write.data.v.eq(won.v), write.en.eq(writes)]
        # The row has age 5, and so must (u, v): three registers of the address, the memory's, and one more.
        address = self.i_read.payload.ray
        for _ in range(3):
            later = Signal.like(address, reset_less=True)
            m.d.sync += later.eq(address)
            address = later
        uv_4, uv = (Signal.like(read.data, reset_less=True) for _ in range(2))
        m.d.comb += read.addr.eq(address)
        m.d.sync += [uv_4.eq(read.data), uv.eq(uv_4)]
        return uv

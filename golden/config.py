"""The one configuration of the golden model, the machine and its testbench.

Every knob is a field of a frozen dataclass; what follows from the knobs is a property. Formats are those of
`golden.fixed`.
"""

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from golden.errors import InputError
from golden.fixed import Format, signed, unsigned
from golden.noc.router import ARBITRATIONS
from golden.noc.routing import classes_needed
from golden.noc.topology import TOPOLOGIES, Topology

__all__ = ["PRESETS", "Config", "Ctu", "Icu", "Memory", "Memsys", "Noc", "Numbers"]


def _check_range(where, name, value, low, high):
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        label = name.replace("_", " ").capitalize()
        raise InputError(f"configuration: {label} ({where}.{name}) must be {low} to {high}, not {value!r}")


def _check_power_of_two(where, name, value, low, high):
    _check_range(where, name, value, low, high)
    if value & (value - 1):
        label = name.replace("_", " ").capitalize()
        raise InputError(f"configuration: {label} ({where}.{name}) must be a power of two, not {value!r}")


def _check_choice(where, name, value, choices):
    if value not in choices:
        label = name.replace("_", " ").capitalize()
        raise InputError(f"configuration: {label} ({where}.{name}) must be {', '.join(choices)}, not {value!r}")


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """Widths of the numbers that more than one block works with.

    Parameters
    ----------
    scene_bits
        Bits of a scene (G) coordinate, unsigned 0.b; 12 to 24.
    vector_fraction
        Bits behind the point of a vertex in the R frame, signed 1.b; 10 to 22, at most ``scene_bits``.
    direction_fraction
        Bits behind the point of ray directions and matrix entries, signed 1.b; 8 to 16 (two to an 18-bit multiplier).
    vertex_bits
        Bits of the magnitudes of a normalised vertex direction V'; 10 to 17 (edge planes are two limbs of 18 bits).
    mantissa_bits
        Bits of the magnitudes of m = N/V; 18 to 24 (18 fail at grazing angles).
    exponent_bits, fraction_bits
        Exponent and fraction of the stored inverse distance; 5 to 7 and 8 to 24.
    """

    scene_bits: int = 24
    vector_fraction: int = 22
    direction_fraction: int = 16
    vertex_bits: int = 17
    mantissa_bits: int = 24
    exponent_bits: int = 6
    fraction_bits: int = 18

    def __post_init__(self):
        for name, low, high in (("scene_bits", 12, 24), ("vector_fraction", 10, 22), ("direction_fraction", 8, 16),
                                ("vertex_bits", 10, 17), ("mantissa_bits", 18, 24), ("exponent_bits", 5, 7),
                                ("fraction_bits", 8, 24)):
            _check_range("numbers", name, getattr(self, name), low, high)
        if self.vector_fraction > self.scene_bits:
            raise InputError("configuration: Vector fraction (numbers.vector_fraction) must be at most "
                             f"numbers.scene_bits ({self.scene_bits}), not {self.vector_fraction!r}")

    @property
    def scene(self) -> Format:
        """Scene (G) coordinates."""
        return unsigned(0, self.scene_bits)

    @property
    def offset(self) -> Format:
        """A vertex relative to the origin, before the rotation."""
        return signed(0, self.scene_bits)

    @property
    def vector(self) -> Format:
        """Vertices in the R frame."""
        return signed(1, self.vector_fraction)

    @property
    def direction(self) -> Format:
        """Ray directions, their tables, and matrix entries."""
        return signed(1, self.direction_fraction)

    @property
    def vertex(self) -> Format:
        """Components of V'."""
        return signed(self.vertex_bits, 0)

    @property
    def edge_plane(self) -> Format:
        """Components of V'_i x V'_j: two products of ``vertex_bits`` magnitudes."""
        return signed(2 * self.vertex_bits + 1, 0)

    @property
    def edge_distance(self) -> Format:
        """Edge plane times ray direction: three products."""
        return signed(2 * self.vertex_bits + self.direction_fraction + 3, 0)

    @property
    def plane_normal(self) -> Format:
        """N, from two differences of vertices."""
        return signed(2 * (self.vector_fraction + 2) + 1, 0)

    @property
    def mantissa(self) -> Format:
        """Components of m, in units of its exponent."""
        return signed(self.mantissa_bits, 0)

    @property
    def inverse(self) -> Format:
        """The stored inverse distance as one integer: exponent, then fraction."""
        return unsigned(self.exponent_bits + self.fraction_bits, 0)

    @property
    def inverse_top(self) -> int:
        """The largest exponent of a stored inverse distance: at 2^-vector_fraction a distance is one unit long."""
        return self.vector_fraction + 2

    @property
    def inverse_bias(self) -> int:
        """An inverse distance is 1.f x 2^(exponent - bias)."""
        return (1 << self.exponent_bits) - 1 - self.inverse_top


@dataclass(frozen=True, kw_only=True)
class Icu:
    """Intersection computation.

    Parameters
    ----------
    rays
        Rays that the ray memory of one cluster holds; a power of two, 64 to 2^22.
    side_bits
        A frustum has at most 2^b columns and 2^b rows; 6 to 16.
    patch_bits
        A scene has at most 2^b patches; 8 to 24.
    tile_bits
        A word of the settle map holds 2^b x 2^b rays; 1 to 3.
    slots
        Patches between the start of their setup and the issue of their last ray; a power of two, 16 to 128. Setup takes
        a patch every four cycles, so a fourth of its latency keeps it going.
    generation_bits
        Bits of the tags that make a ray memory empty at once: every 2^b - 1 frusta it is cleared; 1 to 16.
    product_registers
        Registers of each multiplier; 1 to 3.
    angle_bits
        Bits of an angle; 2^b is a full turn; 18 to 24.
    cordic_stages
        Steps of each CORDIC; 8 to 20.
    cordic_guard
        Bits behind V' in the CORDIC data path; 0 to 8.
    bulge_polar_bits, bulge_span_bits
        Address bits of the table of how far an edge of a patch rises above its ends, for the lower polar angle and for
        the azimuths between the ends; 3 to 8 each.
    uv_bits
        Bits of u and of v; 1 to 12.
    uv_guard
        Bits that the subdivision carries beyond the 2 x ``uv_bits`` that it halves away; 0 to 12.
    settle_bits, settle_fraction
        Bits of a settle code, and how many of them are fraction; 4 to 12, and 1 to ``settle_bits`` - 2.
    """

    rays: int = 1 << 18
    side_bits: int = 12
    patch_bits: int = 16
    tile_bits: int = 2
    slots: int = 64
    generation_bits: int = 4
    product_registers: int = 2
    angle_bits: int = 24
    cordic_stages: int = 16
    cordic_guard: int = 6
    bulge_polar_bits: int = 5
    bulge_span_bits: int = 6
    uv_bits: int = 8
    uv_guard: int = 8
    settle_bits: int = 8
    settle_fraction: int = 5

    def __post_init__(self):
        _check_power_of_two("icu", "rays", self.rays, 64, 1 << 22)
        _check_power_of_two("icu", "slots", self.slots, 16, 128)
        for name, low, high in (("side_bits", 6, 16), ("patch_bits", 8, 24), ("tile_bits", 1, 3),
                                ("generation_bits", 1, 16), ("product_registers", 1, 3),
                                ("angle_bits", 18, 24), ("cordic_stages", 8, 20), ("cordic_guard", 0, 8),
                                ("bulge_polar_bits", 3, 8), ("bulge_span_bits", 3, 8), ("uv_bits", 1, 12),
                                ("uv_guard", 0, 12), ("settle_bits", 4, 12),
                                ("settle_fraction", 1, self.settle_bits - 2)):
            _check_range("icu", name, getattr(self, name), low, high)

    @property
    def ray_bits(self) -> int:
        """Address bits of the ray memory."""
        return self.rays.bit_length() - 1

    @property
    def slot_bits(self) -> int:
        """Bits of the number of a slot."""
        return self.slots.bit_length() - 1

    @property
    def uv(self) -> Format:
        """Where a patch was hit: the step of its lattice of u and of v."""
        return unsigned(0, self.uv_bits)

    @property
    def settle(self) -> Format:
        """Settle codes."""
        return unsigned(self.settle_bits, 0)


@dataclass(frozen=True, kw_only=True)
class Ctu:
    """Cell traversal.

    Parameters
    ----------
    pipelines
        Traversal pipelines of a cluster, each a cell per cycle; 1 to 4, or 0: as many as the number of clusters asks
        for, see `traversal_pipelines`.
    ray_slots
        Slots of the memory of the grid rays that have left; a power of two, 8 to 2^18. Rays that share a slot may leave
        more than once.
    lead
        Shells that cell traversal may be ahead of intersection; 0 to 15. 0 is a barrier after each shell.
    deferred
        Requests that can wait for a grid ray that is under way; a power of two, 4 to 256.
    pyramid_levels
        Levels of squares by which survival is looked up; 1 to 3. Those of the first one are the settle map's tiles,
        those of each further one 4 x 4 of the one below: of a dead one nothing more is looked at.
    subshell_bits
        A cluster's list has at most 2^b subshells; 4 to 14, or 0: there are no lists, and all of a sector is its last
        subshell.
    shell_bits
        Shells have numbers below 2^b; 3 to 10.
    grid_row_bits, grid_column_bits
        The grid rays of all shells together have at most 2^b rows and 2^b columns; 6 to 18.
    near_cell_bits
        Shell 1 has at most 2^b cells; 5 to 14. Those of a hemisphere are 27, of a screen the more the wider it is.
    """

    pipelines: int = 0
    ray_slots: int = 4096
    lead: int = 2
    deferred: int = 32
    pyramid_levels: int = 2
    subshell_bits: int = 10
    shell_bits: int = 6
    grid_row_bits: int = 11
    grid_column_bits: int = 13
    near_cell_bits: int = 9

    def __post_init__(self):
        for name, low, high in (("pipelines", 0, 4), ("lead", 0, 15), ("pyramid_levels", 1, 3),
                                ("shell_bits", 3, 10), ("grid_row_bits", 6, 18),
                                ("grid_column_bits", 6, 18), ("near_cell_bits", 5, 14)):
            _check_range("ctu", name, getattr(self, name), low, high)
        if self.subshell_bits:
            _check_range("ctu", "subshell_bits", self.subshell_bits, 4, 14)
        for name, low, high in (("ray_slots", 8, 1 << 18), ("deferred", 4, 256)):
            _check_power_of_two("ctu", name, getattr(self, name), low, high)

    @property
    def subshells(self) -> int:
        """How many a list can have."""
        return 1 << self.subshell_bits if self.subshell_bits else 0

    def traversal_pipelines(self, clusters: int) -> int:
        """Traversal pipelines of each of ``clusters`` clusters.

        A section's margin makes cell traversal grow against intersection as sections get smaller.
        """
        return self.pipelines or (2 if clusters < 8 else 3 if clusters < 16 else 4)


@dataclass(frozen=True, kw_only=True)
class Memsys:
    """Memory system.

    Parameters
    ----------
    cache_policy
        The caches' placement and replacement unless a run says otherwise: ``direct``, ``lru`` or ``lfu``, see
        `golden.memsys.cache`.
    cell_lines, patch_lines
        Lines of the cell cache and of the patch cache; a power of two, 8 to 4096.
    cache_ways
        Lines of a set under ``lru``; 2 or 4.
    lfu_lines
        Lines that ``lfu`` makes use of, at most; a power of two, 2 to 64: all of them are compared at once.
    lfu_count_bits
        Bits of the counters of ``lfu``; 2 to 8.
    cache_generation_bits
        Bits of the tags that make a cache empty at once: every 2^b - 1 times its tags are cleared; 1 to 8.
    cache_fetches
        Lines that a cache fetches at the same time; a power of two, 1 to 16.
    scene_cells
        Cells that a scene may have; a power of two, 64 to 2^20. The cell filter has a bit for each.
    own_cells, own_entries
        Records of a cluster's cell address table and entries of its patch address table; powers of two, 16 to 2^20,
        ``own_cells`` at most ``scene_cells``. Other cells are asked of the bus.
    own_patches
        Patches of a cluster's resident set; a power of two, 16 to 8192.
    filter_generation_bits
        Bits of the tags that empty the filters at once: every 2^b - 1 frusta they are cleared; 1 to 8.
    reply_ids
        Patch ids of a reply to a request for a cell, and of a line of the cell cache; a power of two, 2 to 16. Longer
        lists come in parts.
    bus_requests
        Requests for cells, and for patches, that a cluster may have on the bus; a power of two, 1 to 16.
    """

    cache_policy: str = "lru"
    cell_lines: int = 256
    patch_lines: int = 256
    cache_ways: int = 4
    lfu_lines: int = 64
    lfu_count_bits: int = 6
    cache_generation_bits: int = 4
    cache_fetches: int = 8
    scene_cells: int = 1 << 16
    own_cells: int = 1 << 12
    own_entries: int = 1 << 14
    own_patches: int = 512
    filter_generation_bits: int = 4
    reply_ids: int = 8
    bus_requests: int = 4

    def __post_init__(self):
        _check_choice("memsys", "cache_policy", self.cache_policy, ("direct", "lru", "lfu"))
        for name, low, high in (("cell_lines", 8, 4096), ("patch_lines", 8, 4096), ("cache_ways", 2, 4),
                                ("lfu_lines", 2, 64), ("cache_fetches", 1, 16), ("scene_cells", 64, 1 << 20),
                                ("own_cells", 16, 1 << 20), ("own_entries", 16, 1 << 20), ("own_patches", 16, 8192),
                                ("reply_ids", 2, 16), ("bus_requests", 1, 16)):
            _check_power_of_two("memsys", name, getattr(self, name), low, high)
        for name, low, high in (("lfu_count_bits", 2, 8), ("cache_generation_bits", 1, 8),
                                ("filter_generation_bits", 1, 8)):
            _check_range("memsys", name, getattr(self, name), low, high)
        if self.own_cells > self.scene_cells:
            raise InputError("configuration: Own cells (memsys.own_cells) must be at most memsys.scene_cells "
                             f"({self.scene_cells}), not {self.own_cells!r}")


@dataclass(frozen=True, kw_only=True)
class Memory:
    """Main memory, as its AXI4 port sees it.

    Parameters
    ----------
    address_bits
        Bits of the address of a byte; 16 to 48.
    data_bits
        Bits of a beat; 64 or 128.
    outstanding
        Bursts that may be under way, of reads and of writes each; a power of two, 1 to 64.
    burst_beats
        Beats of the longest burst, for all of which a read has room before it goes out; a power of two, 2 to 256, and
        at most 4096 bytes.
    length_bits
        A request is for at most 2^b beats; 1 to 12.
    timeout_bits
        What waits for the memory for 2^b cycles is given up; 2 to 24.
    """

    address_bits: int = 40
    data_bits: int = 64
    outstanding: int = 16
    burst_beats: int = 16
    length_bits: int = 8
    timeout_bits: int = 12

    def __post_init__(self):
        _check_power_of_two("memory", "data_bits", self.data_bits, 64, 128)
        _check_power_of_two("memory", "outstanding", self.outstanding, 1, 64)
        _check_power_of_two("memory", "burst_beats", self.burst_beats, 2, 256)
        for name, low, high in (("address_bits", 16, 48), ("length_bits", 1, 12), ("timeout_bits", 2, 24)):
            _check_range("memory", name, getattr(self, name), low, high)

    @property
    def beat_bytes(self) -> int:
        """Bytes of a beat."""
        return self.data_bits // 8


@dataclass(frozen=True, kw_only=True)
class Noc:
    """The network between the clusters.

    Parameters
    ----------
    topology
        ``mesh``, ``torus``, ``ring``, ``illiac`` or ``hypercube``, see `golden.noc.topology`.
    columns, rows
        Clusters side by side; 1 to 64 each and at most 64 in all, of a hypercube powers of two. A ring goes through all
        rows, one after the other.
    virtual_channels
        Queues of each input port of a router, for requests and for replies each; 1 to 8. Where links close a ring that
        packets could wait around, a multiple of 2 (`golden.noc.routing`).
    buffer_flits
        Flits that such a queue holds; 2 to 64. Fewer than a credit takes cycles to come back leave links idle.
    flit_bits
        Bits of a flit's data; 16 to 256. The 72 of a vertex let a link pass one per cycle.
    requests
        Patches that a cluster may have asked others for and not been given; 1 to 64. A reply takes a link five cycles,
        so a fifth of the way there and back keeps it going.
    router_cycles
        Cycles in a router, 1 or 2; with 1 a flit is chosen and passes the crossbar in the same one, at a slower clock.
    arbitration
        Which packet goes first: ``round-robin`` over the queues, or ``age``, the one that has waited longest.
    networks
        Requests and replies have links of their own, ``physical``, or ``virtual`` channels of their own on the same.
    check
        With what each flit is checked where it leaves the network: ``none``, ``parity`` or ``crc``.
    """

    topology: str = "mesh"
    columns: int = 4
    rows: int = 2
    virtual_channels: int = 2
    buffer_flits: int = 8
    flit_bits: int = 72
    requests: int = 4
    router_cycles: int = 2
    arbitration: str = "round-robin"
    networks: str = "physical"
    check: str = "parity"

    def __post_init__(self):
        _check_choice("noc", "topology", self.topology, TOPOLOGIES)
        for name, low, high in (("columns", 1, 64), ("rows", 1, 64), ("virtual_channels", 1, 8),
                                ("buffer_flits", 2, 64), ("flit_bits", 16, 256), ("requests", 1, 64),
                                ("router_cycles", 1, 2)):
            _check_range("noc", name, getattr(self, name), low, high)
        for name, choices in (("arbitration", ARBITRATIONS), ("networks", ("physical", "virtual")),
                              ("check", ("none", "parity", "crc"))):
            _check_choice("noc", name, getattr(self, name), choices)
        if self.nodes > 64:
            raise InputError("configuration: Columns times rows (noc.columns, noc.rows) must be at most 64, "
                             f"not {self.columns} x {self.rows}")
        classes = classes_needed(self.network())
        if self.virtual_channels % classes:
            raise InputError("configuration: Virtual channels (noc.virtual_channels) must be a multiple of "
                             f"{classes} in a {self.network()}, not {self.virtual_channels!r}")

    def network(self) -> Topology:
        """Nodes, ports and links."""
        return Topology(self.topology, self.columns, self.rows)

    @property
    def nodes(self) -> int:
        """Clusters, each with a router."""
        return self.columns * self.rows

    @property
    def node_bits(self) -> int:
        """Bits of the number of a node."""
        return (self.nodes - 1).bit_length()

    @property
    def link_channels(self) -> int:
        """Virtual channels of a link."""
        return self.virtual_channels * (2 if self.networks == "virtual" else 1)


@dataclass(frozen=True, kw_only=True)
class Config:
    """All parameters.

    Parameters
    ----------
    numbers, icu, ctu, memsys, memory, noc
        See there.
    """

    numbers: Numbers = field(default_factory=Numbers)
    icu: Icu = field(default_factory=Icu)
    ctu: Ctu = field(default_factory=Ctu)
    memsys: Memsys = field(default_factory=Memsys)
    memory: Memory = field(default_factory=Memory)
    noc: Noc = field(default_factory=Noc)

    def __post_init__(self):
        if self.icu.settle_fraction > self.numbers.fraction_bits:
            raise InputError("configuration: Settle fraction (icu.settle_fraction) must be at most "
                             f"numbers.fraction_bits ({self.numbers.fraction_bits}), not {self.icu.settle_fraction!r}")

    def parameters(self) -> dict[str, object]:
        """All knobs by path, for example ``icu.rays``."""
        return {f"{group.name}.{knob.name}": getattr(getattr(self, group.name), knob.name)
                for group in dataclasses.fields(self) for knob in dataclasses.fields(getattr(self, group.name))}

    def replace(self, changes: dict[str, object]) -> "Config":
        """The configuration with other values of the knobs named by path.

        Errors
        ------
        InputError
            There is no such knob, or the values are out of range or do not go together.
        """
        known = self.parameters()
        for path in changes:
            if path not in known:
                raise InputError(f"configuration: there is no parameter {path!r}; there are {', '.join(known)}")
        groups = {}
        for path, value in changes.items():
            group, knob = path.split(".")
            groups.setdefault(group, {})[knob] = value
        return dataclasses.replace(self, **{
            group: dataclasses.replace(getattr(self, group), **knobs) for group, knobs in groups.items()})

    def with_parameters(self, assignments) -> "Config":
        """`replace` with assignments as the command line has them, for example ``icu.rays=4096``.

        Errors
        ------
        InputError
            An assignment has no ``=`` or a value that is not of the knob's type, or as `replace`.
        """
        known, changes = self.parameters(), {}
        for assignment in assignments:
            path, equals, text = assignment.partition("=")
            if not equals:
                raise InputError(f"configuration: a parameter is given as PATH=VALUE, not {assignment!r}")
            kind = type(known.get(path, ""))
            try:
                changes[path] = int(text, 0) if kind is int else kind(text)
            except ValueError:
                raise InputError(f"configuration: {path} must be of type {kind.__name__}, not {text!r}") from None
        return self.replace(changes)


# tiny: simulates in seconds. small: a cluster fits an ECP5-85, whose block RAM has room for so many rays, and for the
# grid rays of the built-in scenes from cells of 1/16 on.
# paper: the thesis' machine. large: what simulation still bears.
PRESETS = {
    "tiny": Config(icu=Icu(rays=1 << 12, side_bits=10, patch_bits=13),
                   memsys=Memsys(scene_cells=1 << 12, own_patches=256),
                   noc=Noc(columns=2, rows=1, virtual_channels=1)),
    "small": Config(icu=Icu(rays=1 << 12, side_bits=10, patch_bits=13), ctu=Ctu(grid_row_bits=10, grid_column_bits=12),
                    memsys=Memsys(scene_cells=1 << 14),
                    noc=Noc(columns=2, rows=2, virtual_channels=1, requests=8)),
    "paper": Config(memsys=Memsys(own_cells=1 << 16, own_entries=1 << 17, own_patches=1024, bus_requests=16),
                    noc=Noc(requests=16)),
    "large": Config(icu=Icu(rays=1 << 20, patch_bits=20),
                    memsys=Memsys(scene_cells=1 << 20, own_cells=1 << 17, own_entries=1 << 18, own_patches=4096,
                                  bus_requests=16),
                    noc=Noc(topology="torus", columns=4, rows=4, requests=16)),
}

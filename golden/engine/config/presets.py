"""Named configurations."""

from golden.engine.config.config import Config
from golden.engine.config.ctu import Ctu
from golden.engine.config.icu import Icu
from golden.engine.config.memory import Memory
from golden.engine.config.memsys import Memsys
from golden.engine.config.noc import Noc
from golden.engine.config.numbers import Numbers

__all__ = ["PRESETS"]

# All have the five parts of `golden.engine.config.parts`; what a preset leaves out it names with a 0.
#
# tiny: simulates in seconds. Beside 256 patches of the resident set 32 of a patch store.
# small: a cluster fits an ECP5-85, whose block RAM bounds the rays; its tables of grid rays suffice for the built-in
#   scenes with cells of 1/16 and larger. Beside 512 patches of the resident set 128 of a patch store, whose 8 requests
#   are as many as the network's.
# paper: the size of the thesis' machine. A cluster has memory for 1024 patches, the most whose copies in all clusters
#   are smaller than a network, and for 1024 of other clusters; tags are cleared every 255 frusta.
# thesis: the machine as the thesis describes it, the baseline of every improvement. Each cluster explores a list of
#   subshells (4.4.2.4), one after the other: a barrier after each subshell and none between its shells (5.2.4.1). Grid
#   rays have presence bits, and requests for absent rays are deferred (Fig. 5.10). One traversal pipeline, and survival
#   by the settle map's tiles alone. Resident sets are the patches that the low-density casting found (4.4.2.1). Caches
#   are fully associative with LFU replacement (5.3.7), and there is no patch store: the I-structure is that of the grid
#   rays. Eight clusters in a torus with separate networks for requests and replies (tables 6.2 and 6.3). Measured with
#   cells of 0.5 and 0.0625.
# large: the largest that still simulates, with memory for 4096 patches in each cluster and for 1024 of others.
# board: the smallest, for a scene like `cornell`, which a cluster and a patch node hold between them. Its numbers are
#   the narrowest: an edge plane is one limb, and so is a vertex.
PRESETS = {
    "tiny": Config(icu=Icu(rays=1 << 12, side_bits=10, patch_bits=13),
                   memsys=Memsys(scene_cells=1 << 12, own_patches=256, store_patches=32, store_requests=4),
                   noc=Noc(columns=2, rows=1, virtual_channels=1)),
    "small": Config(icu=Icu(rays=1 << 12, side_bits=10, patch_bits=13), ctu=Ctu(grid_row_bits=10, grid_column_bits=12),
                    memsys=Memsys(scene_cells=1 << 14, store_patches=128, store_requests=8),
                    noc=Noc(columns=2, rows=2, virtual_channels=1, requests=8)),
    "paper": Config(icu=Icu(generation_bits=8),
                    memsys=Memsys(own_cells=1 << 16, own_entries=1 << 17, own_patches=1024, store_patches=1024,
                                  bus_requests=16),
                    noc=Noc(requests=16)),
    "thesis": Config(ctu=Ctu(pipelines=1, ray_slots=1 << 11, run_ahead=15, pyramid_levels=1, subshell_bits=10,
                             subshell_barrier=1),
                     memsys=Memsys(cache_policy="lfu", cell_lines=64, patch_lines=64, resident_set="found",
                                   own_cells=1 << 16, own_entries=1 << 17, own_patches=1024, store_patches=0,
                                   bus_requests=16, filter_generation_bits=4),
                     noc=Noc(topology="torus", requests=16)),
    "large": Config(icu=Icu(rays=1 << 20, patch_bits=20, generation_bits=8),
                    memsys=Memsys(scene_cells=1 << 20, own_cells=1 << 17, own_entries=1 << 18, own_patches=4096,
                                  store_patches=1024, bus_requests=16),
                    noc=Noc(topology="torus", columns=4, rows=4, requests=16)),
    "board": Config(
        numbers=Numbers(scene_bits=14, vector_fraction=12, direction_fraction=10, vertex_bits=8, mantissa_bits=18,
                        exponent_bits=5, fraction_bits=10),
        icu=Icu(rays=1 << 10, side_bits=6, patch_bits=8, slots=16, generation_bits=1, product_registers=1,
                angle_bits=18, cordic_stages=8, cordic_guard=2, sagitta_polar_bits=3, sagitta_span_bits=3, uv_bits=0,
                uv_guard=0, settle_bits=5, settle_fraction=3),
        ctu=Ctu(pipelines=1, run_ahead=1, pyramid_levels=1, shell_bits=4, grid_row_bits=7, grid_column_bits=8,
                near_cell_bits=5),
        memsys=Memsys(cache_policy="direct", cell_lines=8, patch_lines=8, cache_generation_bits=1, cache_fetches=2,
                      scene_cells=128, own_cells=64, own_entries=256, own_patches=16, store_patches=8, store_requests=2,
                      filter_generation_bits=1, reply_ids=2, bus_requests=1),
        memory=Memory(address_bits=17, outstanding=2, burst_beats=8),
        noc=Noc(columns=2, rows=1, patch_nodes=1, virtual_channels=1, buffer_flits=2, flit_bits=32, requests=2,
                networks="virtual", check="none")),
}

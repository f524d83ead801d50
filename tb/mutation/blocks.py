"""Which testbenches run on the mutants of which block."""

from collections.abc import Callable
from functools import partial

from tb.ctu import (
    test_cell_traversal,
    test_ct_ray_generator,
    test_grid_direction,
    test_grid_entries,
    test_near_window,
    test_subshell_generator,
    test_subshell_windows,
    test_traversal_start,
)
from tb.ctu import test_ray_banks as test_grid_ray_banks
from tb.ctu import test_ray_memory as test_grid_ray_memory
from tb.icu import (
    test_edge_planes,
    test_g2r_transform,
    test_inverse_distance,
    test_ipbb,
    test_patch_sums,
    test_plane_factor,
    test_ray_direction,
    test_read_out,
    test_sbb,
    test_screening,
    test_section_clip,
    test_spherical_coordinates,
    test_uv_alignment,
    test_uv_subdivision,
    test_vertex_direction,
    test_vertex_gather,
)
from tb.lib.bench import Bench
from tb.lib.runner import Run, recorded
from tb.memsys import test_cache, test_istructure
from tb.noc import test_network

__all__ = ["BLOCKS", "run_of"]


def _bench(module) -> Callable[[], None]:
    """A component's own testbench: the declared one of its module, or the module's test in simulators."""
    for value in vars(module).values():
        if isinstance(value, type) and issubclass(value, Bench) and value is not Bench:
            return value().simulate
    return partial(module.test_in_the_simulator, "verilator")


# Of each block its parts: a function that simulates. Most results of a whole unit hardly depend on the low bits of its
# intermediate values, so each of its parts is tested by its own testbench.
BLOCKS: dict[str, dict[str, Callable[[], None]]] = {
    "icu": {
        "vertex_gather": _bench(test_vertex_gather), "g2r_transform": _bench(test_g2r_transform),
        "edge_planes": _bench(test_edge_planes), "plane_factor": _bench(test_plane_factor),
        "vertex_direction": _bench(test_vertex_direction),
        "spherical_coordinates": _bench(test_spherical_coordinates),
        "sbb": _bench(test_sbb), "ipbb": _bench(test_ipbb), "section_clip": _bench(test_section_clip),
        "ray_direction": _bench(test_ray_direction), "screening": _bench(test_screening),
        "inverse_distance": _bench(test_inverse_distance), "uv_alignment": _bench(test_uv_alignment),
        "uv_subdivision": _bench(test_uv_subdivision),
        "ray_memory and read_out": _bench(test_read_out), "patch_sums": _bench(test_patch_sums)},
    "ctu": {
        "ct_ray_generator": _bench(test_ct_ray_generator), "near_window": _bench(test_near_window),
        "subshell_generator": _bench(test_subshell_generator), "subshell_windows": _bench(test_subshell_windows),
        "grid_entries": _bench(test_grid_entries), "grid_direction": _bench(test_grid_direction),
        "traversal_start": _bench(test_traversal_start), "cell_traversal": _bench(test_cell_traversal),
        "ray_memory": _bench(test_grid_ray_memory), "ray_banks": _bench(test_grid_ray_banks)},
    "istructure": {"istructure": _bench(test_istructure)},
    "cache": {"cache": lambda: test_cache.test_in_the_simulator(next(iter(test_cache.SIZES)), "verilator")},
    "router": {"network": lambda: test_network.check(*test_network.SMALL[1], simulator="verilator", flits=6000)},
}


def run_of(block: str, part: str) -> Run:
    """What the test of a block's part would simulate."""
    with recorded() as runs:
        BLOCKS[block][part]()
    (run,) = runs
    return run

"""Which benches judge the mutants of which block."""

from collections.abc import Callable
from dataclasses import dataclass
from unittest import mock

from hw.export import verilog_of
from tb.ctu import (
    test_cell_traversal,
    test_ct_ray_generator,
    test_grid_direction,
    test_grid_entries,
    test_near_window,
    test_subshell_generator,
    test_subshell_windows,
)
from tb.ctu import test_ray_banks as test_grid_ray_banks
from tb.ctu import test_ray_memory as test_grid_ray_memory
from tb.icu import (
    test_collector,
    test_edge_planes,
    test_g2r_transform,
    test_inverse_distance,
    test_ipbb,
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
from tb.lib import block_bench
from tb.memsys import test_cache, test_istructure
from tb.noc import replay, test_network

__all__ = ["BLOCKS", "Bench", "bench_of"]


@dataclass(frozen=True)
class Bench:
    """Verilog of a component, and the coroutines that look at it: see `tb.lib.runner.simulate`."""

    text: str
    module: str
    tests: tuple[str, ...]
    given: dict


def _part(module, test="test_in_the_simulator"):
    """A component's own bench."""
    run = getattr(module, test)
    return lambda: run("verilator"), module if hasattr(module, "simulate") else block_bench


# Of each block its parts: a test that simulates, and where it takes `simulate` from. Of a whole unit's answers most are
# the same whatever the low bits of what it calculates with, so each of its parts is judged by its own bench.
BLOCKS: dict[str, dict[str, tuple[Callable[[], None], object]]] = {
    "icu": {
        "vertex_gather": _part(test_vertex_gather), "g2r_transform": _part(test_g2r_transform),
        "edge_planes": _part(test_edge_planes), "plane_factor": _part(test_plane_factor),
        "vertex_direction": _part(test_vertex_direction), "spherical_coordinates": _part(test_spherical_coordinates),
        "sbb": _part(test_sbb), "ipbb": _part(test_ipbb), "section_clip": _part(test_section_clip),
        "ray_direction": _part(test_ray_direction), "screening": _part(test_screening),
        "inverse_distance": _part(test_inverse_distance), "uv_alignment": _part(test_uv_alignment),
        "uv_subdivision": _part(test_uv_subdivision),
        "ray_memory and read_out": (lambda: test_read_out.run("mutants", {}), test_read_out),
        "collector": _part(test_collector)},
    "ctu": {
        "ct_ray_generator": _part(test_ct_ray_generator), "near_window": _part(test_near_window),
        "subshell_generator": _part(test_subshell_generator), "subshell_windows": _part(test_subshell_windows),
        "grid_entries": _part(test_grid_entries), "grid_direction": _part(test_grid_direction),
        "cell_traversal": _part(test_cell_traversal, "test_in_simulators"),
        "ray_memory": _part(test_grid_ray_memory), "ray_banks": _part(test_grid_ray_banks)},
    "istructure": {"istructure": _part(test_istructure)},
    "cache": {"cache": (lambda: test_cache.test_in_the_simulator(next(iter(test_cache.SIZES)), "verilator"),
                        test_cache)},
    "router": {"network": (lambda: test_network.check(*test_network.SMALL[1], simulator="verilator", flits=6000),
                           replay)},
}


def bench_of(block: str, part: str) -> Bench:
    """What the test of a block's part would simulate."""
    found = []

    def note(component, module, tests, *, name, simulator="verilator", visible=(), **given):
        text = component if isinstance(component, str) else verilog_of(component, "top")
        found.append(Bench(text, module, tuple(tests), given))

    test, where = BLOCKS[block][part]
    with mock.patch.object(where, "simulate", note):
        test()
    (bench,) = found
    return bench

"""Parameters of the cell traversal unit."""

from dataclasses import dataclass

from golden.engine.config.checks import check_power_of_two, check_range

__all__ = ["Ctu"]


@dataclass(frozen=True, kw_only=True)
class Ctu:
    """Parameters of the cell traversal unit (CTU).

    Parameters
    ----------
    pipelines
        Traversal pipelines of a cluster, each one cell per cycle; 1 to 4, or 0: as many as `traversal_pipelines` gives
        for the number of clusters. Hardware only.
    ray_slots
        Slots of the memory of the grid rays issued, which is there with subshell lists; a power of two, 8 to 2^18. Rays
        that share a slot may be issued more than once. Hardware only.
    run_ahead
        Run-ahead depth: shells that cell traversal may be ahead of intersection; 0 to 15. 0 is a barrier after each
        shell. Hardware only.
    deferred
        Requests of that memory that can wait for a grid ray in flight; a power of two, 4 to 256. Hardware only.
    pyramid_levels
        Levels of the settle pyramid; 1 to 3. A square of the first level is a tile of the settle map, a square of each
        further level 4 x 4 squares of the level below. The survival test skips settled squares. Hardware only.
    subshell_bits
        A cluster's list has at most 2^b subshells; 4 to 14, or 0: there are no lists, and the whole sector is its last
        subshell.
    subshell_barrier
        1: a subshell begins when the subshell before it is over; 0: when the run-ahead depth allows its first shell.
        Hardware only.
    shell_bits
        Shells have numbers below 2^b; 3 to 10. Hardware only.
    grid_row_bits, grid_column_bits
        The grid rays of all shells together have at most 2^b rows and 2^b columns; 6 to 18. Hardware only.
    near_cell_bits
        Shell 1 has at most 2^b cells; 5 to 14. A hemisphere has 27, a screen more the wider it is. Hardware only.
    """

    pipelines: int = 0
    ray_slots: int = 4096
    run_ahead: int = 2
    deferred: int = 32
    pyramid_levels: int = 2
    subshell_bits: int = 0
    subshell_barrier: int = 0
    shell_bits: int = 6
    grid_row_bits: int = 11
    grid_column_bits: int = 13
    near_cell_bits: int = 9

    def __post_init__(self):
        for name, low, high in (("pipelines", 0, 4), ("run_ahead", 0, 15), ("pyramid_levels", 1, 3),
                                ("subshell_barrier", 0, 1), ("shell_bits", 3, 10), ("grid_row_bits", 6, 18),
                                ("grid_column_bits", 6, 18), ("near_cell_bits", 5, 14)):
            check_range("ctu", name, getattr(self, name), low, high)
        if self.subshell_bits:
            check_range("ctu", "subshell_bits", self.subshell_bits, 4, 14)
        for name, low, high in (("ray_slots", 8, 1 << 18), ("deferred", 4, 256)):
            check_power_of_two("ctu", name, getattr(self, name), low, high)

    @property
    def subshells(self) -> int:
        """Subshells that a list can hold; 0 without lists."""
        return 1 << self.subshell_bits if self.subshell_bits else 0

    def traversal_pipelines(self, clusters: int) -> int:
        """Traversal pipelines of each of ``clusters`` clusters.

        Smaller sections need more traversal per intersection test, because a section's margin does not shrink with it.
        """
        return self.pipelines or (2 if clusters < 8 else 3 if clusters < 16 else 4)

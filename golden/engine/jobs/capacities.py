"""Whether the tables of an image fit the machine of a configuration."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.memory_map.image import MemoryImage
from golden.engine.memory_map.layout import GRID_RAY_BITS

__all__ = ["check_capacities"]


def check_capacities(image: MemoryImage, config: Config) -> None:
    """Refuse an image that exceeds a capacity of the machine.

    Raises
    ------
    InputError
        Names the table, how long it is, and the parameter.
    """
    icu, ctu, memsys = config.icu, config.ctu, config.memsys
    clusters, shells = image["clusters"], image["shells"]
    grid_rays = int((shells["rows"].astype(np.int64) * shells["columns"]).sum())
    for what, value, most, parameter in (
            ("columns", len(image["columns"]), 1 << icu.side_bits, "icu.side_bits"),
            ("rows", len(image["rows"]), 1 << icu.side_bits, "icu.side_bits"),
            ("patches", len(image["patches"]), 1 << icu.patch_bits, "icu.patch_bits"),
            ("cells", len(image["cells"]), memsys.scene_cells, "memsys.scene_cells"),
            ("patches of a resident set", int(clusters["residents"].max()), memsys.own_patches, "memsys.own_patches"),
            ("subshells of a cluster", int(clusters["subshells"].max()), ctu.subshells, "ctu.subshell_bits"),
            ("shells", len(shells) + 2, 1 << ctu.shell_bits, "ctu.shell_bits"),
            ("rows of grid rays", len(image["grid_rows"]), 1 << ctu.grid_row_bits, "ctu.grid_row_bits"),
            ("columns of grid rays", len(image["grid_columns"]), 1 << ctu.grid_column_bits, "ctu.grid_column_bits"),
            ("grid rays", grid_rays, 1 << GRID_RAY_BITS, "their numbers")):
        if value > most:
            raise InputError(f"memory image: {what.capitalize()} must be at most {most} ({parameter}), not {value}")
    if len(clusters) != config.noc.nodes:
        raise InputError(f"memory image: It must be for {config.noc.nodes} nodes, not {len(clusters)}")
    if (clusters["processor"] != np.arange(len(clusters))).any():
        raise InputError("memory image: Cluster k must be processor k")

"""Inputs and expected outputs of each block, for ours and third-party testbenches: one module per block."""

from dataclasses import dataclass
from importlib import import_module

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.stimulus.block import Arrays, Block

__all__ = ["BLOCKS", "Stimulus", "block", "stimulus"]

# The vectors of a block depend on its position.
BLOCKS = (
    "cordic",
    "ctu.cell_traversal", "ctu.grid_rays", "ctu.near_cells", "ctu.ray_memory", "ctu.sector",
    "ctu.settle_pyramid", "ctu.survival", "ctu.unit",
    "icu.patch_sums", "icu.edge_planes", "icu.g2r_transform", "icu.intersection", "icu.inverse_distance", "icu.ipbb",
    "icu.patch_setup", "icu.plane_factor", "icu.ray_memory", "icu.reciprocal", "icu.sbb",
    "icu.screening", "icu.section_clip", "icu.settle_code", "icu.uv_subdivision", "icu.vertex_direction",
    "icu.window_walk",
    "memsys.cell_table", "memsys.filter", "memsys.istructure", "memsys.patch_table",
)


@dataclass(frozen=True, kw_only=True)
class Stimulus:
    """Some vectors of a block.

    Parameters
    ----------
    header
        JSON: block, about, count, seed, parameters, and per field name, role (input or output), format, bits, shape,
        constant (one array for all vectors), about.
    arrays
        Arrays by name of field: int64, or float64 where the format is float64.
    """

    header: dict
    arrays: Arrays


def block(name: str) -> tuple[str, Block]:
    """A block by its name; the part before the point may be omitted if the rest is unique.

    Returns
    -------
    tuple
        The whole name, and the block.

    Raises
    ------
    InputError
        No block has the name, or several have.
    """
    names = [known for known in BLOCKS if name in (known, known.rpartition(".")[2])]
    if len(names) != 1:
        raise InputError(f"stimulus: Block must be one of {', '.join(names or BLOCKS)}, not {name!r}")
    return names[0], import_module(f"golden.engine.stimulus.{names[0]}").BLOCK


def stimulus(name: str, *, count: int, seed: int, config: Config) -> Stimulus:
    """``count`` vectors of a block; the same for the same arguments.

    Raises
    ------
    InputError
        See `block`; or ``count`` or ``seed`` is out of range.
    """
    name, of = block(name)
    if not 1 <= count <= 1 << 20:
        raise InputError(f"stimulus: Count must be 1 to {1 << 20}, not {count!r}", parameter="count")
    if not 0 <= seed < 1 << 63:
        raise InputError(f"stimulus: Seed must be 0 to 2^63 - 1, not {seed!r}", parameter="seed")
    inputs, outputs = of.fields(config)
    random = np.random.default_rng([BLOCKS.index(name), seed])
    given = _stored(of.draw(random, count, config), inputs)
    arrays = {**given, **_stored(of.expect(given, config), outputs)}
    fields = [{"name": field.name, "role": role, "format": str(field.format or "float64"),
               "bits": field.format.width if field.format else 64, "shape": list(arrays[field.name].shape),
               "constant": field.constant, "about": field.about}
              for role, group in (("input", inputs), ("output", outputs)) for field in group]
    return Stimulus(header={"block": name, "about": of.about, "count": count, "seed": seed,
                            "parameters": config.parameters(), "fields": fields}, arrays=arrays)


def _stored(values, fields):
    """Values in the order of the fields, checked against their formats."""
    return {field.name: np.asarray(values[field.name], dtype=np.float64) if field.format is None
            else field.format.check(np.asarray(values[field.name], dtype=np.int64), field.name) for field in fields}

"""What a list of rays holds of a record."""

import numpy as np

from golden.engine.icu.window_walk import ray_address
from radiosity.flow.package.example.frustum_load import tiles

__all__ = ["FIELDS", "expected"]

FIELDS = ("ray", "x", "y", "end")


def expected(record, section, config):
    """Golden's rays with their places; None where they lie beside the section or nothing can be before their end."""
    number = np.flatnonzero(record.end < config.numbers.inverse.high)
    row, column = np.divmod(number, record.columns)
    inside = section.mask(record).ravel()[number]
    address = ray_address(column - section.first_column, row - section.first_row, tiles(section, config)[0], config.icu)
    place = record.directions(column, row)[:, :2] + (1 << config.numbers.direction_fraction)
    listed = zip(address.tolist(), *place.T.tolist(), record.end[number].tolist(), strict=True)
    return [ray if mine else None for ray, mine in zip(listed, inside, strict=True)]

"""Records of a layout from values."""

from collections.abc import Mapping

import numpy as np

from golden.base.errors import InputError
from golden.engine.frustum import FrustumRecord
from golden.engine.memory_map.layout import FRUSTUM_FIELDS, Region
from golden.engine.memsys.patches.cell_table import CellTable

__all__ = ["frustum_fields", "make_records"]

# Of `FRUSTUM_FIELDS`, those that need more than the frustum's record.
_DERIVED = ("grid_origin", "longest_direction")


def make_records(region: Region, length: int, owner: str, fields: Mapping[str, object]) -> np.ndarray:
    """Records with the fields given and 0 in all others.

    Parameters
    ----------
    region
        The layout.
    length
        Number of records.
    owner
        What the message of an error begins with.
    fields
        Values by field.

    Raises
    ------
    InputError
        A value is out of its field's range.
    """
    records = np.zeros(length, dtype=region.dtype)
    for name, value in fields.items():
        value = np.asarray(value)
        if value.size and value.dtype.kind in "iu":
            limits = np.iinfo(records[name].dtype)
            if value.min() < limits.min or value.max() > limits.max:
                raise InputError(f"{owner}: {region.name}.{name} must be {limits.min} to {limits.max}, "
                                 f"not {value.min()} to {value.max()}")
        records[name] = value
    return records


def frustum_fields(record: FrustumRecord, table: CellTable) -> dict[str, object]:
    """The values of `FRUSTUM_FIELDS` for a frustum in the cells of a scene."""
    return {"grid_origin": table.position(record.origin),
            "longest_direction": 0 if record.is_screen else record.longest_direction,
            **{field.name: np.ravel(getattr(record, field.name)) for field in FRUSTUM_FIELDS
               if field.name not in _DERIVED}}

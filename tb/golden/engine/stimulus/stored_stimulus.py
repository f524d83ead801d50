"""A stored stimulus, read as users read it."""

import json
from pathlib import Path

import numpy as np

__all__ = ["read_stimulus"]


def read_stimulus(path: Path) -> tuple[dict, dict[str, np.ndarray]]:
    """Header and arrays of a file, as docs/stimulus.md describes it."""
    if path.suffix == ".npz":
        with np.load(path) as stored:
            arrays = dict(stored)
        return json.loads(str(arrays.pop("header"))), arrays
    header, *vectors = map(json.loads, path.read_text().splitlines())
    constants = header.pop("constants")
    return header, {field["name"]: np.array(constants[field["name"]] if field["constant"]
                                            else [vector[field["name"]] for vector in vectors])
                    for field in header["fields"]}

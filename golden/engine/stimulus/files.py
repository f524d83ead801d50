"""Files of stimuli: arrays with a header, or lines of text."""

import json
from pathlib import Path

import numpy as np

from golden.base.output import whole_file
from golden.engine.stimulus import Stimulus

__all__ = ["SUFFIXES", "write_stimulus"]

SUFFIXES = (".npz", ".jsonl")


def write_stimulus(path: Path, made: Stimulus) -> None:
    """Write a stimulus.

    ``.npz``: one array per field, and ``header``, a string of JSON (see `Stimulus`). ``.jsonl``: the header with a
    member ``constants`` on the first line, then one object per vector, with negative numbers as such.
    """
    with whole_file(path) as part:
        if path.suffix.lower() == ".npz":
            np.savez_compressed(part, header=json.dumps(made.header), **made.arrays)
            return
        constant = {field["name"] for field in made.header["fields"] if field["constant"]}
        lists = {name: array.tolist() for name, array in made.arrays.items()}
        header = {**made.header, "constants": {name: lists[name] for name in lists if name in constant}}
        vectors = ({name: values[number] for name, values in lists.items() if name not in constant}
                   for number in range(made.header["count"]))
        with part.open("w") as file:
            file.writelines(json.dumps(line) + "\n" for line in (header, *vectors))

"""The files of exported cores stay what they are, beside the Verilog: manifests member by member, texts by their lines.

tb/package/core_record.json has them; `python -m tb.package.test_core_record` makes it anew, for a change that is meant
to change them.
"""

import json
import re
import zlib
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from unittest import mock

import pytest

from golden.config import PRESETS
from hw.package import core_files as core_module
from hw.package import manifest as manifest_module
from hw.package.core_files import core_files
from hw.package.tops import TOPS

# Lines of a text up to which it is listed whole, and characters of one of them.
_WHOLE, _LONG = 40, 240
RECORD = Path(__file__).with_name("core_record.json")
CONFIG = PRESETS["tiny"].replace({"noc.columns": 2, "noc.rows": 1})


def files(top):
    """By name; the version of the package and the engine's many latencies are left out."""
    empty = replace(TOPS[top], text=lambda *_: "module\n")
    with ExitStack() as stack:
        stack.enter_context(mock.patch.dict(TOPS, {top: empty}))
        for place in core_module, manifest_module:
            stack.enter_context(mock.patch.object(place, "core_version", return_value="1.2.3"))
        if top == "engine":
            stack.enter_context(mock.patch.object(manifest_module, "unit_latencies", return_value={}))
        found = core_files(top, config=CONFIG, preset="tiny")
    return {name: _content(name, content) for name, content in found.items()}


def listed(text):
    """The lines of a text, or their number and check sum if there are many; of long lines the beginning."""
    text = re.sub(r"\b[0-9a-f]{64}\b", "#", re.sub(r"\d+\.\d+ s\b", "# s", text))
    lines = text.splitlines()
    if len(lines) > _WHOLE:
        lines = [*lines[:8], f"... {len(lines)} lines, {zlib.crc32(text.encode()):08x}"]
    return [line if len(line) <= _LONG else f"{line[:60]} ... {zlib.crc32(line.encode()):08x}" for line in lines]


def _content(name, content):
    if name.endswith(".json"):
        return json.loads(content)
    if name.endswith(".bin"):
        return listed(content.hex())
    return listed(content if isinstance(content, str) else content.decode())


@pytest.mark.filterwarnings("ignore::amaranth.hdl.UnusedElaboratable")
@pytest.mark.parametrize("top", ["engine", "router"])
def test_files_of_a_core(top):
    expected = json.loads(RECORD.read_text())[top]
    found = json.loads(json.dumps(files(top)))
    assert found.keys() == expected.keys()
    for name in expected:
        assert found[name] == expected[name], name


if __name__ == "__main__":
    rows = (f' "{top}": {{\n' + ",\n".join(f"  {json.dumps(name)}: {json.dumps(content)}"
                                          for name, content in files(top).items()) + "\n }"
            for top in ("engine", "router"))
    RECORD.write_text("{\n" + ",\n".join(rows) + "\n}\n")

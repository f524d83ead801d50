"""Manifests of exported cores: what jobs need of them, and what is refused."""

import pytest

from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.jobs.core_manifest import read_manifest
from tb.golden.engine.jobs.manifests import write_manifest

CONFIG = PRESETS["small"].replace({"memsys.cache_policy": "lfu", "noc.columns": 1, "noc.rows": 1})
PARAMETERS = CONFIG.parameters()


def test_the_configuration_comes_back(tmp_path):
    found = read_manifest(write_manifest(tmp_path / "core.json", CONFIG))
    assert found.config == CONFIG
    assert (found.policy, found.sha256) == (2, "0123")


@pytest.mark.parametrize(("changes", "message"), [
    ({"formats": {"image": {"version": 2}, "descriptor": {"version": 1}}}, "Version of images must be 3, not 2"),
    ({"formats": {"image": {"version": 3}, "descriptor": {"version": 9}}}, "Version of descriptors must be 1, not 9"),
    ({"parameters": PARAMETERS | {"icu.colour": 1}}, "they differ in icu.colour"),
    ({"parameters": {key: value for key, value in PARAMETERS.items() if key != "icu.rays"}}, "they differ in icu.rays"),
    ({"parameters": PARAMETERS | {"icu.rays": 5}}, "(icu.rays) must be 64 to"),
    ({"parameters": PARAMETERS | {"icu.rays": "many"}}, "'many'"),
    ({"parameters": None}, "it is no manifest of an engine"), ({"formats": 3}, "it is no manifest of an engine"),
    ({"policies": {}}, "it is no manifest of an engine")])
def test_what_is_refused(changes, message, tmp_path):
    path = write_manifest(tmp_path / "core.json", CONFIG, **changes)
    with pytest.raises(InputError) as caught:
        read_manifest(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [b"", b"{", b"[]", b"7", b'{"name": "radiosity_icu"}', b"\0\1", b"\xff\xfe\x80"])
def test_other_files_are_refused(data, tmp_path):
    (tmp_path / "core.json").write_bytes(data)
    with pytest.raises(InputError, match=r"core\.json': it is no manifest of an engine, as `radiosity verilog` writes"):
        read_manifest(tmp_path / "core.json")

"""The manifest of an engine has what a driver needs that was written without this package."""

import json

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.core_manifest import read_manifest
from golden.engine.jobs.load_regions import region_bits
from golden.engine.memory_map import REGIONS
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ABOUT, ErrorCode
from hw.registers.register import addresses
from radiosity.flow.package.tops import TOPS
from tb.golden.engine.jobs.manifests import write_manifest
from tb.radiosity.flow.package.exported_engine import MANIFESTS

pytestmark = MANIFESTS


@pytest.fixture
def facts(facts_of):
    return facts_of("engine")


def test_registers_have_their_fields_and_reset_values(facts):
    assert {one["name"]: one["address"] for one in facts["registers"]} == addresses(ENGINE_REGISTERS)
    assert {one["name"]: one["reset"] for one in facts["registers"] if one.get("reset")} == {
        "policy": 1, "watchdog": 1 << 26}
    for one, register in zip(facts["registers"], ENGINE_REGISTERS, strict=True):
        fields = {field["name"]: (1 << field["width"]) - 1 << field["low"] for field in one["fields"]}
        assert fields == {field.name: register.pack(**{field.name: (1 << field.width) - 1})
                          for field in register.fields}


def test_only_what_is_written_has_a_reset_value(facts):
    """That of `magic` would be 0, which the machine never reads as."""
    assert {one["name"] for one in facts["registers"] if "reset" not in one} == {
        one["name"] for one in facts["registers"] if one["access"] == "read"} > {"magic", "version", "clusters"}


def test_error_codes(facts):
    assert {one["name"]: one["code"] for one in facts["errors"]} == {one.name: one.value for one in ErrorCode}
    assert {one["name"]: one["about"] for one in facts["errors"]} == ABOUT


def test_regions_have_the_bits_of_a_load(facts):
    assert {one["name"]: 1 << one["bit"] for one in facts["regions"]} == {
        one.name: region_bits(one.name) for one in REGIONS}
    sizes = {one["name"]: one["record_bytes"] for one in facts["regions"]}
    assert (sizes["patches"], sizes["rows"], sizes["cells"]) == (64, 24, 8)


def test_formats_are_those_that_the_machine_reports(facts):
    assert facts["formats"]["registers"] == {"magic": 0x45444152, "version": 3}
    assert facts["formats"]["image"] == {"magic": 0x45444152, "version": 3}
    assert facts["formats"]["descriptor"] == {"version": 1}


@pytest.mark.parametrize("top", sorted(name for name, top in TOPS.items() if not top.is_engine))
def test_units_have_no_registers(top, facts_of):
    assert not {"registers", "errors", "regions", "formats"} & set(facts_of(top))


@pytest.mark.parametrize("top", TOPS)
def test_fields_of_a_port_follow_each_other(top, facts_of):
    ports = facts_of(top)["ports"]
    for port in ports:
        end = 0
        for field in port.get("fields", ()):
            assert field["low"] == end, (port["name"], field)
            end += field["width"]
        assert end in (0, port["width"])
    if top in ("ctu", "icu"):
        frustum, = (port for port in ports if port["name"] == "i_frustum_payload")
        assert any(field["name"].count(".") > 1 for field in frustum["fields"])


def test_jobs_read_it(facts, tmp_path):
    """A manifest that stands for an exported one in tests of jobs has nothing that this one has not."""
    (tmp_path / "core.json").write_text(json.dumps(facts))
    assert read_manifest(tmp_path / "core.json").config == PRESETS["tiny"]
    other = json.loads(write_manifest(tmp_path / "other.json", PRESETS["tiny"]).read_text())
    assert set(other) <= set(facts)
    assert other["policies"] == facts["policies"]
    assert all(facts["formats"][name]["version"] == one["version"] for name, one in other["formats"].items())

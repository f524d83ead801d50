"""Exported Verilog through Yosys for each family of FPGAs that it knows: memories and all else are mapped."""

import pytest

from radiosity.flow.synthesis.flow import yosys
from tb.radiosity.flow.package.exported_engine import written

# Commands of Yosys, each with the label of what follows its mapping of memories.
FAMILIES = {"ecp5": "map_gates", "ice40": "map_gates", "gatemate": "map_gates", "gowin": "map_gates",
            "xilinx -family xc7": "fine", "intel_alm": "map_ffs", "nexus": "map_gates",
            "quicklogic -family pp3": "map_gates"}
# Those with memories in LUTs: elsewhere small memories become many thousand flip-flops.
WITH_LUT_MEMORIES = ["ecp5", "gowin", "xilinx -family xc7", "intel_alm", "nexus"]


def assert_mapped(folder, top, family, kind, *options):
    """Run a family's synthesis of a core; memories that stay unmapped are an error."""
    read = "read_verilog -sv" if kind == "sv" else "read_verilog"
    yosys(folder / f"{family.split()[0]}.log", f"{read} radiosity_{top}.{kind}",
          f"synth_{family} -top radiosity_{top} {' '.join(options)}", "select -assert-none t:$mem_v2 t:$mem")


@pytest.mark.parametrize("family", ["ice40", "gatemate"])
def test_memories_of_the_router_map_where_a_kind_of_memory_would_be_refused(family, router):
    """These two have no memory in LUTs, and abort where an attribute requires one."""
    assert_mapped(router[0], "router", family, "v", f"-run begin:{FAMILIES[family]}")


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["sv", "v"])
@pytest.mark.parametrize("family", FAMILIES)
def test_the_router_in_each_family(family, kind, router):
    assert_mapped(router[0], "router", family, kind)


@pytest.mark.nightly
@pytest.mark.parametrize("family", FAMILIES)
def test_the_intersection_unit_in_each_family(family, tmp_path):
    written(tmp_path, "--top", "icu", "--preset", "tiny")
    assert_mapped(tmp_path, "icu", family, "sv")


@pytest.mark.nightly
@pytest.mark.parametrize("family", WITH_LUT_MEMORIES)
@pytest.mark.parametrize("top", ["ctu", "cluster"])
def test_memories_of_large_tops(top, family, tmp_path):
    written(tmp_path, "--top", top, "--preset", "tiny")
    assert_mapped(tmp_path, top, family, "sv", f"-run begin:{FAMILIES[family]}")


@pytest.mark.nightly
@pytest.mark.parametrize("top", ["engine", "async_engine"])
def test_memories_of_engines(top, tmp_path):
    written(tmp_path, "--top", top, "--preset", "tiny", "-P", "noc.columns=1", "-P", "noc.rows=1")
    assert_mapped(tmp_path, top, "ecp5", "sv", "-run begin:map_gates")

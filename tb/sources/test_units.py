"""Every component has tests of its own name, or is tested with the unit that it is a part of."""

import re

import pytest

from tb.sources.source_texts import ROOT, components, source_texts

# By file of hw: the test, and how it reaches the component if that does not name it.
TESTED_IN = {
    "hw/cluster.py": ("tb/system/test_engine.py", "JobMachine"),
    **dict.fromkeys((f"hw/control/{name}.py" for name in (
        "cluster_watch", "error_register", "job_records", "load_state", "queue_state", "section_table")),
        ("tb/control/test_job_control.py", "JobControl")),
    "hw/control/descriptor_check.py": ("tb/control/test_job_dispatch.py", "JobDispatch"),
    "hw/ctu/cell_steps.py": ("tb/ctu/test_cell_traversal.py", "CellTraversal"),
    "hw/ctu/square_scan.py": ("tb/ctu/test_survival.py", "Survival"),
    "hw/icu/intersection_pipeline.py": ("tb/icu/test_intersection_unit.py", "IntersectionUnit"),
    "hw/lib/black_box.py": ("tb/docs/test_architecture.py", "tiny_structures"),
    "hw/lib/longest_waiting.py": ("tb/lib/test_arbiter.py", ""),
    "hw/lib/round_robin.py": ("tb/lib/test_arbiter.py", ""),
    "hw/memsys/bus/cell_fetch.py": ("tb/memsys/bus/test_fetches.py", ""),
    "hw/memsys/patches/cell_table.py": ("tb/memsys/patches/test_tables.py", ""),
    "hw/memsys/patches/local_patch_geometry.py": ("tb/memsys/patches/test_tables.py", ""),
    "hw/memsys/memory_system.py": ("tb/memsys/patches/test_memory_path.py", ""),
    "hw/memsys/bus/patch_fetch.py": ("tb/memsys/bus/test_fetches.py", ""),
    "hw/memsys/patches/patch_table.py": ("tb/memsys/patches/test_tables.py", ""),
    "hw/memsys/patches/patch_type_memory.py": ("tb/memsys/patches/test_tables.py", ""),
    **dict.fromkeys((f"hw/memsys/patches/{name}.py" for name in ("store_fill", "store_lookup", "store_read")),
                    ("tb/memsys/patches/test_patch_store.py", "PatchStore")),
    "radiosity/flow/synthesis/scan_harness.py": ("tb/radiosity/flow/synthesis/test_flow.py",
                                                 "synthesise_between_registers"),
}


def own_tests():
    return {path.stem.removeprefix("test_") for path in (ROOT / "tb").rglob("test_*.py")}


def test_units_without_tests_of_their_name_are_listed():
    tested = own_tests()
    missing = {path for path in components() if path.rpartition("/")[2].removesuffix(".py") not in tested}
    assert missing == set(TESTED_IN)


@pytest.mark.parametrize("path", TESTED_IN)
def test_the_test_that_is_listed_has_the_unit(path):
    file, through = TESTED_IN[path]
    names = [through] if through else components()[path]
    text = (ROOT / file).read_text()
    assert any(re.search(rf"\b{name}\b", text) for name in names), f"{file} does not name {', '.join(names)}"


# Modules that need no claims: of the simulator itself, of netlists, of bugs, of what pages draw, and of random items,
# which break what neighbours promise.
PLAIN = {"tb/lib/simulator.py", "tb/lib/test_checks.py", "tb/lib/test_collisions.py", "tb/coverage/test_reported.py",
         "tb/radiosity/flow/synthesis/test_mapped.py", "tb/bugs/test_rules.py", "tb/docs/timing_diagram.py",
         "tb/system/test_streams.py"}


def test_simulations_check_claims_and_show_collisions():
    """By `tb.lib.simulator.simulator_of`."""
    assert {path for path, text in source_texts("tb").items() if re.search(r"\bSimulator\(", text)} == PLAIN

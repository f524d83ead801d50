"""What stands on what: golden on nothing, hw on golden, radiosity on both, tb on all."""

import ast

import pytest

from tb.sources.source_trees import imports, source_trees

# All sources are parsed in one of pytest-xdist's processes.
pytestmark = pytest.mark.xdist_group("sources")

# By folder: packages that it must not import.
FORBIDDEN = {
    "golden": {"hw", "radiosity", "tb", "pytest"},
    "hw": {"radiosity", "tb", "pytest"},
    "radiosity": {"tb", "pytest"},
}
# What a component may take from golden beside the configuration and constants: the contents of tables, number formats,
# and what a network's routing is made of.
TABLES = {
    "golden.cordic": {"gain", "linear_error", "turns"},
    "golden.ctu.cell_traversal": {"reciprocal_table"},
    "golden.fixed": {"Format"},
    "golden.icu.sbb": {"sagitta_table", "window_errors"},
    "golden.icu.settle_code": {"scale"},
    "golden.noc.packing": {"check"},
    "golden.noc.reach": {"reach"},
    "golden.noc.routing": {"Routing", "check_deadlock_free", "route"},
    "golden.noc.topology": {"Topology"},
}
# Packages of golden that only drivers, the simulated machine and the commands of hw need.
WHOLE_MODEL = {"golden.cast", "golden.commands", "golden.light", "golden.scene", "golden.schedule"}
DRIVERS = ("hw/host.py", "hw/cli.py", "hw/commands/", "hw/simulator/", "hw/board/", "hw/package/software/")
# Blocks whose components import golden's numbers through one file, the list of what hardware and model must agree on.
BLOCK_TABLES = {"icu": {"hw/icu/icu_tables.py"}, "lib": {"hw/lib/cordic.py"}, "noc": {"hw/noc/noc_tables.py"}}


def component_files():
    """Files of hw that define components; the simulated machine may use all of golden."""
    for path, tree in source_trees("hw").items():
        bases = {ast.unparse(base) for node in ast.walk(tree) if isinstance(node, ast.ClassDef) for base in node.bases}
        if bases & {"wiring.Component", "Component"} and not path.startswith("hw/simulator/"):
            yield path, tree


@pytest.mark.parametrize("folder", FORBIDDEN)
def test_nothing_is_imported_from_above(folder):
    wrong = [f"{path}: {module}" for path, tree in source_trees(folder).items() for module, _ in imports(tree)
             if module.partition(".")[0] in FORBIDDEN[folder]]
    assert not wrong


def test_components_take_configuration_and_constants_from_golden():
    wrong = []
    for path, tree in component_files():
        for module, name in imports(tree):
            if module.partition(".")[0] == "golden" and not (
                    module.startswith("golden.config") or name.isupper() or name in TABLES.get(module, ())):
                wrong.append(f"{path}: {module}.{name}")
    assert not wrong


def test_the_check_sees_components():
    assert len(list(component_files())) > 80


def test_hardware_needs_no_caster_scene_or_scheduler():
    wrong = [f"{path}: {module}" for path, tree in source_trees("hw").items() if not path.startswith(DRIVERS)
             for module, name in imports(tree) if {".".join(module.split(".")[:2]), f"{module}.{name}"} & WHOLE_MODEL]
    assert not wrong


@pytest.mark.parametrize("block", BLOCK_TABLES)
def test_components_import_golden_numbers_through_tables(block):
    found = {path for path, tree in source_trees(f"hw/{block}").items() for module, _ in imports(tree)
             if module.startswith("golden.") and not module.startswith("golden.config")}
    assert found <= BLOCK_TABLES[block]

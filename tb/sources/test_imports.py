"""What stands on what: golden on nothing, hw on golden, radiosity on both, tb on all."""

import ast

import pytest

from tb.sources.source_trees import imports, source_trees

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

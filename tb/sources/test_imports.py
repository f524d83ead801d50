"""What stands on what: golden on nothing, hw on golden, radiosity on both, tb on all."""

import sys

import pytest

from tb.sources.source_texts import components, imports, source_texts

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
DRIVERS = ("hw/host.py", "hw/cli.py", "hw/commands/", "hw/simulator/", "hw/board/", "hw/package/software/",
           "hw/package/example/")
# Blocks whose components import golden's numbers through one file, the list of what hardware and model must agree on.
BLOCK_TABLES = {"icu": {"hw/icu/icu_tables.py"}, "lib": {"hw/lib/cordic.py"}, "noc": {"hw/noc/noc_tables.py"}}


@pytest.mark.parametrize("folder", FORBIDDEN)
def test_nothing_is_imported_from_above(folder):
    wrong = [f"{path}: {module}" for path, text in source_texts(folder).items() for module, _ in imports(text)
             if module.partition(".")[0] in FORBIDDEN[folder]]
    assert not wrong


def test_components_take_configuration_and_constants_from_golden():
    wrong = []
    for path in components():
        for module, name in imports(source_texts("hw")[path]):
            if module.partition(".")[0] == "golden" and not (
                    module.startswith("golden.config") or name.isupper() or name in TABLES.get(module, ())):
                wrong.append(f"{path}: {module}.{name}")
    assert not wrong


def test_references_of_hits_share_nothing_with_what_they_check():
    package = "radiosity.benchmarks.truth"
    wrong = [f"{path}: {module}" for path, text in source_texts(package.replace(".", "/")).items()
             for module, _ in imports(text) if not module.startswith(f"{package}.")
             and module.partition(".")[0] not in {*sys.stdlib_module_names, "numpy"}]
    assert not wrong


def test_the_check_sees_components_and_imports():
    assert len(components()) > 80
    text = "import a.b as c\nfrom d import (\n    e,  # f\n    g as h,\n)\nif i:\n    from j import k\n"
    assert set(imports(text)) == {("a.b", ""), ("d", "e"), ("d", "g"), ("j", "k")}


def test_hardware_needs_no_caster_scene_or_scheduler():
    wrong = [f"{path}: {module}" for path, text in source_texts("hw").items() if not path.startswith(DRIVERS)
             for module, name in imports(text) if {".".join(module.split(".")[:2]), f"{module}.{name}"} & WHOLE_MODEL]
    assert not wrong


@pytest.mark.parametrize("block", BLOCK_TABLES)
def test_components_import_golden_numbers_through_tables(block):
    found = {path for path, text in source_texts(f"hw/{block}").items() for module, _ in imports(text)
             if module.startswith("golden.") and not module.startswith("golden.config")}
    assert found <= BLOCK_TABLES[block]

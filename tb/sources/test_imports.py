"""What stands on what: the rooms of golden on each other, hw on the machine in integers, the product on both."""

import sys

import pytest

from tb.runs.shard import READERS
from tb.sources.source_texts import ROOT, components, imports, source_texts

OURS = {"golden", "hw", "radiosity", "benchmarks", "tb"}
# By room: the rooms that it may import, each of them in a row of its own.
MAY_IMPORT = {
    "golden.base": set(),
    "golden.scene": {"golden.base"},
    "golden.cast": {"golden.base", "golden.scene"},
    "golden.engine": {"golden.base", "golden.scene", "golden.cast"},
    "golden.light": {"golden.base", "golden.scene", "golden.cast"},
    "golden.render": {"golden.base", "golden.scene", "golden.cast", "golden.engine", "golden.light"},
    "hw": {"golden.engine"},
    "radiosity": {"golden.base", "golden.scene", "golden.cast", "golden.engine", "golden.light", "golden.render", "hw"},
    "benchmarks": {"golden.base", "golden.scene", "golden.cast", "golden.engine", "golden.light", "golden.render", "hw",
                   "radiosity"},
}
# Within the product, in the same way: simulators of machines and what is made of the RTL know nothing of tasks, and
# only the command line knows commands.
WITHIN_PRODUCT = {
    "radiosity.workers": set(),
    "radiosity.flow": set(),
    "radiosity.charts": set(),
    "radiosity.machines": {"radiosity.charts", "radiosity.flow"},
    "radiosity.tasks": {"radiosity.charts", "radiosity.flow", "radiosity.machines", "radiosity.workers"},
}
# What a person starts with ``python -m`` is in the product.
STARTS = {"golden/__main__.py", "hw/__main__.py"}
# What a component may take from golden beside the configuration and constants: the contents of tables, number formats,
# and what a network's routing is made of.
TABLES = {
    "golden.engine.lib.cordic": {"gain", "linear_error", "turns"},
    "golden.engine.ctu.cell_traversal": {"reciprocal_table"},
    "golden.engine.lib.fixed": {"Format"},
    "golden.engine.icu.sbb": {"sagitta_table", "window_errors"},
    "golden.engine.icu.settle_code": {"scale"},
    "golden.engine.noc.packing": {"check"},
    "golden.engine.noc.reach": {"reach"},
    "golden.engine.noc.routing": {"Routing", "check_deadlock_free", "route"},
    "golden.engine.noc.topology": {"Topology"},
}
# Blocks whose components import golden's numbers through one file, the list of what hardware and model must agree on.
BLOCK_TABLES = {"icu": {"hw/icu/icu_tables.py"}, "lib": {"hw/lib/cordic.py"}, "noc": {"hw/noc/noc_tables.py"}}


def test_every_room_has_a_row():
    rooms = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"golden", "tb"}
    rooms |= {f"golden.{path.parent.name}" for path in ROOT.glob("golden/*/__init__.py")}
    assert rooms == MAY_IMPORT.keys()


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_no_room_imports_one_above_it(room):
    assert not [wrong for wrong in arrows(room) if wrong[1] not in MAY_IMPORT[room]]


@pytest.mark.parametrize("room", WITHIN_PRODUCT)
def test_no_part_of_the_product_imports_one_above_it(room):
    assert not [wrong for wrong in arrows(room) if wrong[1] not in MAY_IMPORT["radiosity"] | WITHIN_PRODUCT[room]]


def arrows(room):
    """File and room of each import of another room of ours, in `TYPE_CHECKING` too."""
    for path, text in source_texts(room.replace(".", "/")).items():
        for module, name in imports(text):
            top, *rest = f"{module}.{name}".split(".")
            # Of golden, and of the product seen from within, a room is a folder; else it is the package.
            inner = top == "golden" or top == room.partition(".")[0] != room
            other = f"{top}.{rest[0]}" if inner and rest[0] else top
            if top in OURS and other != room and path not in STARTS:
                yield path, other


def test_no_file_imports_a_module_of_tests():
    """What tests share has a module of its own; those of `READERS` ask others for their cases."""
    assert not [(path, module, name) for path, text in source_texts("tb").items() for module, name in imports(text)
                if path.split("/")[1] not in READERS and module.startswith("tb.") and ".test_" in f".{module}.{name}"
                and module != path[:-3].replace("/", ".")]


def test_no_cycle_within_a_room():
    """Of all imports, within functions and under `TYPE_CHECKING` too."""
    texts = {path.removesuffix(".py").replace("/", ".").removesuffix(".__init__"): text
             for top in ("golden", "hw", "radiosity", "benchmarks") for path, text in source_texts(top).items()}
    assert not list(cycles({path: {one for module, name in imports(text)
                                    for one in (f"{module}.{name}", module) if one in texts}
                             for path, text in texts.items()}))


def cycles(targets):
    """Of the modules that each module imports, those that it reaches itself by; one by one what none leads to goes."""
    left = dict(targets)
    while leaves := [module for module, found in left.items() if not found & left.keys()]:
        for module in leaves:
            del left[module]
    yield from left


def test_cycles_are_seen():
    assert not list(cycles({"a": {"b", "c"}, "b": {"c"}, "c": set()}))
    assert set(cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()})) == {"a", "b", "c"}


def test_arrows_are_seen():
    assert {where for _, where in arrows("golden.light")} == MAY_IMPORT["golden.light"]
    assert "golden.engine" in {where for _, where in arrows("hw")}


def test_components_take_configuration_and_constants_from_golden():
    wrong = []
    for path in components():
        for module, name in imports((ROOT / path).read_text()):
            if module.partition(".")[0] == "golden" and not (
                    module.startswith("golden.engine.config") or name.isupper() or name in TABLES.get(module, ())):
                wrong.append(f"{path}: {module}.{name}")
    assert not wrong


def test_references_of_hits_share_nothing_with_what_they_check():
    package = "benchmarks.truth"
    wrong = [f"{path}: {module}" for path, text in source_texts(package.replace(".", "/")).items()
             for module, _ in imports(text) if not module.startswith(f"{package}.")
             and module.partition(".")[0] not in {*sys.stdlib_module_names, "numpy"}]
    assert not wrong


def test_the_check_sees_components_and_imports():
    assert len(components()) > 80
    text = "import a.b as c\nfrom d import (\n    e,  # f\n    g as h,\n)\nif i:\n    from j import k\n"
    assert set(imports(text)) == {("a.b", ""), ("d", "e"), ("d", "g"), ("j", "k")}


@pytest.mark.parametrize("block", BLOCK_TABLES)
def test_components_import_golden_numbers_through_tables(block):
    found = {path for path, text in source_texts(f"hw/{block}").items() for module, _ in imports(text)
             if module.startswith("golden.") and not module.startswith("golden.engine.config")}
    assert found <= BLOCK_TABLES[block]

"""Which package imports which: the table of docs/architecture.md."""

import ast

import pytest

from tb.docs.language import ROOT

# Golden's packages that only drivers, the simulated machine and the commands of hw need.
WHOLE_MODEL = {"golden.cast", "golden.commands", "golden.light", "golden.scene", "golden.schedule"}
DRIVERS = ("hw/host.py", "hw/cli.py", "hw/commands/", "hw/simulator/", "hw/board/")


def imported(path):
    """Modules that a file imports, by their first two names."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module] if "." in node.module else [f"{node.module}.{one.name}" for one in node.names]
        else:
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
        found |= {".".join(name.split(".")[:2]) for name in names}
    return found


@pytest.mark.parametrize(("package", "forbidden"), [
    ("golden", {"hw", "radiosity", "tb"}), ("hw", {"radiosity", "tb"}), ("radiosity", {"tb"})])
def test_packages_import_only_what_is_below_them(package, forbidden):
    wrong = {str(path.relative_to(ROOT)): names for path in (ROOT / package).rglob("*.py")
             if (names := {name for name in imported(path) if name.split(".")[0] in forbidden})}
    assert not wrong


def test_components_import_no_caster_scene_or_scheduler():
    found = {str(path.relative_to(ROOT)): imported(path) & WHOLE_MODEL for path in (ROOT / "hw").rglob("*.py")}
    assert not {name: names for name, names in found.items() if names and not name.startswith(DRIVERS)}


# Blocks of the hardware, and the files of each that may import more of golden than its configuration: what hardware and
# model must agree on. ``hw/lib/cordic.py`` has golden's table of angles.
BLOCKS = ("icu", "lib", "noc")
AGREEMENTS = {"hw/icu/icu_tables.py", "hw/noc/noc_tables.py", "hw/lib/cordic.py"}


@pytest.mark.parametrize("block", BLOCKS)
def test_components_import_golden_numbers_through_tables(block):
    found = {str(path.relative_to(ROOT)) for path in (ROOT / "hw" / block).rglob("*.py")
             if any(name.startswith("golden.") and name != "golden.config" for name in imported(path))}
    assert found <= AGREEMENTS

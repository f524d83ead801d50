"""The page's table of presets by part has the sizes that the configurations have."""

from golden.engine.config import PRESETS
from golden.engine.config.parts import parts
from tb.docs.language import ROOT


def test_the_table_is_made_from_the_configurations():
    table = [["part", *(f"`{preset}`" for preset in PRESETS)]]
    table += [[part.name, *sizes] for part, *sizes in zip(
        parts(PRESETS["tiny"]), *([part.size for part in parts(config)] for config in PRESETS.values()), strict=True)]
    header, *rows = (f"| {' | '.join(row)} |" for row in table)
    expected = "\n".join([header, "|" + "---|" * len(table[0]), *rows])
    assert expected in (ROOT / "docs" / "architecture.md").read_text(), expected

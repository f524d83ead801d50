"""Functions stay short: one that is longer than a hundred lines has a reason here."""

from tb.sources.source_texts import functions, source_texts

MOST = 100
ONE_LIST = "one pipeline, stage by stage; cut into methods it would pass its signals through attributes"
REASONS = {
    "hw/ctu/row_pieces.py: RowPieces.elaborate": ONE_LIST,
    "hw/icu/intersection_unit.py: IntersectionUnit.elaborate": "one netlist: submodules, then the streams between them",
    "hw/memsys/patches/istructure.py: IStructure.elaborate": ONE_LIST,
    "hw/memsys/load/preload_dma.py: PreloadDma.elaborate": ONE_LIST,
}


def test_long_functions_have_a_reason():
    found = {f"{path}: {name}": lines for folder in ("benchmarks", "golden", "hw", "radiosity", "tb")
             for path, text in source_texts(folder).items() for name, _, body in functions(text)
             if (lines := body.count("\n") + 1) > MOST}
    assert found.keys() == REASONS.keys(), {name: found.get(name) for name in found.keys() ^ REASONS.keys()}


def test_functions_end_before_what_is_no_deeper():
    text = ("class A:\n    def b(\n            self):\n        def c():\n            return {\n        }\n\n"
            "        return c\n\n    x = 1\n")
    assert [(name, line, body.count("\n") + 1) for name, line, body in functions(text)] == [
        ("A.b.c", 4, 3), ("A.b", 2, 7)]

import numpy as np

from golden.engine.ctu.sector import Sector
from golden.engine.icu.section_clip import section_clip
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from golden.engine.stimulus.icu.section_clip import draw_windows
from hw.icu.section_clip import SectionClip
from radiosity.flow.package.example.frustum_load import frustum_payload
from tb.icu.vectors import LIMITS, assert_all_occur, largest, section_window_of, slot_of, window_of
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import config_of
from tb.lib.runner import SLOW_IN_ICARUS

COUNT = 200
FRUSTA = (random_hemisphere, random_screen)
# First column, its end, first row, its end; None is the frustum's.
SECTIONS = [(0, None, 0, None), (0, 20, 3, 9), (7, None, 0, 5), (13, 14, 4, 5), (11, 43, 2, None)]


def clipped(frustum, bounds, config):
    """Frustum, section, windows and their parts."""
    random = np.random.default_rng(4)
    record = frustum(random, config, largest(config))
    first_column, end_column, first_row, end_row = bounds
    section = Sector(first_column, end_column or record.columns, first_row, end_row or record.rows)
    given = draw_windows(random, record, COUNT)
    return record, section, given, section_clip(given, section, record)


def drawn_sections(count):
    """Bounds anywhere in the largest frustum."""
    random, size = np.random.default_rng(5), np.array(largest(config_of({})))
    first = random.integers(size, size=(count, 2))
    return np.stack([first, random.integers(first, size) + 1], axis=2).reshape(count, 4).tolist()


def vectors_of(frustum, bounds):
    def vectors(config):
        record, section, given, parts = clipped(frustum, bounds, config)
        return Vectors(
            ports={"frustum": frustum_payload(record, section, config)},
            inputs={"i": [{**slot_of(k), "window": window_of(vars(given), k)} for k in range(COUNT)]},
            expected={"o": [{**slot_of(k), "window": section_window_of(parts, k)} for k in range(COUNT)]})

    return vectors


class TestSectionClip(Bench):
    component, variants, simulators = SectionClip, LIMITS, SLOW_IN_ICARUS
    cases = {f"{frustum.__name__}, {bounds}": Case(vectors_of(frustum, bounds), None if bounds in SECTIONS else [])
             for frustum in FRUSTA for bounds in (*SECTIONS, *drawn_sections(5))}


def test_the_vectors_hold_every_case():
    for frustum in FRUSTA:
        cases = {}
        for bounds in SECTIONS:
            _, section, given, parts = clipped(frustum, bounds, config_of({"icu.side_bits": 6}))
            rays, before = parts.rays > 0, given.column_first < section.first_column
            for name, found in (("clipped away", ~rays & (given.rays > 0)), ("empty", given.rays == 0),
                                ("begun before the section", rays & before), ("begun in the section", rays & ~before)):
                cases[name] = cases.get(name, False) | found.any()
            if frustum is random_hemisphere:
                wrapped = parts.wrapped_count > 0
                goes_round = ~before & (given.column_first >= section.end_column)
                for name, found in (("in two pieces", wrapped), ("gone round to the section", rays & goes_round)):
                    cases[name] = cases.get(name, False) | found.any()
        assert_all_occur(cases)

"""Golden's stimuli as payloads of the hardware's streams."""

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.stimulus import block
from golden.engine.stimulus.frusta import frustum_arrays, frustum_record
from radiosity.flow.package.example.frustum_load import frustum_payload
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage

__all__ = [
    "LIMITS",
    "SHADOWS",
    "WINDOW",
    "assert_all_occur",
    "factor_of",
    "frustum_of",
    "largest",
    "rows",
    "section_window_of",
    "seen_through",
    "slot_of",
    "vertex_key",
    "winding_of",
    "window_of",
]

# Configurations whose indices a frustum can fill.
LIMITS = [*CONFIGURATIONS.values(), {"icu.side_bits": 6}]
WINDOW = ("column_first", "column_count", "row_first", "row_count")
# Those that cast shadow frusta too.
SHADOWS = [{**widths, "icu.shadow_bits": 8} for widths in CONFIGURATIONS.values()]
# No bench of these blocks has another number of slots.
SLOTS = config_of({}).icu.slots


def frustum_of(given: dict, config: Config, section: Sector | None = None) -> dict:
    """The frustum of a stimulus, all of it or a section of it."""
    record = frustum_record(given, config)
    return frustum_payload(record, section or Sector.whole(record), config)


def largest(config: Config) -> tuple[int, int]:
    """Columns and rows of a frustum that fills all indices."""
    return 1 << config.icu.side_bits, 1 << config.icu.side_bits


def seen_through(record: FrustumRecord, name: str, *, count: int, seed: int, config: Config) -> dict:
    """Inputs and outputs of a block's stimulus, with ``record`` in place of the frustum that it draws."""
    _, drawn = block(name)
    given = drawn.draw(np.random.default_rng(seed), count, config) | frustum_arrays(record)
    return given | drawn.expect(given, config)


def assert_all_occur(cases: dict) -> None:
    """Each of the named conditions holds for at least one vector."""
    coverage = Coverage(cases)
    coverage.hit_all(cases)
    coverage.check()


def vertex_key(number: int) -> dict:
    """Slot and index of the vertices of patches one after the other."""
    return {"slot": number // 4 % SLOTS, "index": number % 4}


def slot_of(number: int) -> dict:
    """Slot of patches one after the other."""
    return {"slot": number % SLOTS}


def rows(array: np.ndarray) -> list:
    """An array as lists of Python's integers."""
    return np.asarray(array).tolist()


def winding_of(given: dict, k: int) -> dict:
    """`IcuFormats.winding` of patch ``k``."""
    return {"orientation": rows(given["orientation"][k]), "split": int(given["split"][k])}


def factor_of(given: dict, k: int) -> dict:
    """`IcuFormats.factor` of patch ``k``."""
    return {"mantissa": rows(given["mantissa"][k]), "exponent": int(given["factor_exponent"][k]),
            "dropped": int(given["dropped"][k])}


def window_of(window, k: int) -> dict:
    """`Formats.window` of patch ``k``, of a stimulus' arrays."""
    return {name: int(window[name][k]) for name in WINDOW}


def section_window_of(window, k: int) -> dict:
    """`IcuFormats.section_window` of patch ``k`` of a `SectionWindow`."""
    return {name: int(value[k]) for name, value in vars(window).items()}

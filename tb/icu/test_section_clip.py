import numpy as np
import pytest

from golden.ctu.sector import Sector
from golden.icu.section_clip import section_clip
from golden.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.section_clip import SectionClip
from tb.golden.icu.test_section_clip import windows
from tb.icu.frustum_load import frustum_payload
from tb.icu.vectors import section_window_of, slot_of, window_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return SectionClip(config=config)


def vectors(config):
    random = np.random.default_rng(4)
    record = random.choice([random_hemisphere, random_screen])(random, config)
    section = Sector(7, 43, 2, record.rows - 1)
    window = windows(random, record, 200)
    clipped = section_clip(window, section, record)
    return Vectors(
        ports={"frustum": frustum_payload(record, section, config)},
        items=[{**slot_of(k), "window": window_of(vars(window), k)} for k in range(200)],
        expected={"o": [{**slot_of(k), "window": section_window_of(clipped, k)} for k in range(200)]})


def test_every_width_and_depth():
    check_block(make, vectors, variants=[{}])


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("section_clip", make, vectors, simulator=simulator)

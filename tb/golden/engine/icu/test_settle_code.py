import numpy as np
import pytest

from golden.engine.config import Config
from golden.engine.icu.inverse_distance import decode
from golden.engine.icu.settle_code import settle_code, settle_floor, settle_threshold

CONFIGS = [Config(), Config().replace({"icu.settle_bits": 4, "icu.settle_fraction": 1})]


def stored(config):
    random = np.random.default_rng(1)
    edges = settle_floor(np.arange(config.icu.settle.high + 1), config)
    every = np.concatenate([edges, edges - 1, edges + 1, random.integers(0, config.numbers.inverse.high, 5000), [0, 1]])
    return np.clip(every, 0, config.numbers.inverse.high)


@pytest.mark.parametrize("config", CONFIGS, ids=["8", "4"])
def test_a_codes_floor_is_the_best_there_is_below_the_value(config):
    inverse = stored(config)
    code = settle_code(inverse, config)
    assert (settle_floor(code, config) <= inverse).all()
    more = code < config.icu.settle.high
    assert (settle_floor(code[more] + 1, config) > inverse[more]).all()
    assert code.min() == 0
    assert code.max() == config.icu.settle.high


@pytest.mark.parametrize("config", CONFIGS, ids=["8", "4"])
def test_a_threshold_skips_exactly_the_codes_whose_floor_is_beyond_the_bound(config):
    bound = np.maximum(stored(config), 1)
    codes = np.arange(config.icu.settle.high + 1)
    skipped = codes >= settle_threshold(bound, config)[:, None]
    assert (skipped == (settle_floor(codes, config) > bound[:, None])).all()


def test_codes_tell_distances_of_a_scene_apart():
    numbers = Config().numbers
    edges = decode(settle_floor(np.arange(1, 256), Config()), numbers)
    assert edges[0] < 1 / np.sqrt(3)
    assert edges[-1] > 100
    assert (edges[1:] / edges[:-1]).max() < 1.04

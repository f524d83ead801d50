import numpy as np

from golden.engine.icu.reciprocal import reciprocal


def test_every_mantissa_of_ten_bits_has_its_reciprocal_cut_off_to_ten_bits():
    mantissa = np.arange(512, 1024)
    result = reciprocal(mantissa, 10)
    assert result.min() >= 512
    assert result.max() < 1024
    assert result.tolist() == [min(2**19 // value, 1023) for value in mantissa.tolist()]


def test_a_reciprocal_is_never_too_large_by_more_than_rounding():
    mantissa = np.random.default_rng(1).integers(2**25, 2**26, 5000)
    exact = 2.0**51 / mantissa
    error = exact - reciprocal(mantissa, 26)
    assert error.min() >= 0
    assert error.max() < 1

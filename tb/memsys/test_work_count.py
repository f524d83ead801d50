"""Its arguments. tb/formal/memsys/test_work_count.py proves its behaviour."""

import pytest

from hw.memsys.work_count import WorkCount

SIZES = {"enters": 1, "leaves": 1, "most": 1}


@pytest.mark.parametrize("name", SIZES)
def test_sizes_must_be_numbers_of_something(name):
    with pytest.raises(ValueError, match=f"^{name.capitalize()} must be at least 1, not 0$"):
        WorkCount(**{**SIZES, name: 0})
    with pytest.raises(TypeError, match=f"^{name.capitalize()} must be"):
        WorkCount(**{**SIZES, name: 1.5})

"""The lines of a region have consecutive numbers, whatever lines it was given."""

import numpy as np

from radiosity.machines.merge.line_shares import divide_lines


def test_packed_lines_are_numbered_region_by_region():
    # 5 goes to region 0, 4 to region 1, 2 to region 1, and 1 to region 0; the line without pixels to none.
    lines = divide_lines("packed", np.array([5, 4, 0, 1, 2]), 2)
    assert lines.order.tolist() == [0, 3, 1, 4, 2]
    assert lines.bounds.tolist() == [0, 2, 4]
    assert lines.number.tolist() == [0, 2, 4, 1, 3]

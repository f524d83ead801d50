import numpy as np

from radiosity.workers.parcel import Parcel


class Shared:
    """Something that both ends have, and that cannot be pickled."""

    def __reduce__(self):
        raise AssertionError("it must not be pickled")


def test_a_copy_refers_to_what_its_process_knows():
    here, there = Shared(), Shared()
    parcel = Parcel.of({"table": np.arange(3), "scene": here, "again": [here]}, {"scene": here})
    copy = parcel.open({"scene": there})
    assert copy["table"].tolist() == [0, 1, 2]
    assert copy["scene"] is copy["again"][0] is there


def test_parcels_are_known_by_their_content():
    first, same, other = (Parcel.of(np.full(9, value), {}) for value in (1, 1, 2))
    assert first == same
    assert hash(first) == hash(same)
    assert first != other
    assert "content" not in repr(first)

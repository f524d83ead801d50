"""Options of compilations are equal as numba has them equal."""

from itertools import product

from numba.core.compiler import Flags

from golden.base import kernel_dispatcher


def test_options_are_equal_if_all_of_their_values_are():
    def flags(**given):
        found = Flags()
        for name, value in given.items():
            setattr(found, name, value)
        return found

    several = [flags(), flags(nrt=False), flags(nrt=True), flags(nrt=True), flags(nrt=True, release_gil=True),
               flags(error_model="numpy"), flags(nrt=True).copy()]
    for one, other in product(several, repeat=2):
        same = kernel_dispatcher._compare(one, other)
        assert (one == other) is same
        assert not same or hash(one) == hash(other)
    # One that is set to its default value is equal too.
    assert [several[0] == one for one in several] == [True, True, *[False] * 5]
    assert Flags() != 0

"""The distributor: patches leave the root one after the other, and arrive after a switch for each level."""

import pytest

from radiosity.machines.paper.distributor import Distributor


def test_a_patch_arrives_after_its_words_and_a_switch_for_each_level():
    assert Distributor(levels=0, switch=2).send(10, 1, words=5) == 15
    assert Distributor(levels=4, switch=2).send(10, 5, words=5) == 23
    assert Distributor(levels=4, switch=3).send(10, 5, words=9) == 31


def test_patches_wait_for_the_root_alone():
    tree = Distributor(levels=3, switch=2)
    assert [tree.send(time, 4, words=5) for time in (0, 0, 3, 40)] == [11, 16, 21, 51]
    assert tree.free == 45


def test_a_patch_to_more_clusters_takes_the_root_as_long():
    """That is what pushes a patch on both sides once, where clusters would request it one by one."""
    tree = Distributor(levels=3, switch=2)
    assert [tree.send(0, links, words=5) for links in (15, 4)] == [11, 16]
    assert (tree.root_words, tree.link_words) == (10, 5 * 19)


@pytest.mark.parametrize(("given", "error", "message"), [
    ({"levels": -1}, ValueError, "Levels must be at least 0, not -1"),
    ({"switch": 1.5}, TypeError, "Switch must be an int, not 1.5")])
def test_wrong_numbers(given, error, message):
    with pytest.raises(error, match=f"^{message}$"):
        Distributor(**{"levels": 1, "switch": 2, **given})

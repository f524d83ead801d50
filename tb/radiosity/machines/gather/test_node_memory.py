"""What fits a node: of the source's scenes those that it has times of."""

import pytest

from golden.base.errors import InputError
from radiosity.machines.gather.node_memory import PATCH_WORDS, SQUARES, NodeMemory

pytestmark = pytest.mark.usefixtures("interpreted")

# Patches and entries of the source's scenes, with the least numbers of nodes that it has times of (table 2.1; one node
# in the text).
SCENES = {2600: (1_804_647, 8), 2208: (1_468_539, 8), 1728: (746_779, 4), 1412: (461_947, 2), 1000: (342_003, 1),
          886: (303_146, 1)}


@pytest.mark.parametrize("patches", SCENES)
def test_a_scene_fits_the_least_number_of_nodes_with_times_and_no_fewer(patches):
    """In equal shares, rows fit with the patches of one node and a travelling block; half as many nodes are too few."""
    entries, least = SCENES[patches]
    for nodes, fits in ((least, True), (least // 2, False)):
        if nodes:
            own = patches // nodes * (1 + (nodes > 1))
            rows = NodeMemory.row_bytes(entries / nodes) + 8 * (patches / nodes - 1)
            assert (rows <= NodeMemory().free(own)) == fits


def test_rows_have_what_hemicube_patches_and_system_leave():
    assert SQUARES == 30_000
    assert NodeMemory(size=400_000, reserved=1000).free(10) == 399_000 - 8 * 30_000 - 10 * 4 * PATCH_WORDS
    assert NodeMemory.row_bytes(5) == 8 * 5 + 8


def test_a_memory_without_bytes_for_rows_is_refused():
    with pytest.raises(InputError, match="Memory must be more than 1288768 bytes for a node with 2 patches and no row, "
                                         "not 1288768"):
        NodeMemory(size=(1 << 20) + 240_000 + 192).free(2)
    with pytest.raises(ValueError, match="Size must be at least 1, not 0"):
        NodeMemory(size=0)

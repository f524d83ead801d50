"""The pages to which a tile refers are those of its pixels."""

import numpy as np
import pytest

from benchmarks.koan import referred_pages
from radiosity.machines.koan.pixel_items import pixel_items
from radiosity.machines.koan.ray_pages import PageString
from radiosity.machines.koan.scene_pages import ScenePages

pytestmark = pytest.mark.xdist_group("machines")


def test_a_tile_refers_to_the_pages_of_its_pixels():
    rng = np.random.default_rng(2)
    counts = rng.integers(0, 5, 48)
    layout = ScenePages(cells=900, entries=900, patches=20, page_bytes=512)
    string = PageString(first=np.append(0, counts.cumsum()), page=rng.integers(0, len(layout), counts.sum()),
                        distinct=counts, touches=counts)
    items = pixel_items((8, 6), 4)
    found = referred_pages(layout, string, items)
    for node, (top, left) in enumerate([(0, 0), (0, 4), (3, 0), (3, 4)]):
        pixels = [row * 8 + column for row in range(top, top + 3) for column in range(left, left + 4)]
        pages = np.concatenate([string.page[string.first[one]:string.first[one + 1]] for one in pixels])
        assert np.flatnonzero(found[node]).tolist() == np.unique(pages).tolist()

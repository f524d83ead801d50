"""Patches of which all vertices are 0, among others, and the coordinates that no patch of a scene has."""

import numpy as np

from golden.engine.config import Numbers
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene
from hw.formats import VERTICES
from hw.memsys.patches.void_check import VoidCheck
from tb.lib.bench import Bench

ZERO = [0, 0, 0]


class TestVoidCheck(Bench):
    component, variants = VoidCheck, ({},)

    def model(self, config):
        """Whatever is there in the cycles in which none moves."""
        vertices = []
        given = yield
        while True:
            index = len(vertices) % VERTICES
            void = index == VERTICES - 1 and [*vertices[-index:], given.vertex] == [ZERO] * VERTICES
            if given.moves:
                vertices.append(given.vertex)
            given = yield {"index": index, "void": void and given.moves}

    def drive(self, given, random):
        """Half of the patches have a vertex with one bit, a corner of the coordinates."""
        high = self.config().numbers.scene.high
        given.vertex = random.choice([[1, 0, 0], [0, high, 0], [0, 0, high ^ high >> 1]]) if (
            random.random() < 0.15) else ZERO


def test_no_coordinate_of_a_scene_is_0():
    """With as few bits as numbers can have."""
    for bits in (12, 24):
        numbers = Numbers(scene_bits=bits, vector_fraction=10)
        vertices = PatchGeometry.of(builtin_scene("cornell"), numbers).vertices
        assert vertices.min() > 0
        assert np.count_nonzero(vertices == vertices.min(axis=(0, 1))), "vertices at the lower corner among them"

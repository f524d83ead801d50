"""A worker computes what a parcel says on the scene that came with it, whatever it has computed before."""

from dataclasses import replace

import pytest

from golden.base.errors import InputError
from golden.scene.builtin import builtin_scene
from radiosity.workers.parcel import Parcel
from radiosity.workers.proof import Proof
from radiosity.workers.remote import known_objects, run_span


class Corners:
    """The sum of a scene's patches from the first to the last, and the method's caster of rays."""

    def __init__(self, scene, rays, power):
        self.scene, self.rays, self.power = scene, rays, power

    def __call__(self, first, last):
        assert hasattr(self.rays, "nearest")
        return float((self.scene.areas[first:last] ** self.power).sum())


@pytest.fixture(scope="module")
def proof():
    return Proof.of_this_process("grid")


def test_the_same_work_on_another_scene_is_computed_there(proof):
    """The parcel of the work names the scene and does not hold it: it is the same one for all scenes."""
    scenes = [builtin_scene(name) for name in ("cornell", "furnace:2")]
    held = [Parcel.of(scene, {}) for scene in scenes]
    casters = object(), object()
    works = {power: [Parcel.of(Corners(scene, casters[1], power), known_objects(scene, *casters))
                     for scene in scenes] for power in (1, 2)}
    assert works[1][0] == works[1][1] != works[2][0]
    for number, power in (0, 1), (1, 1), (0, 1), (0, 2), (1, 2), (1, 1):
        for first, last in (0, 3), (2, 5):
            assert run_span(proof, 0.5, held[number], works[power][number], first, last) == float(
                (scenes[number].areas[first:last] ** power).sum()), (number, power, first)


def test_work_with_another_proof_is_refused(proof):
    other = replace(proof, canary="0" * 64)
    with pytest.raises(InputError, match="worker on "):
        run_span(other, 0.5, Parcel.of(builtin_scene("cornell"), {}), Parcel.of(len, {}), 0, 1)

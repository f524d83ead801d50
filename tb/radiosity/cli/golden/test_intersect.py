"""`intersect` asks its caster what the file asks, and reports what that found; all figures differ."""

from types import SimpleNamespace

import numpy as np
import pytest

from golden.cast import methods
from golden.cast.rays import Hits
from tb.radiosity.cli.golden.runner import report, run

RAYS = {"origin": np.zeros((4, 3)), "direction": np.eye(4, 3) + 1}
NEAREST, ANY = (Hits(patch=np.array(patch), t=np.arange(4.0), u=np.full(4, 0.25), v=np.full(4, 0.5),
                     tests=np.array(tests), steps=np.array(steps))
                for patch, tests, steps in (((3, -1, 0, 5), (1, 2, 3, 4), (5, 6, 7, 9)),
                                            ((-1, -1, 2, -1), (2, 2, 2, 1), (8, 0, 0, 0))))


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(methods, "ray_caster", lambda scene, method, progress: SimpleNamespace(
        nearest=lambda rays: NEAREST, any_hit=lambda rays: ANY))
    return tmp_path


@pytest.mark.parametrize(("more", "hits", "count", "tests", "steps"), [
    ({}, NEAREST, 3, 2.5, 6.75), ({"tmax": np.ones(4)}, ANY, 1, 1.75, 2.0)])
def test_the_report_is_of_the_hits(more, hits, count, tests, steps):
    np.savez("rays.npz", **RAYS, **more)
    assert report("intersect", "furnace:1", "rays.npz", "-o", "a.npz") == {
        "output": "a.npz", "rays": 4, "hits": count, "tests_per_ray": tests, "cell_steps_per_ray": steps}
    with np.load("a.npz") as written:
        for name in written.files:
            np.testing.assert_array_equal(written[name], getattr(hits, name))


def test_the_rays_are_not_written_over():
    np.savez("rays.npz", **RAYS)
    assert "'rays.npz': it is the input" in run("intersect", "furnace:1", "rays.npz", "-o", "rays.npz").stderr

"""The cast store explores each cast once, and no two casts that differ share one."""

from dataclasses import replace

import numpy as np
import pytest

import radiosity.machines.engine.cast_store
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.subshells import SubshellList
from golden.scene.builtin import builtin_scene
from radiosity.machines.engine.cast_store import CastStore
from radiosity.machines.engine.cluster_latencies import cluster_timing
from tb.golden.engine.cast.drawn_shadows import drawn_frustum

CONFIG = PRESETS["tiny"]


@pytest.fixture
def explored(monkeypatch):
    """What has been explored, instead of the casts."""
    calls = []
    monkeypatch.setattr(radiosity.machines.engine.cast_store, "cast_section",
                        lambda *given, **more: calls.append((given, more)) or len(calls))
    return calls


@pytest.fixture
def geometry():
    return PatchGeometry.of(builtin_scene("cornell"), CONFIG.numbers)


@pytest.fixture
def store(geometry):
    return CastStore(Shelling(geometry, CONFIG, cell=0.5, by_code=True), CONFIG, cluster_timing(CONFIG))


@pytest.mark.parametrize(("name", "other"), [("source_digest", "of another commit"),
                                             ("library_versions", {"numpy": "0"})])
def test_casts_of_other_code_are_explored_again(geometry, explored, monkeypatch, tmp_path, name, other):
    monkeypatch.setattr(radiosity.machines.engine.cast_store, "_write", lambda path, cast: path.write_text(str(cast)))
    monkeypatch.setattr(radiosity.machines.engine.cast_store, "_read", lambda path: int(path.read_text()))
    shelling = Shelling(geometry, CONFIG, cell=0.5, by_code=True)
    frustum = hemisphere_record(Hemisphere(16, 4), geometry.coordinates, geometry.coordinates.bounds.mean(axis=0),
                                (0, 0, 1))

    def cast():
        return CastStore(shelling, CONFIG, cluster_timing(CONFIG), folder=tmp_path).cast(frustum, Sector.whole(frustum))

    assert [cast(), cast()] == [1, 1]
    monkeypatch.setattr(radiosity.machines.engine.cast_store, name, lambda: other)
    assert [cast(), cast()] == [2, 2]


@pytest.mark.parametrize("spoil", [lambda data: b"", lambda data: data[:len(data) // 2], lambda data: b"rubbish"],
                         ids=["empty", "torn", "of another kind"])
def test_a_cast_that_cannot_be_read_is_explored_again(geometry, tmp_path, spoil):
    shelling = Shelling(geometry, CONFIG, cell=0.5, by_code=True)
    frustum = hemisphere_record(Hemisphere(16, 4), geometry.coordinates, geometry.coordinates.bounds.mean(axis=0),
                                (0, 0, 1))

    def cast():
        return CastStore(shelling, CONFIG, cluster_timing(CONFIG), folder=tmp_path).cast(frustum, Sector.whole(frustum))

    first = cast()
    path, = tmp_path.iterdir()
    written = path.read_bytes()
    path.write_bytes(spoil(written))
    again = cast()
    assert path.read_bytes() == written
    for one in (again, cast()):
        assert one.tests == first.tests
        np.testing.assert_array_equal(one.times.ends, first.times.ends)


def test_each_cast_is_explored_once(geometry, store, explored):
    frusta = [hemisphere_record(Hemisphere(16, 4), geometry.coordinates, geometry.coordinates.bounds.mean(axis=0),
                                (0, 0, turn), source=source)
              for turn, source in ((1.0, 2), (-1.0, 2), (1.0, 3))]
    whole = Sector.whole(frusta[0])
    half = replace(whole, end_column=whole.end_column // 2)
    plain = SubshellList(*np.array([[4, 7], [3, 5]]))
    lists = None, plain, replace(plain, shell=np.array([3, 6])), replace(plain, patches=np.array([4, 8]))
    given = [(frustum, whole, None) for frustum in frusta] + [(frusta[0], half, None)]
    given += [(frusta[0], whole, subshells) for subshells in lists[1:]]
    _, shadow, _ = drawn_frustum(1, bits=4)
    shorter = replace(shadow, end=np.where(shadow.end < CONFIG.numbers.inverse.high, shadow.end + 1, shadow.end))
    given += [(one, Sector.whole(one), None) for one in (shadow, shorter)]
    found = [store.cast(*one) for one in given]
    assert found == list(range(1, len(given) + 1))
    assert [store.cast(*one) for one in given] == found
    assert len(explored) == len(given)

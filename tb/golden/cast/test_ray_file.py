import zipfile

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.ray_file import read_rays, write_hits
from golden.cast.rays import Hits

ORIGIN = np.array([[0.0, 0, 0], [1, 2, 3]])
DIRECTION = np.array([[0.0, 0, 1], [1, 0, 0]])


def test_rays_come_back_as_they_were_written(tmp_path):
    np.savez(tmp_path / "r.npz", origin=ORIGIN.astype(np.float32), direction=DIRECTION.astype(int), note="ignored")
    rays, any_hit = read_rays(tmp_path / "r.npz")
    np.testing.assert_array_equal(rays.origin, ORIGIN)
    np.testing.assert_array_equal(rays.direction, DIRECTION)
    assert not any_hit
    assert (rays.tmax == np.inf).all()


def test_tmax_requests_any_hit(tmp_path):
    np.savez(tmp_path / "r.npz", origin=ORIGIN, direction=DIRECTION, tmax=[2.0, np.inf])
    rays, any_hit = read_rays(tmp_path / "r.npz")
    assert any_hit
    assert rays.tmax.tolist() == [2, np.inf]


@pytest.mark.parametrize(("arrays", "message"), [
    ({"origin": ORIGIN}, "array 'direction'"),
    ({"origin": ORIGIN, "direction": DIRECTION[:1]}, "as many rows"),
    ({"origin": ORIGIN, "direction": DIRECTION, "tmax": [1.0, np.nan]}, "not NaN"),
    ({"origin": ORIGIN, "direction": DIRECTION + 1j}, "real numbers"),
    ({"origin": ORIGIN, "direction": np.full((2, 3), "east")}, "real numbers"),
    ({"origin": ORIGIN, "direction": np.full((2, 3), None)}, "archive of numbers"),
])
def test_unusable_arrays_are_named(tmp_path, arrays, message):
    np.savez(tmp_path / "r.npz", **arrays)
    with pytest.raises(InputError, match=message) as caught:
        read_rays(tmp_path / "r.npz")
    assert "r.npz" in str(caught.value)


@pytest.mark.parametrize("name", ["origin", "direction", "tmax"])
def test_a_member_that_is_no_array_is_named(tmp_path, name):
    arrays = {"origin": ORIGIN, "direction": DIRECTION, "tmax": [2.0, np.inf]}
    del arrays[name]
    np.savez(tmp_path / "r.npz", **arrays)
    with zipfile.ZipFile(tmp_path / "r.npz", "a") as archive:
        archive.writestr(name, "0 0 0")
    with pytest.raises(InputError, match=f"{name.capitalize()} must hold real numbers"):
        read_rays(tmp_path / "r.npz")


def test_files_that_are_no_archive_are_refused(tmp_path):
    np.savez(tmp_path / "whole.npz", origin=ORIGIN, direction=DIRECTION)
    np.save(tmp_path / "single.npy", ORIGIN)
    (tmp_path / "half.npz").write_bytes((tmp_path / "whole.npz").read_bytes()[:200])
    (tmp_path / "text.npz").write_text("0 0 0")
    (tmp_path / "empty.npz").write_text("")
    for name in ("missing.npz", "single.npy", "half.npz", "text.npz", "empty.npz", "."):
        with pytest.raises(InputError, match="rays"):
            read_rays(tmp_path / name)


def test_damaged_array_is_refused(tmp_path):
    np.savez(tmp_path / "r.npz", origin=ORIGIN, direction=DIRECTION)
    content = bytearray((tmp_path / "r.npz").read_bytes())
    content[150] ^= 0xFF  # in the data of the first array: its checksum no longer fits
    (tmp_path / "r.npz").write_bytes(content)
    with pytest.raises(InputError, match="CRC"):
        read_rays(tmp_path / "r.npz")


def test_hits_are_written_as_four_arrays_and_the_same_bytes_each_time(tmp_path):
    row = np.array([0.25, 0.5])
    hits = Hits(np.array([3, -1], dtype=np.int32), row, row + 1, row + 2, np.ones(2, int), np.ones(2, int))
    write_hits(tmp_path / "a.npz", hits)
    write_hits(tmp_path / "b.npz", hits)
    with np.load(tmp_path / "a.npz") as stored:
        assert sorted(stored.files) == ["patch", "t", "u", "v"]
        for name in stored.files:
            np.testing.assert_array_equal(stored[name], getattr(hits, name))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()

import shutil
from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.base.library_versions import library_versions
from golden.cast.grid import Grid
from golden.light.factors import blocks
from golden.light.factors.blocks import BlockStore, scene_key
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.npz_file import write_npz
from golden.light.factors.rows import FactorRows
from golden.scene.builtin import builtin_scene

KEY = {"scene": "abc", "rays": "16x4"}


class Rows(HemisphereRows):
    """Rows whose computation ends after some blocks."""

    def __init__(self, scene, *, last=99, block_rows=7):
        super().__init__(scene, Grid(scene, 0.5, jobs=1), rays=(16, 4), block_rows=block_rows)
        self.last, self.computed = last, []

    def rows(self, first, last):
        if len(self.computed) == self.last:
            raise KeyboardInterrupt
        self.computed.append(first)
        return super().rows(first, last)


@pytest.fixture
def scene():
    return builtin_scene("furnace:2")


def content(rows, path, store=None):
    write_npz(compute_view_factors(rows, store=store), path)
    return path.read_bytes()


def test_a_resumed_run_computes_the_missing_blocks_and_gives_the_same_bytes(scene, tmp_path):
    folder = tmp_path / "blocks"
    killed, resumed = Rows(scene, last=2), Rows(scene)
    with pytest.raises(KeyboardInterrupt):
        compute_view_factors(killed, store=BlockStore(folder, KEY, resume=False))
    store = BlockStore(folder, KEY, resume=True)
    assert content(resumed, tmp_path / "F.npz", store) == content(Rows(scene), tmp_path / "G.npz")
    assert (killed.computed, resumed.computed) == ([0, 7], [14, 21])
    store.remove()
    assert not folder.exists()


def test_threads_do_not_change_the_bytes(scene, tmp_path):
    folder, found = tmp_path / "blocks", []
    for jobs in (1, 3):
        rows = FactorRows(scene, Grid(scene, 0.5, jobs=jobs), error=0.1, block_rows=2)
        found.append(content(rows, tmp_path / "F.npz", BlockStore(folder, KEY, resume=True)))
        assert len(list(folder.glob("rows-*.npz"))) == 12
        shutil.rmtree(folder)
    assert found[0] == found[1]


def test_work_of_one_block_is_not_kept(scene, tmp_path):
    compute_view_factors(Rows(scene, block_rows=24), store=BlockStore(tmp_path / "blocks", KEY, resume=True))
    assert not (tmp_path / "blocks").exists()


def unfinished(scene, folder):
    with pytest.raises(KeyboardInterrupt):
        compute_view_factors(Rows(scene, last=1), store=BlockStore(folder, KEY, resume=False))


def test_unfinished_work_is_not_overwritten(scene, tmp_path):
    unfinished(scene, tmp_path / "blocks")
    with pytest.raises(InputError, match="continue it by --resume, or delete it"):
        BlockStore(tmp_path / "blocks", KEY, resume=False)


def test_blocks_of_other_work_are_refused(scene, tmp_path):
    unfinished(scene, tmp_path / "blocks")
    with pytest.raises(InputError, match="other values of rays, samples"):
        BlockStore(tmp_path / "blocks", {"scene": "abc", "rays": "16x8", "samples": 2}, resume=True)


def test_blocks_of_other_sources_of_the_same_version_are_refused(scene, tmp_path, monkeypatch):
    unfinished(scene, tmp_path / "blocks")
    monkeypatch.setattr(blocks, "source_digest", lambda: "of another commit")
    with pytest.raises(InputError, match="other values of sources"):
        BlockStore(tmp_path / "blocks", KEY, resume=True)


def test_blocks_of_another_version_of_a_library_are_refused(scene, tmp_path, monkeypatch):
    unfinished(scene, tmp_path / "blocks")
    versions = library_versions()
    for name in versions:
        monkeypatch.setattr(blocks, "library_versions", lambda method, name=name: {**versions, name: "0"})
        with pytest.raises(InputError, match=f"other values of {name}$"):
            BlockStore(tmp_path / "blocks", KEY, resume=True)


@pytest.mark.parametrize(("name", "message"), [("run.json", "run.json cannot be read"),
                                               ("rows-00000000.npz", "no block of view factors")])
def test_files_that_are_none_of_a_run_are_refused(scene, tmp_path, name, message):
    folder = tmp_path / "blocks"
    unfinished(scene, folder)
    written = (folder / name).read_bytes()
    for spoilt in (b"rubbish", b"", written[:len(written) // 2]):
        (folder / name).write_bytes(spoilt)
        with pytest.raises(InputError, match=message):
            compute_view_factors(Rows(scene), store=BlockStore(folder, KEY, resume=True))


def test_other_files_of_the_folder_stay(scene, tmp_path):
    folder = tmp_path / "blocks"
    unfinished(scene, folder)
    (folder / "notes.txt").write_text("mine")
    (folder / ".rows-00000007.part1234.npz").write_text("of a killed run")
    BlockStore(folder, KEY, resume=True).remove()
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]


def test_the_key_of_a_scene_is_that_of_its_patches():
    keys = {scene_key(builtin_scene(name)) for name in ("furnace:1", "furnace:2", "cornell")}
    assert len(keys) == 3
    scene = builtin_scene("furnace:1")
    assert scene_key(scene) in keys
    changed = (replace(scene, two_sided=~scene.two_sided), replace(scene, surface=scene.surface[::-1]))
    assert len(keys | {scene_key(one) for one in changed}) == 5


def test_hemispheres_share_out_what_their_rays_meet(scene):
    factors = compute_view_factors(Rows(scene))
    assert factors.closure < 1e-15
    assert (factors.row_sums == 2**factors.weight_bits).all()
    assert set(factors.surface) == {"wall"}
    np.testing.assert_allclose(factors.area, 0.25)

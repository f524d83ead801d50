"""Pictures merged by nodes: a scene's polygons, and the steps by which regions come to their nodes."""

import numpy as np

from golden.cast.default_camera import default_camera
from golden.light.image import label_colours
from golden.scene.scene import Scene
from radiosity.machines.merge.merge_run import MergeRun, MergeScheme, simulate_merge
from radiosity.machines.merge.screen_triangles import project_scene
from radiosity.machines.merge.volume_run import VolumeRun

__all__ = ["MergeMachine", "framed", "region_frames", "volume_picture"]

# Pixels between frames, frames in a row, and the most frames.
_GAP, _ROW, _MOST = 4, 6, 12


class MergeMachine:
    """Simulates machines that merge the pictures of one scene, whose patches are projected once.

    Parameters
    ----------
    scene
        The patches; without a camera it is seen as by ``render``.
    size
        Width and height of the screen.
    """

    def __init__(self, scene: Scene, *, size: tuple[int, int]):
        self._size = dict(zip(("width", "height"), size, strict=True))
        self._triangles, self._number = project_scene(scene, scene.camera or default_camera(scene), *size)

    def run(self, scheme: MergeScheme, *, nodes: int, watch=None) -> MergeRun:
        """Simulate all phases, see `simulate_merge`."""
        return simulate_merge(self._triangles, self._number, scheme, nodes=nodes, watch=watch, **self._size)

    def frames(self, scheme: MergeScheme, *, nodes: int) -> np.ndarray:
        """H x W x 3 uint8: the screen before the merge and after each step, up to 12 of all steps.

        A location has the colour of the first node that has a pixel of it, the darker the more nodes have one.
        """
        found, width, height = [], *self._size.values()

        def keep(pixels, lines):
            line, x = np.divmod(pixels.location, width)
            at = lines.order[line] * width + x
            node = np.repeat(np.arange(nodes), np.diff(pixels.start))
            first, count = np.full(width * height, nodes), np.bincount(at, minlength=width * height)
            np.minimum.at(first, at, node)
            colour = label_colours(np.where(count > 0, first, -1)) * (0.3 + 0.7 / np.maximum(count, 1))[:, None]
            found.append(colour.astype(np.uint8).reshape(height, width, 3))

        self.run(scheme, nodes=nodes, watch=keep)
        chosen = np.unique(np.linspace(0, len(found) - 1, min(len(found), _MOST)).round().astype(int))
        return framed([found[one] for one in chosen])


def framed(frames: list[np.ndarray]) -> np.ndarray:
    """Pictures of one size side by side, up to six in a row, on white."""
    height, width = frames[0].shape[:2]
    columns, rows = min(len(frames), _ROW), -(-len(frames) // _ROW)
    sheet = np.full((rows * (height + _GAP) - _GAP, columns * (width + _GAP) - _GAP, 3), 255, dtype=np.uint8)
    for number, frame in enumerate(frames):
        top, left = (height + _GAP) * (number // _ROW), (width + _GAP) * (number % _ROW)
        sheet[top:top + height, left:left + width] = frame
    return sheet


def volume_picture(run: VolumeRun) -> np.ndarray:
    """H x W x 3 uint8 of a volume before black."""
    return np.rint(255 * np.clip(run.work.picture[..., :3], 0, 1)).astype(np.uint8)


def region_frames(run: VolumeRun) -> np.ndarray:
    """H x W x 3 uint8: the regions after each level of the splitter, over the picture."""
    picture = volume_picture(run)
    return framed([(0.5 * label_colours(owner) + 0.5 * picture).astype(np.uint8) for owner in run.split.levels])

"""Where the pictures of a file are on the patches of a scene."""

from dataclasses import dataclass

import numpy as np

from golden.scene.texture import Texture
from golden.scene.unused import Unused

__all__ = ["MOST_KEPT", "SLACK", "FaceTextures", "Textures", "face_mappings"]

MOST_KEPT = 1 << 28
"""Most pixels of all pictures of a scene: 768 MiB. Further ones count with their means over faces."""

SLACK = 1e-3
"""Largest difference of texture coordinates that counts as none."""

FLATTEST = 1e-13
"""Least spread of a face's corners across it, squared, over that along it: below it a face is a line."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Textures:
    """Pictures on N patches or faces.

    The texture coordinates of a patch are an affine function of the position, which parts of it inherit.

    Parameters
    ----------
    pictures
        The pictures.
    picture
        N int: the picture of each patch, or -1 without one.
    mapping
        N x 2 x 4: texture coordinates are the first three columns times the position, plus the last one.
    colour
        N x 3: the linear colour of the picture that the patch's material has for all of the patch.
    """

    pictures: tuple[Texture, ...]
    picture: np.ndarray
    mapping: np.ndarray
    colour: np.ndarray

    def __len__(self) -> int:
        return len(self.picture)

    def of(self, patches: np.ndarray) -> "Textures":
        """Those of patches with the given numbers, or of parts of them."""
        return Textures(pictures=self.pictures, picture=self.picture[patches], mapping=self.mapping[patches],
                        colour=self.colour[patches])

    def alike(self, one: np.ndarray, other: np.ndarray, points: np.ndarray) -> np.ndarray:
        """K bool: pairs of patches have one picture, at the same texture coordinates in K x P x 3 points."""
        here, there = self._coordinates(one[:, None], points), self._coordinates(other[:, None], points)
        near = (np.abs(here - there) <= SLACK).all(axis=(1, 2))
        return (self.picture[one] == self.picture[other]) & (near | (self.picture[one] < 0))

    def ratio(self, patch: np.ndarray, position: np.ndarray) -> np.ndarray:
        """The picture's colours at K x 3 positions on patches over the material's, K x 3; 1 without a picture."""
        result = np.ones((len(patch), 3))
        for rows, picture in self._by_picture(patch):
            self._divide(result, rows, patch, picture.at(self._coordinates(patch[rows], position[rows])))
        return result

    def mean_ratio(self, patch: np.ndarray, corners: np.ndarray) -> np.ndarray:
        """The means of `ratio` over K x 4 x 3 parts of patches; the fourth corner of a triangle repeats the third."""
        result = np.ones((len(patch), 3))
        for rows, picture in self._by_picture(patch):
            halves = corners[rows][:, [[0, 1, 2], [0, 2, 3]]]
            uv = self._coordinates(patch[rows][:, None, None], halves)
            areas = np.linalg.norm(np.cross(halves[:, :, 1] - halves[:, :, 0], halves[:, :, 2] - halves[:, :, 0]),
                                   axis=2)
            means = picture.means(uv.reshape(-1, 3, 2)).reshape(-1, 2, 3)
            self._divide(result, rows, patch, np.einsum("kh,khc->kc", areas / areas.sum(axis=1, keepdims=True), means))
        return result

    def _by_picture(self, patch):
        picture = self.picture[patch]
        for number in np.unique(picture[picture >= 0]).tolist():
            yield np.flatnonzero(picture == number), self.pictures[number]

    def _divide(self, result, rows, patch, colours):
        whole = self.colour[patch[rows]]
        result[rows] = np.divide(colours, whole, out=np.ones_like(colours), where=whole > 0)

    def _coordinates(self, patch, points):
        mapping = self.mapping[patch]
        return np.einsum("...xk,...k->...x", mapping[..., :3], points) + mapping[..., 3]


class FaceTextures:
    """Collects the pictures of a mesh's faces.

    Members
    -------
    bent
        Faces within which texture coordinates are no affine function of the position.
    beyond
        Faces with pictures that exceed `MOST_KEPT`.
    """

    def __init__(self):
        self._pictures: dict[Texture, int] = {}
        self._kept = 0
        self._parts: list[tuple[np.ndarray, ...]] = []
        self.bent = self.beyond = 0

    def add(self, texture: Texture, faces: np.ndarray, *, points: np.ndarray, uv: np.ndarray, counts: np.ndarray,
            colour: np.ndarray) -> None:
        """Puts a picture on F faces.

        Those that are counted in ``bent`` or ``beyond`` get none.

        Parameters
        ----------
        texture
            The picture.
        faces
            Numbers of the faces.
        points, uv, counts
            Their corners, see `face_mappings`.
        colour
            F x 3, see `Textures`.
        """
        if texture not in self._pictures:
            if self._kept + texture.pixels > MOST_KEPT:
                self.beyond += len(faces)
                return
            self._kept += texture.pixels
            self._pictures[texture] = len(self._pictures)
        mapping, is_affine = face_mappings(points, uv, counts)
        self.bent += int((~is_affine).sum())
        self._parts.append((faces[is_affine], np.full(is_affine.sum(), self._pictures[texture]), mapping[is_affine],
                            colour[is_affine]))

    def add_unused(self, unused: Unused) -> None:
        """Counts the faces on which a picture is not seen."""
        unused.add("texture coordinates that are not affine on a face", self.bent)
        unused.add(f"texture coordinates on pictures beyond {MOST_KEPT} pixels in all", self.beyond)

    def build(self, count: int) -> Textures | None:
        """The pictures on ``count`` faces, or None without any."""
        if not self._parts:
            return None
        faces, picture, mapping, colour = (np.concatenate(column) for column in zip(*self._parts, strict=True))
        textures = Textures(pictures=tuple(self._pictures), picture=np.full(count, -1),
                            mapping=np.zeros((count, 2, 4)), colour=np.ones((count, 3)))
        textures.picture[faces], textures.mapping[faces], textures.colour[faces] = picture, mapping, colour
        return textures


def face_mappings(points: np.ndarray, uv: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The affine functions from positions to texture coordinates that fit the corners of F faces best.

    Parameters
    ----------
    points, uv
        C x 3 positions and C x 2 texture coordinates of the corners, one face after the other.
    counts
        F numbers of corners.

    Returns
    -------
    mapping
        F x 2 x 4, see `Textures`.
    is_affine
        F bool: all corners have their texture coordinates within `SLACK`.
    """
    starts, face = np.cumsum(counts) - counts, np.repeat(np.arange(len(counts)), counts)
    centre, middle = (np.add.reduceat(values, starts) / counts[:, None] for values in (points, uv))
    along, across = points - centre[face], uv - middle[face]
    spread = np.add.reduceat(along[:, :, None] * along[:, None], starts)
    joint = np.add.reduceat(across[:, :, None] * along[:, None], starts)
    linear = joint @ np.linalg.pinv(spread, rcond=FLATTEST, hermitian=True)
    mapping = np.concatenate([linear, (middle - np.einsum("fxk,fk->fx", linear, centre))[:, :, None]], axis=2)
    error = np.abs(np.einsum("cxk,ck->cx", linear[face], along) - across).max(axis=1)
    return mapping, np.maximum.reduceat(error, starts) <= SLACK

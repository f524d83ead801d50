"""Faces of a file as patches: doubled, facing either way, of one- and two-sided materials, whole or in halves."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from golden.scene.material import Material
from golden.scene.mesh import Mesh, mesh_scene
from tb.lib.schedules import SETTINGS

# The corners of a square, by which its faces go, and a point within each.
QUAD = {"quad": ((0, 1, 2, 3), [(0.3, 0.2)])}
HALVES = {"lower": ((0, 1, 2), [(0.7, 0.2)]), "upper": ((0, 2, 3), [(0.3, 0.8)])}


@st.composite
def faces(draw):
    """Of squares apart from one another: number, corners in any rotation, material, and the point."""
    found = []
    for square in range(draw(st.integers(1, 3))):
        pieces = draw(st.sampled_from((QUAD, HALVES)))
        for _ in range(draw(st.integers(1, 5))):
            corners, (point,) = pieces[draw(st.sampled_from(sorted(pieces)))]
            front = draw(st.booleans())
            corners = corners if front else corners[::-1]
            turn = draw(st.integers(0, len(corners) - 1))
            corners = corners[turn:] + corners[:turn]
            found.append((square, corners, draw(st.integers(0, 2)), point, front))
    return draw(st.permutations(found))


def holds(patch, point):
    """Whether a convex patch in the plane z = 0 has a point inside, however it is wound."""
    sides = np.roll(patch, -1, axis=0) - patch
    sides, away = sides[np.abs(sides).any(axis=1)], (point - patch)[np.abs(sides).any(axis=1)]
    winding = sides[:, 0] * away[:, 1] - sides[:, 1] * away[:, 0]
    return (winding > 0).all() or (winding < 0).all()


@pytest.mark.filterwarnings("ignore:not used. faces in the place of an earlier one")
@settings(SETTINGS, max_examples=60)
@given(faces())
@example([(0, (0, 1, 2), 1, (0.7, 0.2), True), (0, (0, 2, 3), 1, (0.3, 0.8), True),
          (0, (2, 0, 3), 1, (0.3, 0.8), False)])
def test_the_first_of_doubled_faces_counts_and_either_side_keeps_its_own_opaque_material(given):
    """It is two-sided if the first that faces the other way has its material, or one of the two is transparent.

    Halves of a square become one patch only if they have one material and one kind of sides, and face one way.
    """
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    points = np.concatenate([square + np.array((2 * number, 0, 0)) for number in range(3)])
    mesh = Mesh(points=points, counts=np.array([len(corners) for _, corners, *_ in given]),
                corners=np.array([4 * number + corner for number, corners, *_ in given for corner in corners]),
                material=np.array([material for _, _, material, *_ in given]), one_sided=np.array([False, True, False]),
                materials=(Material(name="sheet", diffuse=(0.5,) * 3), Material(name="front", diffuse=(0.2,) * 3),
                           Material(name="pane", transparent=(0.5,) * 3, refraction_index=1)))
    scene = mesh_scene(mesh, name="drawn", where="a.obj")
    sides, area = {}, {}
    for number, corners, material, (x, y), front in given:
        area[2 * number + x, y] = (len(corners) - 2) / 2
        sides.setdefault((2 * number + x, y), {}).setdefault(front, material)
    whole = 0.0
    for point, of in sides.items():
        (front, material), *others = of.items()
        two_sided = material != 1 or bool(others)
        expected = {(front, mesh.materials[material], two_sided)}
        if others and others[0][1] != material and 2 not in (material, others[0][1]):
            expected = {(front, mesh.materials[material], False), (not front, mesh.materials[others[0][1]], False)}
        whole += area[point] * len(expected)
        found = [patch for patch in range(len(scene)) if holds(scene.vertices[patch, :, :2], point)]
        assert len(found) == len(expected)
        assert {(bool(scene.normals[patch, 2] > 0), scene.materials[scene.material[patch]],
                 bool(scene.two_sided[patch])) for patch in found} == expected
        assert len(set(scene.surface[found].tolist())) == 1
        assert set(scene.facing(np.array(found), np.tile([0.0, 0, -1], (len(found), 1)))) == {
            patch for patch in found if len(found) == 1 or scene.normals[patch, 2] > 0}
    assert scene.areas.sum() == whole


def test_triangles_of_a_glass_body_are_turned_outwards():
    """Of a tetrahedron, whichever way all of them are wound."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=float)
    glass = Material(name="glass", transparent=(1.0, 1, 1), refraction_index=1.5)
    for turned in ([], [0, 1, 2, 3]):
        picks = [face[::-1] if number in turned else face
                 for number, face in enumerate(((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)))]
        scene = mesh_scene(Mesh(points=corners, counts=np.full(4, 3), corners=np.array(picks).ravel(),
                                material=np.zeros(4, dtype=int), materials=(glass,), one_sided=np.array([True])),
                           name="body", where="a.obj")
        assert scene.is_triangle.all()
        assert (np.einsum("ij,ij->i", scene.normals, scene.vertices[:, :3].mean(axis=1)) > 0).all()

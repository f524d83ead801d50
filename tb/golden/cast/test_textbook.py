"""Fixed point against the textbook and against Embree, from the vertices on: no setup of patches or frames is shared.

A ray may hit another patch only where the formats explain it. A direction is off by at most twelve half units of 2^-16
(docs/exactness.md) and a vertex direction V' by 2^-17 per component; a vertex at the distance t is off by less than
2^-22 sqrt(3) of the cube's side in each frame, which turns its direction by 2^-20/t. The plane of a patch at the
distance h from the origin turns with its vertices; at grazing incidence, h much smaller than t, its depth is off by the
share (t/h) of the angle.
"""

import numpy as np
import pytest

from golden.cast.embree import Embree
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.cast.screen import Screen
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.icu.inverse_distance import decode
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.material import Material
from tb.golden.cast.textbook import Textbook, hemisphere_directions, screen_directions
from tb.golden.engine.icu.patches import CONFIG
from tb.golden.soups import soup

ANGLE = 12 * 2.0**-17 + np.sqrt(3) * 2.0**-17
RAYS = (16, 16)


def axes_of(seed):
    """Right-handed axes in any attitude."""
    axes = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    axes[2] = np.cross(axes[0], axes[1])
    return axes


def fixed(record, geometry):
    """Hits by brute force, which shelling has to equal."""
    naive = NaiveFixed(geometry, CONFIG).cast(record)
    assert len(Shelling(geometry, CONFIG, cell=0.125).cast(record)[0].differences(naive)) == 0
    return naive


def compare(scene, geometry, origin, direction, hits, *, source=-1):
    """Check patches and distances; number of rays that hit other patches, all explained."""
    textbook = Textbook(scene.vertices, scene.surface == source if source >= 0 else np.zeros(len(scene), dtype=bool))
    patch, t = textbook.nearest(origin, direction)
    scale = geometry.coordinates.scale
    length = np.linalg.norm(direction, axis=1)
    far = np.where(np.isfinite(t), t, 1.0) * length * scale
    differ = np.flatnonzero(patch != hits.patch)
    angle = ANGLE + 2.0**-20 / far
    assert textbook.may_be(hits.patch[differ], origin, direction[differ], angle=angle[differ],
                           depth=grazing(scene, hits.patch[differ], origin, direction[differ]) * angle[differ]).all()
    same = np.flatnonzero((patch == hits.patch) & (patch >= 0))
    stored = decode(hits.inverse[same], CONFIG.numbers) * scale
    # In the frustum's frame a direction is as long as the ray's, but for its rounding.
    share = 2.0**-17 + (1 + grazing(scene, patch[same], origin, direction[same])) * angle[same]
    assert (np.abs(stored * t[same] - 1) <= share).all()
    return len(differ)


def grazing(scene, patch, origin, direction):
    """Distance along the ray over distance of the patch's plane, t/h."""
    normal = scene.normals[patch]
    unit = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return 1 / np.maximum(np.abs(np.einsum("ki,ki->k", normal, unit)), 1e-9)


def hemisphere_of(scene, origin, axes, source=-1):
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [origin])
    record = hemisphere_record(Hemisphere(*RAYS), geometry.coordinates, origin, axes[2], axes=axes, source=source)
    return geometry, record, hemisphere_directions(axes, *RAYS)


def check_rooms(name, seeds):
    scene, differing = builtin_scene(name), 0
    for seed in seeds:
        random = np.random.default_rng(seed)
        origin = scene.bounds[0] + random.uniform(0.1, 0.9, 3) * (scene.bounds[1] - scene.bounds[0])
        geometry, record, direction = hemisphere_of(scene, origin, axes_of(seed))
        differing += compare(scene, geometry, origin, direction, fixed(record, geometry))
    assert differing <= 0.01 * len(seeds) * RAYS[0] * RAYS[1]


ROOMS = pytest.mark.parametrize("name", ["cornell", "lobby", "room1627", "teapot:4"])


@ROOMS
def test_rooms_have_the_hits_of_the_textbook(name):
    check_rooms(name, range(3))


@pytest.mark.nightly
@ROOMS
def test_rooms_have_the_hits_of_the_textbook_from_many_points(name):
    check_rooms(name, range(3, 30))


@pytest.mark.parametrize("seed", range(4))
def test_a_patch_sees_what_the_textbook_says(seed):
    scene, random = builtin_scene("cornell"), np.random.default_rng(seed)
    patch = int(random.integers(len(scene)))
    origin, normal = random.dirichlet(np.ones(3)) @ scene.vertices[patch, :3], scene.normals[patch]
    first = np.cross(normal, [0.3, 0.5, 0.7])
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(normal, first), normal])
    source = int(scene.surface[patch])
    geometry, record, direction = hemisphere_of(scene, origin, axes, source)
    compare(scene, geometry, origin, direction, fixed(record, geometry), source=source)


@pytest.mark.parametrize(("seed", "fov"), list(enumerate([5, 60, 130])))
def test_soups_on_a_screen_have_the_hits_of_the_textbook(seed, fov):
    scene, random = soup(seed, 40), np.random.default_rng(seed)
    eye, target = random.uniform(*scene.bounds), random.uniform(*scene.bounds)
    camera = Camera(eye=tuple(eye), target=tuple(target), up=(0.1, 0.2, 0.9), fov=float(fov))
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [eye])
    record = screen_record(Screen(camera=camera, width=27, height=16), geometry.coordinates)
    direction = screen_directions(eye, target, (0.1, 0.2, 0.9), fov, 27, 16)
    naive = fixed(record, geometry)
    textbook = Textbook(scene.vertices, np.zeros(len(scene), dtype=bool))
    patch, t = textbook.nearest(eye, direction)
    differ = np.flatnonzero(patch != naive.patch)
    # Slopes beyond one are scaled to the table's range.
    angle = (1 + np.tan(np.radians(fov) / 2) * 27 / 16) * ANGLE + 2.0**-20 / geometry.coordinates.scale / np.where(
        np.isfinite(t), t, 1)
    assert textbook.may_be(naive.patch[differ], eye, direction[differ], angle=angle[differ],
                           depth=grazing(scene, naive.patch[differ], eye, direction[differ]) * angle[differ]).all()
    assert len(differ) < 0.03 * len(record)


@pytest.mark.parametrize("name", ["tetra:3", "gears"])
def test_hits_are_those_of_embree(name):
    scene = builtin_scene(name)
    textbook, total = Textbook(scene.vertices, np.zeros(len(scene), dtype=bool)), 0
    for seed in range(2):
        origin = scene.bounds[0] + np.random.default_rng(seed).uniform(0.1, 0.9, 3) * np.ptp(scene.bounds, axis=0)
        geometry, record, direction = hemisphere_of(scene, origin, axes_of(seed + 7))
        hits = NaiveFixed(geometry, CONFIG).cast(record)
        theirs = Embree(scene).nearest_patches(Rays(np.broadcast_to(origin, direction.shape), direction))
        differ = np.flatnonzero(hits.patch != theirs)
        for patch in hits.patch[differ], theirs[differ]:
            assert textbook.may_be(patch, origin, direction[differ], angle=2 * ANGLE, depth=grazing(
                scene, patch, origin, direction[differ]) * 2 * ANGLE).all()
        total += len(differ)
    assert total < 0.01 * 2 * len(record)


def lattice(*, diagonal=False):
    """A cube of 4 x 4 squares on each side, seen from inside; rays from its centre can pass through its edges."""
    step, faces = np.linspace(-1, 1, 5), []
    for axis in range(3):
        for side in (-1, 1):
            for x in range(4):
                for y in range(4):
                    corners = [(step[x], step[y]), (step[x + 1], step[y]), (step[x + 1], step[y + 1]),
                               (step[x], step[y + 1])]
                    quad = np.array([np.insert(np.array(corner), axis, side) for corner in corners])
                    faces += [quad[[0, 1, 2, 2]], quad[[0, 2, 3, 3]]] if diagonal else [quad]
    builder = SceneBuilder("lattice")
    builder.add(np.array(faces), Material(name="paint"))
    return builder.build()


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("screen", [False, True])
def test_rays_through_edges_and_vertices_hit_a_patch_beside_them(diagonal, screen):
    scene, origin = lattice(diagonal=diagonal), np.zeros(3)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [origin])
    if screen:
        # A pixel is half a square, so every other line of pixels is on a line of the lattice.
        camera = Camera(eye=(0, 0, 0), target=(1, 0, 0), up=(0, 0, 1), fov=float(np.degrees(2 * np.arctan(9 / 8))))
        record = screen_record(Screen(camera=camera, width=9, height=9), geometry.coordinates)
        direction = screen_directions((0, 0, 0), (1, 0, 0), (0, 0, 1), camera.fov, 9, 9)
    else:
        # Four azimuths around x: all rays are in the planes of the diagonals.
        axes = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=float)
        record = hemisphere_record(Hemisphere(4, 16), geometry.coordinates, origin, (1, 0, 0), axes=axes)
        direction = hemisphere_directions(axes, 4, 16)
    hits = fixed(record, geometry)
    assert (hits.patch >= 0).all(), "a closed scene loses no ray"
    textbook = Textbook(scene.vertices, np.zeros(len(scene), dtype=bool))
    assert textbook.may_be(hits.patch, origin, direction, angle=2 * ANGLE, depth=2 * ANGLE).all()
    # Rays through an edge: turned a little they hit several patches.
    turns = 2 * ANGLE * np.random.default_rng(0).normal(size=(8, 1, 3))
    nearest = np.sort([textbook.nearest(origin, direction + turn)[0] for turn in turns], axis=0)
    assert (np.diff(nearest, axis=0) > 0).any(axis=0).sum() > len(record) // 5


def degenerate(random, count):
    """Quads with repeated vertices, three vertices on a line, and lines and points, beside plain ones."""
    corner, first, second = random.uniform(-1, 1, (count, 3)), *random.normal(size=(2, count, 3)) * 0.4
    quads = np.stack([corner, corner + first, corner + first + second, corner + second], axis=1)
    kind = np.arange(count) % 6
    quads[kind == 1, 3] = quads[kind == 1, 2]
    quads[kind == 2, 1] = quads[kind == 2, 0]
    quads[kind == 3, 1] = (quads[kind == 3, 0] + quads[kind == 3, 2]) / 2
    quads[kind == 4, 2:] = quads[kind == 4, :2][:, ::-1]
    return quads, kind


@pytest.mark.parametrize("seed", range(2))
def test_degenerate_quads_are_hit_where_the_textbook_hits_their_triangles(seed):
    random = np.random.default_rng(seed)
    quads, kind = degenerate(random, 48)
    builder = SceneBuilder("plain")
    builder.add(np.array([[[-3, -3, -3], [3, -3, -3], [3, 3, 3], [-3, 3, 3]]]), Material(name="paint"))
    coordinates = PatchGeometry.of(builder.build(), CONFIG.numbers).coordinates
    vertices = coordinates.integers(quads)
    vertices[kind == 5, 1:] = vertices[kind == 5, :1]
    geometry = PatchGeometry(coordinates=coordinates, vertices=vertices, surface=np.arange(48, dtype=np.int32))
    exact, origin, axes = coordinates.points(vertices), random.uniform(-0.2, 0.2, 3), axes_of(seed)
    record = hemisphere_record(Hemisphere(*RAYS), coordinates, origin, axes[2], axes=axes)
    hits = NaiveFixed(geometry, CONFIG).cast(record)
    assert len(Shelling(geometry, CONFIG, cell=0.25).cast(record)[0].differences(hits)) == 0
    assert not np.isin(hits.patch, np.flatnonzero((kind == 4) | (kind == 5))).any()
    assert {1, 2, 3} <= set(kind[hits.patch[hits.patch >= 0]].tolist())
    direction = hemisphere_directions(axes, *RAYS)
    textbook = Textbook(exact, np.zeros(48, dtype=bool))
    patch, _ = textbook.nearest(origin, direction)
    differ = np.flatnonzero(patch != hits.patch)
    assert textbook.may_be(hits.patch[differ], origin, direction[differ], angle=ANGLE + 1e-5, depth=1e-3).all()
    assert len(differ) < 0.02 * len(record)

"""Golden's hits against rational geometry of the same vertices and directions, and that geometry against itself."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.independent_hits import exact_geometry, ray_directions, rule_hits
from benchmarks.truth.exact_geometry import CAUSES, ExactGeometry
from benchmarks.truth.exact_patch import ExactPatch
from benchmarks.truth.integers import cross, dot
from benchmarks.truth.rule_patch import RulePatch
from benchmarks.viewpoints import CONFIG, hard_records
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import Numbers
from golden.scene.open import open_scene
from tb.golden.cast.fixed_cases import long_edge
from tb.golden.soups import soup

# `make nightly` has the larger ones.
SCENES = ("cornell", "lobby", *(pytest.param(name, marks=pytest.mark.nightly)
                                for name in ("room1627", "teapot:4", "tetra:3")))
# A matrix of 1: G offsets are R vectors. The origin is the cube's middle.
ONE, MIDDLE = (np.eye(3) * 2**16).astype(int), np.full(3, 2**23)


def frusta(scene, seed, numbers=CONFIG.numbers, *, origins=2):
    return hard_records(scene, origins=origins, rays=(32, 16), pixels=(24, 18), seed=seed, numbers=numbers)


def verdicts(geometry, records, config=CONFIG):
    for record in records:
        hits = NaiveFixed(geometry, config).cast(record)
        yield exact_geometry(record, geometry).verdict(hits.patch, hits.inverse)


@pytest.mark.parametrize("height", [1e-2, 1e-4])
def test_an_edge_much_nearer_than_it_is_long_moves_within_its_bound(height):
    for seed in range(2):
        _, geometry, record = long_edge(seed, height)
        verdict, = verdicts(geometry, [record])
        assert (verdict.causes["unexplained"], verdict.beyond) == (0, 0)
        assert verdict.causes["edge"] or height > 1e-3


@pytest.mark.parametrize("scene", [*SCENES, *range(4)], ids=str)
def test_hits_differ_from_exact_geometry_only_within_the_bounds(scene):
    """Rooms, and soups of slivers and of patches at one depth."""
    scene = soup(scene) if isinstance(scene, int) else open_scene(scene)
    for verdict in verdicts(*frusta(scene, 3, origins=1 if len(scene) > 500 else 2)):
        assert (verdict.causes["unexplained"], verdict.beyond) == (0, 0)
        assert verdict.causes.total() < 0.01 * verdict.rays


@pytest.mark.nightly
@pytest.mark.parametrize("first", range(10, 70, 10))
def test_many_hits_differ_from_the_rule_never_and_from_exact_geometry_within_the_bounds(first):
    for seed in range(first, first + 10):
        geometry, records = hard_records(soup(seed), origins=6, rays=(64, 32), pixels=(48, 36), seed=seed)
        for record in records:
            hits, rule = NaiveFixed(geometry, CONFIG).cast(record), rule_hits(record, geometry)
            assert all((getattr(hits, field) == values).all() for field, values in vars(rule).items())
            verdict = exact_geometry(record, geometry).verdict(hits.patch, hits.inverse)
            assert (verdict.causes["unexplained"], verdict.beyond) == (0, 0)


@pytest.mark.parametrize("seed", range(3))
def test_exact_hits_are_those_of_fractions_alone(seed):
    """Neither tiles nor float64: every patch against every ray, one after the other."""
    scene = soup(seed, 20)
    geometry, records = hard_records(scene, origins=1, rays=(8, 8), pixels=(6, 5), seed=seed)
    for record in records:
        patches = {number: ExactPatch(corners=corners, matrix=record.matrix.tolist(), origin=record.origin.tolist())
                   for number, corners in enumerate(geometry.vertices.tolist())
                   if record.source < 0 or geometry.surface[number] != record.source}
        expected = []
        for ray in ray_directions(record).reshape(-1, 3).tolist():
            met = [(inverse, -number) for number, patch in patches.items()
                   if not patch.is_dropped and (inverse := patch.inverse(ray)) is not None]
            expected.append(-max(met)[1] if met else -1)
        assert exact_geometry(record, geometry).patch.tolist() == expected


@pytest.mark.parametrize(("narrow", "beyond"), [({"vertex_bits": 10}, "unexplained"), ({"mantissa_bits": 18}, "depth")])
def test_narrower_numbers_go_beyond_the_bounds(narrow, beyond):
    """The bounds are those of the default formats and no wider."""
    config, found = replace(CONFIG, numbers=Numbers(**narrow)), Counter()
    for verdict in verdicts(*frusta(open_scene("lobby"), 1, config.numbers, origins=1), config):
        found.update({"unexplained": verdict.causes["unexplained"], "depth": verdict.beyond})
    assert found[beyond] > 3


def test_an_edge_moves_within_its_bound_and_by_a_third_of_it():
    """Drawn edges, and rays beside them for which the rule of the pages has the sign opposite to the exact one."""
    random, shares = np.random.default_rng(1), []
    for _ in range(1500):
        corners = MIDDLE + random.integers(-(2**22), 2**22, (4, 3)) // 4 ** random.integers(0, 6, (4, 1))
        given = {"corners": corners.tolist(), "matrix": ONE.tolist(), "origin": MIDDLE.tolist()}
        exact = ExactPatch(**given)
        ends = np.array(exact.vertices[:2], float)
        between = (ends / np.abs(ends).max(axis=1, keepdims=True) * random.random((2, 1))).sum(axis=0)
        ray = np.rint(between / np.abs(between).max() * 2**16).astype(int).tolist()
        if dot(RulePatch(**given).planes[0, 1], ray) * dot(cross(*exact.vertices[:2]), ray) < 0:
            shares.append(exact.edge_share(ray))
    assert len(shares) > 100
    assert None not in shares
    assert max(shares) > 1 / 3


def quad(x, z, width=8):
    """A square from ``x`` to the right at depth ``z``, in 64ths of the cube."""
    return MIDDLE + 2**18 * np.array([[x, -4, z], [x + width, -4, z], [x + width, 4, z], [x, 4, z]])


@pytest.mark.parametrize(("cause", "patches", "rounded", "nearest"), [
    ("tie", [quad(-8, 16), quad(0, 16)], 1, 0),
    ("depth", [quad(-4, 16), quad(-4, 16) + np.array([0, 0, 1])], 1, 0),
    ("edge", [quad(-8, 16) - [1, 0, 0], quad(-2, 17)], 0, 1),
    ("edge", [quad(-8, 16) - [1, 0, 0]], 0, -1),
    ("edge", [quad(-8, 16), quad(-4, 17)], 1, 0),
    ("unexplained", [quad(-8, 16) - [999, 0, 0], quad(-2, 17)], 0, 1),
    ("unexplained", [quad(-4, 16), quad(-4, 17)], 1, 0),
    ("unexplained", [quad(-4, 16)], -1, 0),
])
def test_every_cause_is_named(cause, patches, rounded, nearest):
    """One ray, straight ahead."""
    geometry = ExactGeometry(corners=np.array(patches), matrix=ONE, origin=MIDDLE, directions=[[[0, 0, 2**16]]])
    assert geometry.patch.tolist() == [nearest]
    causes = geometry.verdict(np.array([rounded]), np.array([0])).causes
    assert causes == Counter({**dict.fromkeys(CAUSES, 0), cause: 1})


def test_a_stored_distance_beyond_its_bound_is_counted():
    geometry = ExactGeometry(corners=[quad(-4, 16)], matrix=ONE, origin=MIDDLE, directions=[[[0, 0, 2**16]]])
    # A quarter of the cube away: 1/t is 4, whose exponent is 2 above the bias.
    stored = 41 << 18
    for off, beyond in (0, 0), (-1, 0), (-4, 1), (4, 1), (1 << 18, 1):
        assert geometry.verdict(np.array([0]), np.array([stored + off])).beyond == beyond

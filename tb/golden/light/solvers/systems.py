"""Radiosity systems whose solutions are known."""

from functools import cache

import numpy as np

from benchmarks.analytic import point_to_polygon
from golden.cast.grid import Grid
from golden.light.form_factors import gauss_points
from golden.light.solvers import RadiositySystem
from golden.scene.builtin import builtin_scene
from tb.golden.light.cube import cube
from tb.golden.light.hemisphere_factors import hemisphere_factors

__all__ = ["CUTS", "DUCT_FACTORS", "DUCT_RADIOSITY", "duct", "exact", "furnace", "lit_cube", "random_system"]

DUCT_FACTORS = np.array([(0, 1 / 3, 2 / 3), (1 / 4, 0, 3 / 4), (2 / 5, 3 / 5, 0)])
DUCT_RADIOSITY = np.array([1.08920188, 0.29107981, 0.12206573])

# Patches along an edge of the lit cube.
CUTS = 8


def duct(form_factors=DUCT_FACTORS):
    """Triangular duct with sides 3, 4, 5; red is the published case, green half of it, blue dark."""
    return RadiositySystem(
        form_factors=form_factors, area=(3, 4, 5),
        reflectance=np.outer((0.5, 0.8, 0.2), (1, 1, 1)), emission=np.outer((1, 0, 0), (1, 0.5, 0)),
        centre=[(1.5, 0, 0), (3, 2, 0), (1.5, 2, 0)], normal=[(0, 1, 0), (-1, 0, 0), (0.8, -0.6, 0)])


def _in_room(scene, factors, reflectance, emission):
    return RadiositySystem(form_factors=factors, reflectance=reflectance, emission=emission, area=scene.areas,
                           centre=scene.vertices.mean(axis=1), normal=scene.normals)


@cache
def _furnace():
    scene = builtin_scene("furnace:4")
    return scene, hemisphere_factors(scene, Grid(scene), rays=(64, 16)).F.toarray()


def furnace(reflectance):
    """Closed cube of 96 patches that all emit 1; form factors by casting."""
    scene, factors = _furnace()
    return _in_room(scene, factors, np.full((len(scene), 3), reflectance), np.ones((len(scene), 3)))


@cache
def lit_cube(kind):
    """Cube with a black ceiling that emits 1 and faces of reflectance 0.5; form factors ``analytic`` or ``cast``."""
    scene = cube(CUTS)
    if kind == "cast":
        factors = hemisphere_factors(scene, Grid(scene), rays=(64, 16)).F.toarray()
    else:
        points, shares = gauss_points(scene, 2)
        seen = point_to_polygon(points.reshape(-1, 3), np.repeat(scene.normals, 4, axis=0), scene.vertices)
        factors = np.einsum("is,isj->ij", shares, seen.reshape(len(scene), 4, -1))
    ceiling = np.zeros((len(scene), 3))
    ceiling[CUTS**2:2 * CUTS**2] = 1
    return _in_room(scene, factors, 0.5 * (1 - ceiling), ceiling)


def random_system(generator):
    """A system such as scenes give, and worse: open or closed, without reciprocity, with black and dark patches."""
    count = int(generator.integers(2, 100))
    weights = generator.random((count, count)) * (generator.random((count, count)) < generator.choice([0.1, 0.5, 1]))
    np.fill_diagonal(weights, 0)
    factors = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-9)
    if generator.random() < 0.5:
        factors *= generator.random((count, 1))
    reflectance = generator.random((count, 3)) * generator.choice([0.3, 0.9, 0.99])
    reflectance[generator.random(count) < 0.1] = 0
    emission = generator.random((count, 3)) * (generator.random((count, 1)) < 0.2) * (1, 1e-3, 0)
    return RadiositySystem(
        form_factors=factors, reflectance=reflectance, emission=emission,
        area=np.exp(generator.normal(size=count) * generator.choice([0, 1, 3])),
        centre=generator.random((count, 3)), normal=np.tile((0.0, 0, 1), (count, 1)))


def exact(system):
    """The solution by elimination."""
    identity = np.eye(len(system))
    return np.stack([np.linalg.solve(identity - system.reflectance[:, c, None] * system.matrix, system.emission[:, c])
                     for c in range(3)], axis=1)

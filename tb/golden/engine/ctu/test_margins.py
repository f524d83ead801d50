"""The margins of shelling are sufficient: each is its derivation in docs/exactness.md, no point of an adversarial
geometry is beyond it, and the worst points come within a tenth of it.

How tight they are: depth, horizon, the border of the screen and the azimuths of a cap are attained. The angle is
attained but for the arc between a cell's centre and its grid ray, 7 % of it at shell 3 and 1 % at shell 10. The density
loses what a whole number of rows and columns loses. The slack of a direction is a third above twelve half units, its
derivation in all formats; random frusta attain a quarter of the derivation.
"""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config, Numbers
from golden.engine.ctu import margins
from golden.engine.ctu.grid_rays import FRACTION, hemisphere_rays, screen_rays, steps
from golden.engine.ctu.near_cells import near_cells
from golden.engine.ctu.sector import Sector, sector_rays
from golden.engine.ctu.unit import CellTraversalUnit, global_directions
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.icu.inverse_distance import decode
from golden.engine.icu.settle_code import settle_floor
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.camera import Camera
from tb.golden import precise
from tb.golden.cast.frusta import CELLS, room

CONFIG = Config()
SHELLS = [3, 4, 5, 8, 13, 30, 100]
D, R = Decimal(3).sqrt() / 2, Decimal("0.5")
SLOPES = [0.05, 0.577, 1.0, 2.7]


def slack(shell, scale=1):
    """Twelve half units of 2^-16, rounded up to a power of two, and the rounding of points."""
    return Decimal(2) ** -10 + shell * Decimal(scale) * Decimal(2) ** -13


def half_angle(distance, shell):
    return precise.asin(distance / (shell - 1)) if distance < shell - 1 else precise.pi()


def close(value, exact):
    return abs(Decimal(float(value)) - exact) < Decimal(10) ** -12


@pytest.mark.parametrize("shell", [2, *SHELLS])
def test_margins_are_their_derivations(shell):
    assert close(margins.slack(shell), slack(shell))
    assert close(margins.depth(shell), D + slack(shell))
    assert close(margins.angle(shell), half_angle(D + R + slack(shell), shell))
    assert close(margins.horizon(shell), min(half_angle(D + slack(shell), shell), precise.pi() / 2))
    assert margins.sector_angle(shell) == margins.angle(shell)
    for slope in SLOPES:
        scale = 1.125 * max(slope, 1)
        border = (D + slack(shell, scale)) * (1 + Decimal(slope) ** 2).sqrt() / (shell - 1)
        assert close(margins.slack(shell, scale), slack(shell, scale))
        assert close(margins.screen_border(shell, slope, scale), border)
        for function in margins.screen_reach, margins.screen_sector_reach:
            assert close(function(shell, slope, 0.25, scale), border + Decimal("0.125"))


@pytest.mark.parametrize("shell", SHELLS)
def test_no_hit_of_a_cell_is_farther_from_its_grid_ray_than_the_angle_and_some_nearly_are(shell):
    random, d, r = np.random.default_rng(shell), float(D), float(R)
    count = 50000
    centre = np.array([0, 0, 1]) * random.choice([shell - 1, random.uniform(shell - 1, shell)], (count, 1))
    toward = random.normal(size=(count, 3))
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    # Half of the hits are where the ball around the centre is seen last, on the far side from the grid ray.
    seen = np.arcsin(np.minimum(d / centre[:, 2], 1))
    tangent = np.stack([-np.cos(seen), 0 * seen, -np.sin(seen)], axis=1)
    hit = centre + d * np.where(np.arange(count)[:, None] % 2, tangent, toward)
    turn = 2 * np.arcsin(r / 2 / centre[:, 2]) * np.where(np.arange(count) % 2, 1, random.uniform(-1, 1, count))
    grid = np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=1)
    along = np.einsum("ki,ki->k", hit, grid) / np.linalg.norm(hit, axis=1)
    worst = np.arccos(np.clip(along, -1, 1)).max()
    assert 0.92 < worst / margins.angle(shell) < 1
    assert shell < 10 or worst / margins.angle(shell) > 0.98


@pytest.mark.parametrize("psi", [0.01, 0.2, 1.0])
def test_a_cap_spans_the_azimuths_of_its_reach(psi):
    polar = np.linspace(psi + 1e-3, np.pi - psi - 1e-3, 40)
    around = np.linspace(0, 2 * np.pi, 100001)
    for one in polar:
        x = np.sin(one) * np.cos(psi) + np.cos(one) * np.sin(psi) * np.cos(around)
        azimuth = np.arctan2(np.sin(psi) * np.sin(around), x).max()
        assert 0.9999 < azimuth / margins.azimuth_reach(psi, one) < 1 + 1e-12
    assert (margins.azimuth_reach(psi, np.array([0, 0.999 * psi, np.pi - 0.999 * psi])) == np.pi).all()


@pytest.mark.parametrize("shell", SHELLS)
def test_depth_horizon_and_screen_border_are_attained(shell):
    centre, d = shell - 1, float(D)
    # The corner nearest to the origin; the centre below a hit on the horizon; the centre beside a screen's border.
    assert 0.98 < d / margins.depth(shell) < 1
    below = np.arcsin(d / centre)
    assert 0.98 < below / margins.horizon(shell) < 1
    for slope in SLOPES:
        away = np.array([1, -slope]) / np.hypot(1, slope)
        hit = np.array([slope, 1]) * (centre + d * slope / np.hypot(1, slope))
        x, z = hit + d * away
        assert z == pytest.approx(centre)
        assert 0.95 < (x / z - slope) / margins.screen_border(shell, slope, 1.125 * max(slope, 1)) < 1


@pytest.mark.parametrize("shell", [2, *SHELLS])
def test_the_density_covers_half_a_cell_and_no_more_than_a_tenth_less(shell):
    covered = R - slack(shell)
    r = precise.tan(2 * precise.asin(covered / (2 * shell)))
    expected = (2 * precise.atan(r / Decimal(2).sqrt()), 2 * precise.atan(r / (2 + r * r).sqrt()))
    for step, exact in zip(steps(shell), expected, strict=True):
        assert close(step, exact)
    rays = hemisphere_rays(shell, 64, 16)
    rows, columns = rays.rows, rays.columns
    lowest = np.pi / 2 + margins.horizon(shell)
    row, half_column = lowest / rows, np.pi / columns
    # Between four grid rays the farthest direction is as far from the two above as from the two below.
    upper = (np.arange(rows - 1) + 0.5) * row
    low, high = upper.copy(), upper + row
    for _ in range(50):
        polar = (low + high) / 2
        above, below = (np.cos(polar) * np.cos(one) + np.sin(polar) * np.sin(one) * np.cos(half_column)
                        for one in (upper, upper + row))
        low, high = np.where(above > below, polar, low), np.where(above > below, high, polar)
    cosine = np.cos(polar) * np.cos(upper) + np.sin(polar) * np.sin(upper) * np.cos(half_column)
    worst = 2 * shell * np.sin(np.arccos(cosine.min()) / 2)
    # Beyond the first and the last row there is half a step.
    edge = max(2 * shell * np.sin(np.arccos(np.cos(one) * np.cos(end) + np.sin(one) * np.sin(end) * np.cos(half_column))
                                  / 2) for one, end in ((row / 2, 0), (lowest - row / 2, lowest)))
    assert max(worst, edge) + float(slack(shell)) - 1 / (256 * shell**2) < float(R)
    assert shell < 8 or worst > 0.9 * float(covered)


@pytest.mark.parametrize("shell", [2, *SHELLS])
def test_grid_rays_of_a_screen_are_half_a_step_from_every_slope(shell):
    for half in (0.1, 0.9), (1.3, 0.45):
        scale = 1.125 * max(*half, 1.0)
        rays = screen_rays(shell, (64, 32), (6, 5), half)
        for axis, count in enumerate((rays.columns, rays.rows)):
            width = 2 * (half[axis] + margins.screen_border(shell, half[axis], scale))
            step = 2 * (0.5 - float(slack(shell, scale))) / (np.sqrt(2) * shell)
            assert width / count <= step < width / (count - 1)


# A reach is rounded up and has one unit more, which its derivation does not need. The first near ray has another one to
# spare, since positions are truncated.
SPARE = 1 / 256 - 1e-9


@pytest.mark.parametrize("rays", [(64, 16), (4096, 1024), (128, 4096)])
def test_every_ray_within_the_reach_of_a_grid_ray_is_near_it_with_a_unit_to_spare(rays):
    azimuths, polars = rays
    for shell in range(2, 40, 1 if polars == 16 else 5):
        grid = hemisphere_rays(shell, azimuths, polars)
        lowest, psi = np.pi / 2 + margins.horizon(shell), margins.angle(shell)
        polar = (np.arange(grid.rows) + 0.5) * (lowest / grid.rows)
        position, reach = polar * polars / (np.pi / 2), np.full(grid.rows, psi * polars / (np.pi / 2))
        near = np.abs(np.arange(polars) + 0.5 - position[:, None]) <= reach[:, None] + SPARE
        held = (np.arange(polars) >= grid.first_row[:, None]) \
            & (np.arange(polars) < (grid.first_row + grid.row_count)[:, None])
        assert held[near].all()
        assert np.count_nonzero(held & ~near) < 0.05 * grid.rows + 1
        position = (np.arange(grid.columns) + 0.5) * azimuths / grid.columns
        reach = margins.azimuth_reach(psi, polar) * azimuths / (2 * np.pi)
        for column in range(0, grid.columns, 1 + grid.columns // 10):
            away = np.abs((np.arange(azimuths) + 0.5 - position[column] + azimuths / 2) % azimuths - azimuths / 2)
            near = away <= reach[:, None] + SPARE
            first, count = grid.first_column[:, column, None], grid.column_count[:, column, None]
            assert ((np.arange(azimuths) - first) % azimuths < count)[near].all()


@pytest.mark.parametrize("pixels", [(50, 31), (1000, 999)])
def test_every_pixel_within_the_reach_of_a_grid_ray_is_near_it_with_a_unit_to_spare(pixels):
    half_angles, bits = (0.9, 0.45), tuple((size - 1).bit_length() for size in pixels)
    half = [angle * size / 2**bit for angle, size, bit in zip(half_angles, pixels, bits, strict=True)]
    scale = 1.125 * max(*half, 1.0)
    for shell in range(2, 40):
        grid = screen_rays(shell, pixels, bits, half_angles)
        step = 2 * (0.5 - float(slack(shell, scale))) / (np.sqrt(2) * shell)
        near_rays = (grid.first_column[0], grid.column_count[0]), (grid.first_row, grid.row_count)
        for axis, (first, length) in enumerate(near_rays):
            count = len(first)
            edge = half[axis] + margins.screen_border(shell, half[axis], scale)
            slope = ((2 * np.arange(count) + 1) / count - 1) * edge
            middle = (np.arange(pixels[axis]) + 0.5) * 2 * half[axis] / pixels[axis] - half[axis]
            spare = SPARE * 2 * half[axis] / pixels[axis]
            near = np.abs(middle - slope[:, None]) <= margins.screen_reach(shell, half[axis], step, scale) + spare
            index = np.arange(pixels[axis])
            assert ((index >= first[:, None]) & (index < (first + length)[:, None]))[near].all()


@pytest.mark.parametrize("rays", [(64, 16), (512, 1024)])
def test_every_grid_ray_near_a_ray_of_a_sector_belongs_to_it(rays):
    record, random = plain(Hemisphere(*rays)), np.random.default_rng(rays[0])
    for shell in 3, 5, 9, 20:
        grid = hemisphere_rays(shell, *rays)
        for _ in range(8):
            row, column = (np.sort(random.choice(size + 1, 2, replace=False)) for size in rays[::-1])
            sector = Sector(*column.tolist(), *row.tolist())
            rows = np.minimum(grid.first_row + grid.row_count, row[1]) > np.maximum(grid.first_row, row[0])
            last = grid.first_column + grid.column_count
            columns = (np.minimum(last, column[1]) > np.maximum(grid.first_column, column[0])) \
                | (np.minimum(last - rays[0], column[1]) > column[0])
            inside = sector_rays(grid, sector, record)
            assert inside[rows[:, None] & columns].all()
            # No more than the rays whose neighbourhood ends just beside the sector: half a ray, and rounding.
            assert np.count_nonzero(inside) < 1.3 * np.count_nonzero(rows[:, None] & columns) + grid.columns + grid.rows


def plain(hemisphere: Hemisphere) -> FrustumRecord:
    coordinates = GCoordinates.of(room(), CONFIG.numbers)
    return hemisphere_record(hemisphere, coordinates, (8, 8, 8), (0, 0, 1), axes=np.eye(3))


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
def test_directions_of_grid_rays_are_off_by_less_than_their_slack(bits):
    numbers, worst = Numbers(direction_fraction=bits), 0
    coordinates, (fixed, share) = GCoordinates.of(room(), numbers), margins.rounding(numbers)
    for seed in range(60):
        random = np.random.default_rng(seed)
        record = hemisphere_record(Hemisphere(64, 16), coordinates, (8, 8, 8), random.normal(size=3))
        grid = hemisphere_rays(9, 64, 16)
        lowest = np.pi / 2 + margins.horizon(9)
        polar = ((np.arange(grid.rows) + 0.5) * (lowest / grid.rows))[:, None]
        azimuth = (np.arange(grid.columns) + 0.5) * (2 * np.pi / grid.columns)
        exact = np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                                             np.cos(polar)), axis=-1).reshape(-1, 3)
        # What the machine takes for the direction in R: the rounded matrix times the rounded direction in G.
        given = global_directions(grid.direction.reshape(-1, 3), record) @ record.matrix.T / 2.0 ** (FRACTION + bits)
        worst = max(worst, np.linalg.norm(given - exact, axis=1).max())
    derived = 6 * (2.0 ** -(bits + 1) + 2.0**-17)
    assert 0.2 * derived < worst < derived < share
    assert fixed == 2.0**-10
    assert CellTraversalUnit(record, CellTable(coordinates.integers(room().vertices), cell=1 << 22)).rounding == (
        fixed, share)


@pytest.mark.parametrize("bits", [10, 16])
def test_rays_and_grid_rays_of_any_screen_are_off_by_less_than_their_slack(bits):
    """Sizes from a pixel to 4,096, of any proportion, and fields of view up to 120 degrees."""
    numbers, random, shares = Numbers(direction_fraction=bits), np.random.default_rng(bits), []
    coordinates, (_, share) = GCoordinates.of(room(), numbers), margins.rounding(numbers)
    for _ in range(400):
        size = np.floor(2 ** random.uniform(0, min(bits, 12), 2)).astype(int)
        camera = Camera(eye=(8, 8, 8), target=random.uniform(0, 7, 3), up=random.normal(size=3),
                        fov=float(random.choice([16, 40, 90, 120])))
        screen = Screen(camera=camera, width=int(size[0]), height=int(size[1]))
        record = screen_record(screen, coordinates)
        scale, slopes, axes = record.slope_scale, np.array(record.slopes), camera.axes * [[1], [-1], [1]]
        column, row = [0, 0, size[0] - 1, size[0] // 2], [0, size[1] - 1, 0, size[1] // 2]
        exact = np.stack([screen.x[column], -screen.y[row]], axis=1)
        # Slopes in the camera's axes of what the machine takes for a ray, and the point at depth 1 of a grid ray.
        ray = np.linalg.solve(record.matrix, record.directions(column, row).T).T @ axes.T
        given = np.pad(np.rint(exact / scale * 2**FRACTION).astype(int), ((0, 0), (0, 1)),
                       constant_values=1 << FRACTION)
        grid = global_directions(given, record) @ axes.T * scale / 2.0**FRACTION
        error = np.abs(ray[:, :2] / ray[:, 2:] - exact) + np.abs(grid[:, :2] - exact) + np.abs(
            exact * (grid[:, 2:] - 1))
        shares.append((error / (share * scale * np.hypot(1, slopes))).max())
    assert 0.2 < max(shares) < 1


@pytest.mark.parametrize(("scene_bits", "vector_fraction"), [(12, 12), (14, 12), (24, 22), (24, 16), (24, 10)])
def test_cells_list_what_the_formats_round_or_the_slack_covers_it(scene_bits, vector_fraction):
    """A vertex is off by half a unit of each axis of R, of which a screen stretches some."""
    numbers = Numbers(scene_bits=scene_bits, vector_fraction=vector_fraction)
    config, origin = Config(numbers=numbers), (8.03, 8.02, 8.01)
    geometry = PatchGeometry.of(room(), numbers, [origin])
    camera = Camera(eye=origin, target=(9, 8, 8), up=(0, 0, 1), fov=30.0)
    table = Shelling(geometry, config, cell=1 / 4).table
    for record in (hemisphere_record(Hemisphere(64, 16), geometry.coordinates, origin, (1, 2, 3)),
                   screen_record(Screen(camera=camera, width=64, height=16), geometry.coordinates)):
        matrix = record.matrix / 2.0**numbers.direction_fraction
        # Half a unit of R along each of its axes, back in units of G, at the worst of the signs.
        signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
        moved = np.linalg.norm(np.linalg.solve(matrix, signs.T / 2.0 ** (vector_fraction + 1)), axis=0).max() \
            * 2.0**scene_bits
        fixed, _ = CellTraversalUnit(record, table).rounding
        assert moved < 1.01 * table.margin or moved / table.cell < 1.01 * (fixed - 2.0**-11)


@pytest.mark.parametrize("cell", [1 / 16, 1 / 64])
def test_thresholds_are_those_of_the_depth_rounded_up_once(cell):
    coordinates = GCoordinates.of(room(), CONFIG.numbers, [(3, 5, 7)])
    vertices = coordinates.integers(room().vertices)
    table = CellTable(vertices, cell=coordinates.cell_size(cell))
    camera = Camera(eye=(3, 5, 7), target=(9, 8, 8), up=(0, 0, 1), fov=80.0)
    numbers = CONFIG.numbers
    floors = settle_floor(np.arange(CONFIG.icu.settle.high + 1), CONFIG)
    # A point of a screen's view is no nearer in R than half a unit of z_scale, and of each entry of M's row, allow.
    slopes = [Decimal(float(np.tan(np.radians(40)))) * size / 30 for size in (40, 30)]
    rounded = (1 + (3 * (1 + sum(slope * slope for slope in slopes))).sqrt()) / 2
    for record, less in ((hemisphere_record(Hemisphere(64, 16), coordinates, (3, 5, 7), (1, 1, 1)), 0),
                         (screen_record(Screen(camera=camera, width=40, height=30), coordinates), rounded)):
        unit = CellTraversalUnit(record, table)
        for shell in range(3, unit.last_shell + 1):
            # In units of the R frame: a cell of the table, seen along an axis scaled by z_scale.
            reach = (shell - 1 - D - slack(shell)) * table.cell * (record.z_scale - less) / Decimal(2) ** 40
            assert abs(Decimal(unit.settled(shell)) - reach) < Decimal(10) ** -12
            limit, exact = unit.limit(shell, CONFIG), 1 / Fraction(unit.settled(shell))
            assert Fraction(float(decode(np.array(limit - 1), numbers))) < exact * (1 + Fraction(1, 2**28))
            assert Fraction(float(decode(np.array(limit), numbers))) >= exact
            # A code below the threshold has a floor that is no nearer than the limit.
            threshold = unit.threshold(shell, CONFIG)
            assert threshold == np.count_nonzero(floors <= limit)
        assert unit.settled(1) == 0
        assert unit.limit(1, CONFIG) == numbers.inverse.high


@pytest.mark.parametrize("seed", range(6))
def test_the_last_shell_holds_every_centre(seed):
    random = np.random.default_rng(seed)
    origin = random.uniform(0, CELLS, 3)
    coordinates = GCoordinates.of(room(), CONFIG.numbers, [origin])
    table = CellTable(coordinates.integers(room().vertices), cell=coordinates.cell_size(1 / CELLS))
    record = hemisphere_record(Hemisphere(64, 16), coordinates, origin, (0, 0, 1))
    index = np.stack(np.meshgrid(*map(np.arange, table.shape), indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.linalg.norm((index + 0.5) * table.cell + table.lower - record.origin, axis=1) / table.cell
    last = CellTraversalUnit(record, table).last_shell
    assert distance.max() <= last < distance.max() + 2 + float(D)


def opened(eye, right, forward, slope, cell):
    """Whether a screen with a slope of its right border opens a cell of `CELLS` in shell 1."""
    camera = Camera(eye=tuple(eye), target=tuple(eye + forward), up=tuple(np.cross(right, forward)),
                    fov=float(np.degrees(2 * np.arctan(slope))))
    coordinates = GCoordinates.of(room(), CONFIG.numbers, [eye])
    table = CellTable(coordinates.integers(room().vertices), cell=coordinates.cell_size(1 / CELLS))
    record = screen_record(Screen(camera=camera, width=16, height=16), coordinates)
    index = (coordinates.integers(cell) - table.lower) // table.cell
    return int(table.number(index)) in near_cells(record, table, record.slopes).tolist()


@pytest.mark.parametrize("slope", [0.1, 0.6, 1.0])
def test_a_screen_opens_every_cell_of_which_it_sees_a_corner(slope):
    """Cells whose diagonal is at right angles to a border of the screen, or along the view."""
    d, diagonal = float(D), np.ones(3) / np.sqrt(3)
    random, table_cell = np.random.default_rng(1), cell_of_room()
    for _ in range(6):
        side = np.cross(diagonal, random.normal(size=3))
        side /= np.linalg.norm(side)
        centre = table_cell[0] + (random.integers(5, 11, 3) + 0.5) * table_cell[1]
        # The right border's plane has the cell's diagonal for its normal; the corner is just inside it.
        right = (diagonal + slope * side) / np.hypot(1, slope)
        forward = (side - slope * diagonal) / np.hypot(1, slope)
        for share, expected in (0.99, True), (1.03, False):
            depth = random.uniform(0.3, 0.9)
            eye = centre - table_cell[1] * (depth * forward + (slope * depth + share * d * np.hypot(1, slope)) * right)
            assert opened(eye, right, forward, slope, centre) == expected
        # The centre is behind the eye, and only the corner in front.
        for share, expected in (0.98, True), (1.02, False):
            eye = centre + table_cell[1] * share * d * diagonal
            assert opened(eye, side, diagonal, slope, centre) == expected
        # The centre's depth is one cell, but for the slack of shell 1.
        for depth, expected in (1 + 0.8 * float(slack(1)), True), (1 + 1.3 * float(slack(1)), False):
            eye = centre - table_cell[1] * depth * diagonal
            assert opened(eye, side, diagonal, slope, centre) == expected


def cell_of_room():
    """Lower corner and cell of the room's table, in scene units; the coordinates do not depend on an eye inside."""
    coordinates = GCoordinates.of(room(), CONFIG.numbers, [(8, 8, 8)])
    table = CellTable(coordinates.integers(room().vertices), cell=coordinates.cell_size(1 / CELLS))
    scale = coordinates.scale * 2.0**24
    return coordinates.points(table.lower), table.cell / scale


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("beyond", "listed"), [(-5, False), (-4, True), (0, True)])
def test_a_patch_is_listed_in_cells_that_it_misses_by_four_units(axis, beyond, listed):
    # The patch ends ``beyond`` units after the border of cell 3; specks span a grid of 8 cells.
    cell, lower = 1 << 16, 1 << 12
    border = lower - 4 + 3 * cell
    speck = np.array([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]])
    patch = np.array([[0, 0, 0], [-500, 0, 9], [-500, 700, 9], [0, 700, 0]])
    patch = patch + np.array([border + beyond, 2**18, 2**18])
    vertices = np.stack([speck + lower, np.roll(patch, axis, axis=1), speck + lower + 8 * cell - 100])
    table = CellTable(vertices, cell=cell)
    index = ((vertices[1, 0] - table.lower) // cell)
    index[axis] = 3
    assert (1 in table.patches.read(table.entries(np.array([table.number(index)])))) == listed

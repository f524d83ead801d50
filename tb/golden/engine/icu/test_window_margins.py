"""The margins of windows are sufficient: each is its derivation in docs/exactness.md to the unit, or more, and the
worst errors that searches find are below it.

How tight the derivations are: the rest after CORDIC's last stage is attained; the truncation by each stage is not,
since no vector is truncated the worst way in all stages, so the default bound of angles is 1.4 times the worst angle
found. Of the error of the tables two thirds are attained: its three roundings would have to be in one direction. A
sagitta and the bound of the quotients are rounded up to whole units and attained but for that.
"""

from decimal import Decimal

import numpy as np
import pytest

from golden.engine.config import Config, Icu, Numbers
from golden.engine.icu import sbb
from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.lib.cordic import circular, circular_error, gain, linear, linear_error, rotations
from tb.golden import precise
from tb.golden.engine.icu.patches import CONFIG, KINDS, hard_patches, hemisphere, screen, setup

SETTINGS = [Icu(), Icu(cordic_stages=8), Icu(cordic_stages=20, cordic_guard=8), Icu(cordic_guard=0, angle_bits=18),
            Icu(cordic_stages=13, cordic_guard=3, angle_bits=21)]
NAMED = [f"{icu.cordic_stages}-{icu.cordic_guard}-{icu.angle_bits}" for icu in SETTINGS]
LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
TWO, ROOT2 = Decimal(2), Decimal(2).sqrt()


def units(radians: Decimal, icu: Icu) -> Decimal:
    return radians / (2 * precise.pi()) * TWO**icu.angle_bits


def angle_bound(icu: Icu, bits: int) -> Decimal:
    """The rest, every stage's truncation of two numbers twice, and half a unit of each rotation."""
    truncated = ROOT2 / TWO ** (bits - 1 + icu.cordic_guard)
    rest = precise.atan(TWO ** (1 - icu.cordic_stages))
    return units(rest + 2 * icu.cordic_stages * truncated, icu) + Decimal(icu.cordic_stages) / 2


def quotient_bound(icu: Icu, bits: int) -> Decimal:
    """A unit of the last stage, and of each stage's truncation of x a unit of x's least value."""
    return 1 + icu.cordic_stages * TWO**icu.cordic_stages / TWO ** (bits - 1 + icu.cordic_guard)


@pytest.mark.parametrize("icu", SETTINGS, ids=NAMED)
def test_rotations_and_gain_are_those_of_the_angles_of_powers_of_two(icu):
    stages = range(icu.cordic_stages)
    assert rotations(icu).tolist() == [precise.nearest(units(precise.atan(TWO**-stage), icu)) for stage in stages]
    exact = Decimal(1)
    for stage in stages:
        exact *= (1 + TWO ** (-2 * stage)).sqrt()
    assert abs(Decimal(gain(icu)) - exact) < Decimal(10) ** -14


@pytest.mark.parametrize("bits", [10, 13, 17])
@pytest.mark.parametrize("icu", SETTINGS, ids=NAMED)
def test_bounds_of_angles_and_quotients_are_their_derivations_rounded_up(icu, bits):
    assert angle_bound(icu, bits) <= circular_error(icu, bits) < angle_bound(icu, bits) + 1
    assert quotient_bound(icu, bits) <= linear_error(icu, bits) < quotient_bound(icu, bits) + 1


def climbed(error, bits, seed=0, count=2000, rounds=80):
    """The largest error that a search by steps of all sizes finds among pairs 0 <= x <= y < 2^bits <= 2 y."""
    random, high = np.random.default_rng(seed), 2**bits
    y = random.integers(high // 2, high, count)
    x = random.integers(0, y + 1)
    worst = error(x, y)
    for _ in range(rounds):
        step = 2 ** random.integers(0, bits - 1, (2, count)) * random.integers(-1, 2, (2, count))
        other_y = np.clip(y + step[1], high // 2, high - 1)
        other_x = np.clip(x + step[0], 0, other_y)
        other = error(other_x, other_y)
        x, y, worst = (np.where(other > worst, new, old) for new, old in ((other_x, x), (other_y, y), (other, worst)))
        best = np.argsort(-worst)[:count // 4]
        x, y, worst = (np.tile(value[best], 4) for value in (x, y, worst))
    return float(worst.max())


@pytest.mark.parametrize(("icu", "bits", "least"), [
    (SETTINGS[0], 17, 0.68), (SETTINGS[1], 17, 0.99), (SETTINGS[1], 10, 0.9), (SETTINGS[0], 10, 0.05),
    (SETTINGS[3], 17, 0.1)], ids=map(str, range(5)))
def test_the_worst_angles_found_are_within_their_bound(icu, bits, least):
    assert least < climbed(error_of_angles(icu), bits) / circular_error(icu, bits) <= 1


@pytest.mark.nightly
@pytest.mark.parametrize("icu", SETTINGS, ids=NAMED)
@pytest.mark.parametrize("seed", range(1, 4))
def test_no_long_search_finds_an_angle_beyond_its_bound(icu, seed):
    for bits in 10, 13, 17:
        assert climbed(error_of_angles(icu), bits, seed, count=8000, rounds=120) <= circular_error(icu, bits)


def error_of_angles(icu):
    def error(x, y):
        angle, _ = circular(x << icu.cordic_guard, y << icu.cordic_guard, icu)
        turn = 2**icu.angle_bits
        exact = np.arctan2(y.astype(LONG), x.astype(LONG)) / (2 * PI) * turn
        return np.abs((angle - exact + turn / 2) % turn - turn / 2)

    return error


@pytest.mark.parametrize(("icu", "bits", "least"), [(SETTINGS[0], 17, 1), (SETTINGS[1], 17, 1), (SETTINGS[2], 17, 1),
                                                    (SETTINGS[0], 10, 8)], ids=map(str, range(4)))
def test_the_worst_quotients_found_need_their_bound(icu, bits, least):
    def error(y, x):
        return np.abs(linear(y, x, icu) - y.astype(LONG) / x * 2**icu.cordic_stages)

    # A bound of one unit less would be too small for 17 bits, but where the worst is one unit exactly.
    worst = climbed(error, bits, rounds=200)
    assert least <= worst <= linear_error(icu, bits)


@pytest.mark.parametrize("icu", SETTINGS, ids=NAMED)
@pytest.mark.parametrize("numbers", [Numbers(), Numbers(vertex_bits=13, direction_fraction=12)], ids=["wide", "narrow"])
def test_bounds_of_windows_are_their_derivations(icu, numbers):
    errors = sbb.window_errors(Config(icu=icu, numbers=numbers))
    azimuth = angle_bound(icu, numbers.vertex_bits)
    least = TWO ** (numbers.vertex_bits - 1 + icu.cordic_guard)
    # The length truncated by each stage and by the shift, and a gain of 16 fraction bits.
    length = units((icu.cordic_stages * ROOT2 + 2) / least + TWO**-17, icu)
    table = units(4 * TWO ** -(numbers.direction_fraction + 1), icu)
    assert azimuth <= errors.azimuth < azimuth + 1
    assert precise.ceil(azimuth) + length <= errors.polar < precise.ceil(azimuth) + length + 1
    assert table <= errors.polar_slack < table + 1


@pytest.mark.parametrize(("rays", "numbers"), [((64, 16), Numbers()), ((4, 4096), Numbers()),
                                               ((64, 512), Numbers(direction_fraction=9))])
def test_slacks_of_azimuths_are_the_tables_error_over_the_sine(rays, numbers):
    config = Config(numbers=numbers)
    off, turn = LONG(2) ** (1 - numbers.direction_fraction), LONG(2) ** config.icu.angle_bits / (2 * PI)
    sine = np.sin((2 * np.arange(rays[1]) + 1).astype(LONG) * (PI / 4 / rays[1]))
    slack = SphericalWindows(hemisphere(*rays), config).azimuth_slack
    whole = sine <= off
    assert (slack[whole] == 1 << config.icu.angle_bits - 1).all()
    assert ((slack >= off / sine * turn) & (slack < off / sine * turn + 1))[~whole].all()
    assert whole.any() == (numbers.direction_fraction == 9)


@pytest.mark.parametrize(("rays", "least"), [((64, 16), 0.4), ((512, 512), 0.55), ((32, 4096), 0.6)])
def test_table_directions_are_within_their_error(rays, least):
    direction = hemisphere(*rays).all_directions().astype(LONG).reshape(rays[1], rays[0], 3)
    polar = ((2 * np.arange(rays[1]) + 1).astype(LONG) * (PI / 4 / rays[1]))[:, None]
    azimuth = (2 * np.arange(rays[0]) + 1).astype(LONG) * (PI / rays[0])
    x, y, z = np.moveaxis(direction, 2, 0)
    error = np.abs(np.arctan2(np.hypot(x, y), z) - polar) * 2**15
    around = np.abs((np.arctan2(y, x) - azimuth + PI) % (2 * PI) - PI) * np.sin(polar) * 2**15
    assert least < max(error.max(), around.max()) < 1


@pytest.mark.parametrize("bits", [(5, 6), (3, 8), (8, 3)])
def test_sagittas_are_the_worst_of_their_box_rounded_up(bits):
    icu = Icu(sagitta_polar_bits=bits[0], sagitta_span_bits=bits[1])
    table = sbb.sagitta_table(icu)
    # Two ends at the same polar angle, as far apart as the box allows: how much higher the plane through them comes.
    worst = np.empty(table.shape, dtype=LONG)
    for part, row in enumerate(worst):
        polar = (part + np.linspace(0, 1, 513, dtype=LONG)) / 2**bits[0] * PI / 2
        half = (1 + np.arange(2**bits[1])).astype(LONG)[:, None] / 2**bits[1] * PI / 2
        normal = -np.sin(polar) * np.cos(polar) * np.sin(half), np.sin(polar) ** 2 * np.sin(half) * np.cos(half)
        row[:] = (polar - np.arctan2(np.abs(normal[1]), np.abs(normal[0]))).max(axis=1)
    worst *= 2**12 / (PI / 2)
    # The sagitta of half a turn is the whole border, an integer.
    assert (table >= worst - 1e-12).all()
    assert (table - 1 < worst + 0.01).all()


def test_no_edge_rises_above_its_lower_end_by_more_than_the_table_and_some_by_nearly_as_much():
    random, icu = np.random.default_rng(2), Icu()
    count, steps = 200000, 2**12
    polar = random.uniform(0, np.pi / 2, (2, count))
    polar[1] = np.where(random.random(count) < 0.5, polar[0], np.maximum(*polar))
    span = random.uniform(0, np.pi, count)
    first, second = (np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)]) for p, a in (
        (polar[0], 0 * span), (polar[1], span)))
    normal = np.cross(first, second, axis=0)
    apex = np.arctan2(np.abs(normal[2]), np.hypot(normal[0], normal[1]))
    # The apex is on the edge if it is between the ends: before the second and after the first.
    top = np.stack([-normal[0] * normal[2], -normal[1] * normal[2], normal[0] ** 2 + normal[1] ** 2])
    between = (np.einsum("ik,ik->k", np.cross(first, top, axis=0), normal) > 0) \
        & (np.einsum("ik,ik->k", np.cross(top, second, axis=0), normal) > 0)
    lower = polar.min(axis=0)
    rise = np.where(between, lower - apex, 0) * steps / (np.pi / 2)
    box = (lower / (np.pi / 2) * 2**icu.sagitta_polar_bits).astype(int), (
        span / np.pi * 2**icu.sagitta_span_bits).astype(int)
    left = sbb.sagitta_table(icu)[box] - rise
    assert left.min() > 0
    assert left[rise > 100].min() < 1.5


def exact_window(record, config, azimuth, polar, planes):
    """The window of one patch by docs/exactness.md, without a sum in common with golden; None if an axis is inside."""
    icu, numbers = config.icu, config.numbers
    turn, quarter = 1 << icu.angle_bits, 1 << icu.angle_bits - 2
    azimuth_error = precise.ceil(angle_bound(icu, numbers.vertex_bits))
    least = TWO ** (numbers.vertex_bits - 1 + icu.cordic_guard)
    polar_error = azimuth_error + precise.ceil(units((icu.cordic_stages * ROOT2 + 2) / least + TWO**-17, icu))
    slack = precise.ceil(units(TWO ** (1 - numbers.direction_fraction), icu))
    normals, (orientation, _), split = planes
    signs = {int(np.sign(normals[edge][2])) * orientation for edge in range(4)}
    if split or orientation == 0 or not {1, -1} <= signs:
        return None
    table, lowest, at, around = sbb.sagitta_table(icu), [], int(azimuth[0]), [int(azimuth[0])]
    for edge in range(4):
        begin, end, way = int(azimuth[edge]), int(azimuth[(edge + 1) % 4]), int(np.sign(normals[edge][2]))
        moved = (end - begin) * (way or 1) % turn
        least = turn // 2 if way == 0 else 3 * turn // 4
        moved = (moved - turn if moved >= least else moved) * (way or 1)
        at += moved
        around.append(at)
        lower = int(min(polar[edge], polar[(edge + 1) % 4])) - polar_error
        part = min(max(lower, 0), quarter - 1) * 2**icu.sagitta_polar_bits // quarter
        span = min((abs(moved) + 2 * azimuth_error) * 2**icu.sagitta_span_bits // (turn // 2),
                   2**icu.sagitta_span_bits - 1)
        lowest.append(lower - int(table[part, span]) * quarter // 2**12 if lower < quarter else lower)
    low, high = min(lowest) - slack, min(int(max(polar)) + polar_error, quarter) + slack
    middle = (2 * np.arange(record.rows) + 1) * quarter // (2 * record.rows)
    rows = np.flatnonzero((middle >= low) & (middle <= high)).tolist()
    if not rows:
        return 0, 0, 0, 0
    sine = precise.sin((2 * rows[0] + 1) * precise.pi() / 4 / record.rows)
    wide = azimuth_error + precise.ceil(units(TWO ** (1 - numbers.direction_fraction) / sine, icu))
    left, right = min(around[:4]) - wide, max(around[:4]) + wide
    if right - left > turn // 2:
        return 0, record.columns, rows[0], len(rows)
    column, pitch = -(-(left - turn // record.columns // 2) * record.columns // turn), turn // record.columns
    count = (right - pitch // 2) // pitch - column + 1
    return (column % record.columns, count, rows[0], len(rows)) if count > 0 else (0, 0, 0, 0)


# An angle is a sum of all rotations, each added or subtracted, so all angles of a configuration are even, or all odd;
# the margins decide windows to the unit only in one of the two.
WINDOWS = pytest.mark.parametrize(("angle_bits", "rows", "guard", "stages"), [
    (24, 1024, 6, 16), *((18, 4096, 0, stages) for stages in (15, 16, 17))])


def check_windows(angle_bits, rows, guard, stages, seed, count):
    # With few bits an angle's unit is a sixteenth of a row, so a margin that is a unit less changes some windows; so do
    # the small boxes of the table of sagittas.
    config = CONFIG.replace({"icu.angle_bits": angle_bits, "icu.cordic_guard": guard, "icu.cordic_stages": stages,
                             "icu.sagitta_span_bits": 8})
    record, compared = hemisphere(4096, rows), 0
    windows = SphericalWindows(record, config)
    for kind in KINDS[:4]:
        directions, planes = setup(hard_patches(kind, seed, count))
        azimuth, polar = windows.angles(directions)
        window = windows.windows(directions, planes)
        for patch in range(len(directions)):
            expected = exact_window(record, config, azimuth[patch], polar[patch], (
                planes.planes[patch], planes.orientation[patch].tolist(), planes.split[patch]))
            if expected is not None:
                compared += 1
                assert tuple(int(value[patch]) for value in vars(window).values()) == expected, (kind, patch)
    assert compared > 2 * count


@WINDOWS
def test_windows_of_hemispheres_have_their_margins_to_the_unit(angle_bits, rows, guard, stages):
    check_windows(angle_bits, rows, guard, stages, 11, 60)


@pytest.mark.nightly
@WINDOWS
@pytest.mark.parametrize("seed", range(20, 30))
def test_many_windows_of_hemispheres_have_their_margins_to_the_unit(angle_bits, rows, guard, stages, seed):
    check_windows(angle_bits, rows, guard, stages, seed, 200)


def test_windows_of_screens_have_their_margins_to_the_unit():
    # A column is half a unit of the quotients, so a margin that is a unit less changes every window.
    config = CONFIG.replace({"icu.cordic_stages": 12, "icu.side_bits": 14})
    record = screen(1 << 13, 1 << 13)
    windows, error = ImagePlaneWindows(record, config), precise.ceil(quotient_bound(config.icu, 17))
    vertices = hard_patches("anywhere", 12, 100)
    vertices[..., 2] = np.abs(vertices[..., 2]) + 1
    directions, planes = setup(vertices)
    window = windows.windows(directions, planes)
    assert error == 2
    for patch, (x, y, z) in enumerate(np.moveaxis(directions, 2, 1)):
        if not planes.orientation[patch].any():
            continue
        expected = []
        for across in x, y:
            quotient = windows.quotients(across, z)
            low, high = int(quotient.min()) - error, int(quotient.max()) + error
            # The table's entry i is (2 i + 1 - size) / 2^13.
            first, last = -((-low * 2 - (2**13 - 1)) // 2), (high * 2 + 2**13 - 1) // 2
            first, last = max(first, 0), min(last, 2**13 - 1)
            expected += [first, last - first + 1]
        if min(expected[1], expected[3]) <= 0:
            expected = [0] * 4
        assert [int(value[patch]) for value in vars(window).values()] == expected, patch

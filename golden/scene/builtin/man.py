"""An articulated figure in a studio: the stand-in for the thesis' scene of that name."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box, cap, framed, loft, placed, rounded
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import revolution, sphere

__all__ = ["man"]

BEECH = Material(name="beech", diffuse=(0.68, 0.46, 0.26))
JOINT = Material(name="joint", diffuse=(0.36, 0.19, 0.09))
STAGE = Material(name="stage", diffuse=(0.30, 0.32, 0.36))
BACKDROP = Material(name="backdrop", diffuse=(0.52, 0.60, 0.68))
STUDIO = Material(name="studio", diffuse=(0.70, 0.69, 0.66))
SOFTBOX = Material(name="softbox", diffuse=(0.60, 0.60, 0.60), emission=(16.0, 15.0, 13.5))
FILL = Material(name="fill light", diffuse=(0.60, 0.60, 0.60), emission=(5.0, 5.6, 6.5))
CRATE = Material(name="crate", diffuse=(0.55, 0.16, 0.10))

GROUND = 0.12
SIDES = 12

# Joints of the figure in metres above the stage; it looks towards -y, its left is +x.
# Hip, knee, ankle, and how many degrees the toes turn to the figure's left.
LEGS = (
    ((0.10, 0.0, 0.93), (0.115, -0.03, 0.51), (0.12, 0.03, 0.10), 12.0),
    ((-0.10, 0.0, 0.93), (-0.17, -0.13, 0.53), (-0.22, -0.12, 0.10), -25.0),
)
# Shoulder, elbow, wrist, knuckles.
ARMS = (
    ((0.235, 0.0, 1.42), (0.38, 0.05, 1.17), (0.27, -0.13, 1.02), (0.16, -0.16, 0.97)),
    ((-0.235, 0.0, 1.42), (-0.50, -0.03, 1.50), (-0.56, -0.08, 1.76), (-0.555, -0.10, 1.89)),
)


def man() -> Scene:
    """A jointed wooden figure that waves from a round stage before a backdrop; 3315 patches in a closed studio."""
    builder = SceneBuilder("man")
    _studio(builder)
    _trunk(builder)
    for leg in LEGS:
        _leg(builder, leg)
    for arm in ARMS:
        _arm(builder, arm)
    return builder.build(camera=Camera(eye=(0.9, -3.6, 1.45), target=(0.05, 0.0, 1.0), fov=37.0))


def _between(builder: SceneBuilder, start, end, radii) -> None:
    """A turned limb with round ends from one joint to the next; ``radii`` are those at equal steps between its ends."""
    length = np.linalg.norm(np.subtract(end, start))
    heights = length * np.linspace(0.1, 0.9, len(radii))
    profile = [(0.0, 0.05 * length), *zip(radii, heights, strict=True), (0.0, 0.95 * length)]
    limb = placed(revolution(profile, segments=SIDES), axis=np.subtract(end, start), at=np.add(start, (0, 0, GROUND)))
    builder.add(limb, BEECH, smooth=True)


def _joint(builder: SceneBuilder, centre, radius: float) -> None:
    builder.add(sphere(np.add(centre, (0, 0, GROUND)), radius, segments=SIDES), JOINT, smooth=True)


def _trunk(builder: SceneBuilder) -> None:
    """Head, neck, chest and pelvis."""
    parts = (
        ([(0.0, 0.0), (0.075, 0.015), (0.115, 0.06), (0.13, 0.11), (0.12, 0.15), (0.08, 0.17), (0.0, 0.175)],
         0.86, 0.62),
        ([(0.0, 0.0), (0.09, 0.012), (0.135, 0.05), (0.155, 0.11), (0.175, 0.18), (0.19, 0.24), (0.185, 0.29),
          (0.15, 0.325), (0.08, 0.345), (0.0, 0.35)], 1.12, 0.6),
        ([(0.0, 0.0), (0.035, 0.008), (0.055, 0.035), (0.07, 0.08), (0.083, 0.13), (0.085, 0.17), (0.074, 0.21),
          (0.045, 0.24), (0.0, 0.25)], 1.555, 1.12),
    )
    for profile, height, flat in parts:
        shape = revolution(profile, segments=18)
        builder.add(placed(shape, scale=(1.0, flat, 1.0), at=(0.0, 0.0, height + GROUND)), BEECH, smooth=True)
    _joint(builder, (0.0, 0.0, 1.075), 0.085)
    _joint(builder, (0.0, 0.0, 1.52), 0.06)


def _leg(builder: SceneBuilder, leg) -> None:
    """From the hip to the sole."""
    hip, knee, ankle, toes = leg
    _joint(builder, hip, 0.072)
    _between(builder, hip, knee, (0.045, 0.072, 0.083, 0.085, 0.08, 0.072, 0.062, 0.045))
    _joint(builder, knee, 0.052)
    _between(builder, knee, ankle, (0.035, 0.054, 0.064, 0.062, 0.054, 0.046, 0.039, 0.028))
    _joint(builder, ankle, 0.04)
    # Sections of one shape, smaller and further back as they rise: the walls between them are planar.
    sole = rounded(0.1, 0.26, radius=0.048, steps=4)
    rings = [sole * (size, size, 0.0) + (0.0, back, height) for size, back, height in (
        (0.88, -0.07, 0.002), (1.0, -0.07, 0.015), (0.98, -0.068, 0.03), (0.86, -0.05, 0.05), (0.62, -0.018, 0.075),
        (0.34, 0.005, 0.085))]
    pose = {"turn": toes, "at": (*ankle[:2], GROUND)}
    builder.add(placed(loft(rings), **pose), BEECH, smooth=True)
    builder.add(placed(np.concatenate([cap(rings[0][::-1]), cap(rings[-1])]), **pose), BEECH)


def _arm(builder: SceneBuilder, joints) -> None:
    """From the shoulder to the finger tips."""
    shoulder, elbow, wrist, knuckles = joints
    _joint(builder, shoulder, 0.066)
    _between(builder, shoulder, elbow, (0.032, 0.05, 0.055, 0.053, 0.048, 0.042, 0.03))
    _joint(builder, elbow, 0.04)
    _between(builder, elbow, wrist, (0.026, 0.041, 0.045, 0.042, 0.036, 0.031, 0.022))
    _joint(builder, wrist, 0.028)
    _hand(builder, np.array(wrist), np.array(knuckles))


def _hand(builder: SceneBuilder, wrist: np.ndarray, knuckles: np.ndarray) -> None:
    """A palm, four fingers and a thumb of two links each."""
    along = knuckles - wrist
    along = along / np.linalg.norm(along)
    # The palm is wide along this direction and thin square to it.
    wide = np.cross(along, (0.0, 1.0, 0.0))
    wide = wide / np.linalg.norm(wide)
    profile = [(0.0, 0.015), (0.55, 0.022), (0.85, 0.045), (1.0, 0.07), (0.95, 0.095), (0.6, 0.11), (0.0, 0.115)]
    palm = revolution(profile, segments=SIDES)
    matrix = np.array([0.042 * wide, 0.017 * np.cross(along, wide), along])
    points = sum(palm[..., k, None] * matrix[k] for k in range(3)) + np.add(wrist, (0, 0, GROUND))
    builder.add(points, BEECH, smooth=True)
    for offset, spread, length in (
            (-0.03, -0.28, 0.07), (-0.01, -0.08, 0.085), (0.01, 0.08, 0.08), (0.03, 0.28, 0.062)):
        root = wrist + 0.1 * along + offset * wide
        direction = along + spread * wide
        _finger(builder, root, direction / np.linalg.norm(direction) * length, 0.0095)
    inner = -np.sign(wrist[0]) * np.sign(wide[0] if abs(wide[0]) > 0.1 else wide[2])
    direction = 0.75 * along + inner * 0.66 * wide
    _finger(builder, wrist + 0.04 * along + inner * 0.034 * wide, direction * 0.065, 0.011)


def _finger(builder: SceneBuilder, root: np.ndarray, reach: np.ndarray, radius: float) -> None:
    length = np.linalg.norm(reach)
    for start, share in ((0.0, 0.55), (0.52, 0.48)):
        heights = length * (start + share * np.array([0.0, 0.08, 0.5, 0.92, 1.0]))
        radii = radius * (1 - 0.25 * start) * np.array([0.0, 0.75, 1.0, 0.7, 0.0])
        link = revolution(np.stack([radii, heights], axis=-1), segments=6)
        builder.add(placed(link, axis=reach, at=np.add(root, (0, 0, GROUND))), BEECH, smooth=True)


def _studio(builder: SceneBuilder) -> None:
    """A closed room whose floor runs up into the back wall in a curve, a softbox in the ceiling, and a stage."""
    half, front, back, height, bend, steps = 3.4, -4.2, 2.2, 3.2, 1.2, 8
    angle = np.pi / 2 * np.arange(steps + 1) / steps
    curve = np.stack([back - bend + bend * np.sin(angle), bend - bend * np.cos(angle)], axis=-1)
    outline = np.array([(front, 0.0), *curve, (back, height), (front, height)])
    left, right = (np.column_stack([np.full(len(outline), x), outline]) for x in (-half, half))
    around = loft([right, left])
    builder.add(around[:-2], BACKDROP, smooth=True)
    panel = framed(around[-2], border=1.5)
    builder.add(panel[:4], STUDIO, surface=0)
    builder.add(panel[4], SOFTBOX)
    window = framed(around[-1], border=0.7)
    builder.add(window[:4], STUDIO, surface=0)
    builder.add(window[4], FILL)
    for wall in left, right[::-1]:
        builder.add(cap(wall), STUDIO, surface=0)
    stage = revolution([(0.75, 0.0), (0.75, GROUND - 0.01), (0.74, GROUND)], segments=34)
    builder.add(stage, STAGE, smooth=True)
    builder.add(cap(stage[-34:, 3]), STAGE, surface=0)
    crate = box((-0.25, -0.25, 0.0), (0.25, 0.25, 0.5), omit=("-z",))
    builder.add(placed(crate, turn=25.0, at=(1.15, 0.5, 0.0)), CRATE)
    builder.add(sphere((1.15, 0.5, 0.7), 0.2, segments=14), JOINT, smooth=True)

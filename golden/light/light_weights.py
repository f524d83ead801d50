"""How much light each lamp may send to points, before visibility."""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["light_weights"]

# A light that rises less than this above the horizon of a point, as a sine, counts as in the point's plane.
HORIZON = 1e-12
# A light that is seen aslant counts with its cosine, as if it rose by this share of its radius: near ones fill more.
BLUR = 0.25


def light_weights(position: np.ndarray, normal: np.ndarray, vertices: np.ndarray, centre: np.ndarray,
                  front: np.ndarray, two_sided: np.ndarray, power: np.ndarray, radius2: np.ndarray) -> np.ndarray:
    """Estimates of the unoccluded irradiance of L lights at M points, M x L; 0 only where no light arrives.

    The estimate is power over the squared distance of the centre plus the squared radius, times the largest sine of a
    corner or the centre above the point's horizon, times the cosine at the light.

    Parameters
    ----------
    position, normal
        M x 3 points and their unit normals.
    vertices, centre, front, two_sided
        L x 4 x 3 corners of the lights, L x 3 centres and front normals, and whether their backs emit.
    power, radius2
        L each: emitted power, and squared largest distance of a corner from the centre.
    """
    points = np.concatenate([vertices, centre[:, None]], axis=1)
    weight = np.empty((len(position), len(points)))
    _weigh(position, normal, points, front, two_sided, power, radius2, weight)
    return weight


@compiled
def _weigh(position, normal, points, front, two_sided, power, radius2, weight):
    for m in range(len(position)):
        px, py, pz = position[m]
        nx, ny, nz = normal[m]
        for light in range(len(points)):
            highest, distance2, facing = 0.0, 0.0, 0.0
            for corner in range(5):
                x, y, z = points[light, corner, 0] - px, points[light, corner, 1] - py, points[light, corner, 2] - pz
                distance2 = x * x + y * y + z * z
                highest = max(highest, (x * nx + y * ny + z * nz) / max(np.sqrt(distance2), 1e-300))
            facing = -(x * front[light, 0] + y * front[light, 1] + z * front[light, 2])
            seen = highest >= HORIZON and (facing > 0 or two_sided[light])
            cosine = min(1.0, (abs(facing) + BLUR * np.sqrt(radius2[light])) / max(np.sqrt(distance2), 1e-300))
            weight[m, light] = highest * cosine * power[light] / (distance2 + radius2[light]) if seen else 0.0

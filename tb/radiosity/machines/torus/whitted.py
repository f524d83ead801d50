"""Reference: rays traced recursively in Python, each tested with every object."""

import numpy as np

__all__ = ["picture"]

NEAREST = 1e-7


def picture(scene, size, *, deepest=8, least=1 / 256, has_shadows=True):
    """R x C x 3 float64, the upper row first."""
    rows, columns = size
    found = np.zeros((rows, columns, 3))
    for row in range(rows):
        for column in range(columns):
            direction = np.array([((2 * column + 1) / columns - 1) * scene.slope * columns / rows,
                                  ((2 * row + 1) / rows - 1) * scene.slope, 1.0])
            found[rows - 1 - row, column] = _colour(scene, np.zeros(3), direction / np.linalg.norm(direction),
                                                    np.ones(3), 0, None, (deepest, least, has_shadows))
    return found


def _distances(scene, origin, direction):
    for number, corners in enumerate(scene.corners):
        if scene.counts[number] == 0:
            to = corners[0] - origin
            along, radius = to @ direction, corners[1, 0]
            root = along ** 2 - to @ to + radius ** 2
            if root >= 0:
                for distance in (along - root ** 0.5, along + root ** 0.5):
                    if distance > NEAREST:
                        yield distance, number
                        break
            continue
        polygon = corners[:scene.counts[number]]
        normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
        distance = ((polygon[0] - origin) @ normal) / (direction @ normal)
        point = origin + distance * direction
        sides = [np.cross(polygon[(i + 1) % len(polygon)] - polygon[i], point - polygon[i]) @ normal
                 for i in range(len(polygon))]
        if distance > NEAREST and min(sides) >= 0:
            yield distance, number


def _light(scene, origin, direction):
    """Distance and colour of the nearest light."""
    found = np.inf, np.zeros(3)
    for light in scene.lights:
        to = light[:3] - origin
        along = to @ direction
        root = along ** 2 - to @ to + light[3] ** 2
        if root >= 0 and along - root ** 0.5 > 0 and along - root ** 0.5 < found[0]:
            found = along - root ** 0.5, light[4:]
    return found


def _colour(scene, origin, direction, share, level, medium, limits):
    deepest, least, has_shadows = limits
    distance, number = min(_distances(scene, origin, direction), default=(np.inf, None))
    far, colour = _light(scene, origin, direction)
    if far < distance:
        return share * colour
    if number is None:
        return np.zeros(3)
    point, values = origin + distance * direction, scene.coefficients[number]
    is_sphere = scene.counts[number] == 0
    normal = (point - scene.corners[number, 0]) if is_sphere else np.cross(
        scene.corners[number, 1] - scene.corners[number, 0], scene.corners[number, 2] - scene.corners[number, 0])
    normal = normal / np.linalg.norm(normal)
    if normal @ direction > 0:
        normal = -normal
    found = share * values[:3]
    for light in scene.lights:
        to = light[:3] - point
        away = np.linalg.norm(to)
        cosine = to @ normal / away
        if cosine > 0 and not (has_shadows and any(
                at < away for at, _ in _distances(scene, point, to / away))):
            found = found + share * values[3:6] * cosine * light[4:]
    for kind in (6, 9):
        part, inside = share * values[kind:kind + 3], medium
        if level + 1 > deepest or not part.max() > least:
            continue
        slope = direction @ normal
        if kind == 6:
            toward = direction - 2 * slope * normal
        else:
            ratio = 1.0
            if is_sphere:
                ratio = values[12] if medium == number else 1 / values[12]
                inside = None if medium == number else number
            root = 1 - ratio ** 2 * (1 - slope ** 2)
            if root < 0:
                continue
            toward = ratio * direction - (ratio * slope + root ** 0.5) * normal
        found = found + _colour(scene, point, toward / np.linalg.norm(toward), part, level + 1, inside, limits)
    return found

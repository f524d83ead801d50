"""The traversal of `golden.cast.grid.Grid` as a compiled function, ray by ray, with the tests of `golden.oracle`."""

import numpy as np

from golden.compiled import compiled

__all__ = ["cast"]

# As in `golden.cast.grid`.
STILL = 2.0**-60


@compiled
def cast(origin, direction, source, target, tmax, any_hit, nearest, base, margin, size, shape, table, listed,
         vertices, is_triangle, surface, patch_of, t_of, u_of, v_of, tests_of, steps_of):
    """Cast R rays.

    Parameters
    ----------
    origin, direction, source, target, tmax
        The rays, see `golden.cast.rays.Rays`.
    any_hit
        The first cell with a hit ends a ray.
    nearest
        Least distance of a hit in scene units.
    base, margin, size, shape
        The cells, see `golden.scene.cells.Cells`.
    table, listed
        Per cell, with a border around the grid, its first entry in ``listed`` and their number, -1 in the border; the
        patches' numbers.
    vertices, is_triangle, surface
        The scene's patches.
    patch_of, t_of, u_of, v_of, tests_of, steps_of
        The hits, see `golden.cast.rays.Hits`, which are written.
    """
    strides = ((shape[1] + 2) * (shape[2] + 2), shape[2] + 2, 1)
    p, inverse, moves, stride = np.empty(3), np.empty(3), np.empty(3, dtype=np.bool_), np.empty(3, dtype=np.int64)
    cross, plane, between = np.empty(3), np.empty(3), np.empty(3)
    # The last ray that tested each patch: a patch of several cells gives the same in each.
    tested = np.full(len(vertices), -1)
    for ray in range(len(origin)):
        largest = max(abs(direction[ray, 0]), abs(direction[ray, 1]), abs(direction[ray, 2]))
        # Enter the grid.
        entry, leave = 0.0, np.inf
        for axis in range(3):
            d = direction[ray, axis]
            p[axis] = (origin[ray, axis] - base[axis]) + margin
            moves[axis] = abs(d) > STILL * largest
            extent = shape[axis] * size
            if moves[axis]:
                inverse[axis] = 1 / d
                low, high = (0 - p[axis]) * inverse[axis], (extent - p[axis]) * inverse[axis]
                entry, leave = max(entry, min(low, high)), min(leave, max(low, high))
            elif not 0 <= p[axis] <= extent:
                entry = np.inf
        best, found, tests, steps = tmax[ray], -1, 0, 0
        if entry <= leave and entry < best:
            kz = dominant_axis(direction[ray, 0], direction[ray, 1], direction[ray, 2])
            kx, ky = (kz + 1) % 3, (kz + 2) % 3
            ox, oy, oz = origin[ray, kx], origin[ray, ky], origin[ray, kz]
            sx, sy = direction[ray, kx] / direction[ray, kz], direction[ray, ky] / direction[ray, kz]
            scale = 1 / direction[ray, kz]
            tmin = nearest / np.sqrt(direction[ray, 0] * direction[ray, 0] + direction[ray, 1] * direction[ray, 1]
                                     + direction[ray, 2] * direction[ray, 2])
            cell = 0
            for axis in range(3):
                d = direction[ray, axis]
                index = min(max(int((p[axis] + d * entry) / size), 0), shape[axis] - 1)
                cell += (index + 1) * strides[axis]
                cross[axis], plane[axis], between[axis], stride[axis] = np.inf, 0.0, 0.0, 0
                if moves[axis]:
                    forward = d > 0
                    plane[axis] = (index + (1 if forward else 0)) * size
                    between[axis] = size if forward else -size
                    stride[axis] = strides[axis] if forward else -strides[axis]
                    cross[axis] = (plane[axis] - p[axis]) * inverse[axis]
            # Traverse it.
            c0, c1, c2 = cross[0], cross[1], cross[2]
            count = table[cell, 1]
            while count >= 0:
                leave = min(c0, c1, c2)
                steps += 1
                tests += count
                first = table[cell, 0]
                for place in range(first, first + count):
                    patch = listed[place]
                    if tested[patch] == ray or surface[patch] == source[ray] or surface[patch] == target[ray]:
                        continue
                    tested[patch] = ray
                    met, depth = meet(vertices, patch, is_triangle[patch], kx, ky, kz, ox, oy, oz, sx, sy)
                    t = depth * scale
                    if met and t > tmin and (t < best or (t == best and patch < found)):
                        best, found = t, patch
                if best <= leave or (any_hit and found >= 0):
                    break
                if c0 <= leave:
                    cell += stride[0]
                    plane[0] += between[0]
                    c0 = (plane[0] - p[0]) * inverse[0]
                if c1 <= leave:
                    cell += stride[1]
                    plane[1] += between[1]
                    c1 = (plane[1] - p[1]) * inverse[1]
                if c2 <= leave:
                    cell += stride[2]
                    plane[2] += between[2]
                    c2 = (plane[2] - p[2]) * inverse[2]
                count = table[cell, 1]
        u, v = 0.0, 0.0
        if found >= 0:
            u, v = position(vertices, found, is_triangle[found], kx, ky, kz, ox, oy, oz, sx, sy)
        patch_of[ray], t_of[ray], u_of[ray], v_of[ray] = found, best if found >= 0 else np.inf, u, v
        tests_of[ray], steps_of[ray] = tests, steps


@compiled
def dominant_axis(x, y, z):
    """The axis of the largest component, the first of equal ones."""
    if abs(x) >= abs(y):
        return 0 if abs(x) >= abs(z) else 2
    return 1 if abs(y) >= abs(z) else 2


@compiled
def meet(vertices, patch, is_triangle, kx, ky, kz, ox, oy, oz, sx, sy):
    """Whether a ray is inside a patch, and the depth there."""
    z0, z1, z2 = vertices[patch, 0, kz] - oz, vertices[patch, 1, kz] - oz, vertices[patch, 2, kz] - oz
    x0, y0 = (vertices[patch, 0, kx] - ox) - sx * z0, (vertices[patch, 0, ky] - oy) - sy * z0
    x1, y1 = (vertices[patch, 1, kx] - ox) - sx * z1, (vertices[patch, 1, ky] - oy) - sy * z1
    x2, y2 = (vertices[patch, 2, kx] - ox) - sx * z2, (vertices[patch, 2, ky] - oy) - sy * z2
    e01, e12, e20 = x0 * y1 - y0 * x1, x1 * y2 - y1 * x2, x2 * y0 - y2 * x0
    low, high = min(e01, e12, e20), max(e01, e12, e20)
    if (low >= 0 or high <= 0) and low != high:
        return True, (e12 * z0 + e20 * z1 + e01 * z2) / (e12 + e20 + e01)
    # The other half of a triangle is empty.
    if is_triangle:
        return False, 0.0
    z3 = vertices[patch, 3, kz] - oz
    x3, y3 = (vertices[patch, 3, kx] - ox) - sx * z3, (vertices[patch, 3, ky] - oy) - sy * z3
    e23, e30, e02 = x2 * y3 - y2 * x3, x3 * y0 - y3 * x0, -e20
    low, high = min(e23, e30, e02), max(e23, e30, e02)
    if (low >= 0 or high <= 0) and low != high:
        return True, (e23 * z0 + e30 * z2 + e02 * z3) / (e23 + e30 + e02)
    return False, 0.0


@compiled
def position(vertices, patch, is_triangle, kx, ky, kz, ox, oy, oz, sx, sy):
    """Bilinear coordinates of a ray's hit on a patch."""
    z0, z1, z2 = vertices[patch, 0, kz] - oz, vertices[patch, 1, kz] - oz, vertices[patch, 2, kz] - oz
    x0, y0 = (vertices[patch, 0, kx] - ox) - sx * z0, (vertices[patch, 0, ky] - oy) - sy * z0
    x1, y1 = (vertices[patch, 1, kx] - ox) - sx * z1, (vertices[patch, 1, ky] - oy) - sy * z1
    x2, y2 = (vertices[patch, 2, kx] - ox) - sx * z2, (vertices[patch, 2, ky] - oy) - sy * z2
    if is_triangle:
        e01, e12, e20 = x0 * y1 - y0 * x1, x1 * y2 - y1 * x2, x2 * y0 - y2 * x0
        total = e01 + e12 + e20
        return _share(e20 / (total - e01)), _share(e01 / total)
    z3 = vertices[patch, 3, kz] - oz
    x3, y3 = (vertices[patch, 3, kx] - ox) - sx * z3, (vertices[patch, 3, ky] - oy) - sy * z3
    bx, by, cx, cy = x1 - x0, y1 - y0, x3 - x0, y3 - y0
    dx, dy = x2 - x3 - bx, y2 - y3 - by
    v = _unit_root(cx * dy - cy * dx, (x0 * dy - y0 * dx) + (cx * by - cy * bx), x0 * by - y0 * bx)
    along_x, along_y = bx + dx * v, by + dy * v
    u = -((x0 + cx * v) * along_x + (y0 + cy * v) * along_y) / (along_x * along_x + along_y * along_y)
    return _share(u), _share(v)


@compiled
def _unit_root(a, b, c):
    """The root of ``a x^2 + b x + c`` nearest to the middle of [0, 1], without cancellation."""
    q = -0.5 * (b + np.copysign(np.sqrt(max(b * b - 4 * a * c, 0.0)), b))
    far, near = q / a, c / q
    if not np.isfinite(far):
        far = np.inf
    if not np.isfinite(near):
        near = np.inf
    return far if abs(far - 0.5) < abs(near - 0.5) else near


@compiled
def _share(value):
    """A value clipped to [0, 1]; what is not finite is 0."""
    return min(max(value, 0.0), 1.0) + 0.0 if np.isfinite(value) else 0.0

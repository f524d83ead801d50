"""Path tracing of our scenes with Mitsuba (``pip install -e .[reference]``): the reference of our pictures.

The integrator is ours: it lights points by our lights without an area, through thin panes as well, and tells the
light that bodies of glass bend or mirror onto surfaces from all other light.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from golden.scene.lights import DirectionalLight
from golden.scene.scene import Scene
from golden.scene.sky.sky import Sky

mi.set_variant("llvm_ad_rgb")

__all__ = ["PathTracer"]

# Segments of a path, and the one after which paths end by chance.
LONGEST, ROULETTE = 40, 6
# Panes that a shadow ray passes.
PANES = 4
# Halves of a two-sided lamp are apart by this share of the traced scene's size.
APART = 2e-6
SKY_WIDTH = 2048


class PathTracer:
    """Traces one scene.

    Parameters
    ----------
    scene
        The scene, with a camera.
    balls, origin, scale
        See `benchmarks.reference_scenes.ReferenceScene`.
    """

    def __init__(self, scene: Scene, *, balls=None, origin=(0.0, 0.0, 0.0), scale: float = 1.0):
        self._scene, self._balls = scene, balls or {}
        self._origin, self._scale = np.asarray(origin, dtype=np.float64), scale
        self._lights = _PunctualLights(scene, self._move)
        world = {"type": "scene"} | self._background() | self._spheres()
        for number in np.unique(scene.material).tolist():
            for two_sided in (False, True):
                world |= self._meshes(number, two_sided)
        self._world = mi.load_dict(world)
        self._has_emitters = len(self._world.emitters()) > 0

    def trace(self, *, width: int, height: int, samples: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Radiance by ``samples`` paths a pixel, height x width x 3, and the part that bodies of glass throw."""
        camera = self._scene.camera
        right, up, forward = camera.axes
        sampler = mi.load_dict({"type": "independent"})
        count = width * height * samples
        sampler.seed(seed, count)
        pixel = dr.arange(mi.UInt32, count) // samples
        offset = sampler.next_2d()
        half = np.tan(np.radians(camera.fov) / 2)
        x = (2 * (mi.Float(pixel % width) + offset.x) / width - 1) * half * width / height
        y = (1 - 2 * (mi.Float(pixel // width) + offset.y) / height) * half
        direction = mi.Vector3f(*[x * float(right[k]) + y * float(up[k]) + float(forward[k]) for k in range(3)])
        ray = mi.Ray3f(mi.Point3f(self._move(np.array(camera.eye)).tolist()), dr.normalize(direction))
        light, thrown = _radiance(self._world, self._lights, self._has_emitters, sampler, ray)
        return tuple(np.stack([np.asarray(dr.block_sum(channel, samples)).reshape(height, width) / samples
                               for channel in value], axis=2) for value in (light, thrown))

    def _move(self, points):
        return (points - self._origin) * self._scale

    def _background(self):
        background = self._scene.background
        if not isinstance(background, Sky):
            if not any(background):
                return {}
            return {"sky": {"type": "constant", "radiance": _rgb(background)}}
        v, u = np.meshgrid((np.arange(SKY_WIDTH // 2) + 0.5) / (SKY_WIDTH // 2), (np.arange(SKY_WIDTH) + 0.5)
                           / SKY_WIDTH, indexing="ij")
        angle, polar = 2 * np.pi * u.ravel(), np.pi * v.ravel()
        # The picture's own up is y; a quarter turn around x makes it z.
        local = np.stack([np.sin(angle) * np.sin(polar), np.cos(polar), -np.cos(angle) * np.sin(polar)], axis=1)
        turned = np.stack([local[:, 0], -local[:, 2], local[:, 1]], axis=1)
        picture = background.radiance(turned).reshape(*u.shape, 3).astype(np.float32)
        return {"sky": {"type": "envmap", "bitmap": mi.Bitmap(picture),
                        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90)}}

    def _spheres(self):
        materials = {material.name: material for material in self._scene.materials}
        return {f"ball {name}": {"type": "sphere", "center": self._move(np.array(centre)).tolist(),
                                 "radius": radius * self._scale, "bsdf": _bsdf(materials[name], two_sided=False)}
                for name, (centre, radius) in self._balls.items()}

    def _meshes(self, number, two_sided):
        """All patches of one material and kind, a two-sided lamp as one mesh for each side."""
        scene, material = self._scene, self._scene.materials[number]
        members = (scene.material == number) & (scene.two_sided == two_sided)
        if material.name in self._balls or not members.any():
            return {}
        quads = self._move(scene.vertices[members])
        if not (two_sided and material.emits):
            return {f"{number} {two_sided}": self._mesh(quads, scene.is_triangle[members], material, two_sided)}
        shift = APART * scene.size * self._scale * scene.normals[members][:, None]
        return {f"{number} {side}": self._mesh((quads + side * shift)[:, ::side], scene.is_triangle[members], material,
                                               False) for side in (1, -1)}

    def _mesh(self, quads, triangle, material, two_sided):
        triangles = np.concatenate([quads[:, :3], quads[~triangle][:, [0, 2, 3]]])
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(_bsdf(material, two_sided=two_sided))
        if material.emits:
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": _rgb(material.emission)})
        mesh = mi.Mesh(material.name, vertex_count=3 * len(triangles), face_count=len(triangles),
                       has_vertex_normals=False, props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = triangles.astype(np.float32).ravel()
        parameters["faces"] = np.arange(3 * len(triangles), dtype=np.uint32)
        parameters.update()
        return mesh


class _PunctualLights:
    """The lights without an area, one of which is chosen at a time, all alike."""

    def __init__(self, scene, move):
        self.count = len(scene.lights)
        rows = []
        for light in scene.lights:
            far = isinstance(light, DirectionalLight)
            place = -np.array(light.direction) / np.linalg.norm(light.direction) if far else move(
                np.array(light.position))
            # Moved and scaled, intensities grow with the square of lengths.
            power = np.array(light.irradiance if far else light.intensity) * (1 if far else (
                np.linalg.norm(move(np.array((1.0, 0, 0))) - move(np.zeros(3))) ** 2))
            cone = None if far else light.cone
            axis = np.array(cone.direction) / np.linalg.norm(cone.direction) if cone else np.array((0, 0, -1.0))
            inner, outer = np.cos(np.radians((cone.inner, cone.outer))) if cone else (0.0, -2.0)
            rows.append([*place, *power, *axis, inner, outer, far, bool(not far and light.web)])
        self._rows = mi.Float(np.array(rows, dtype=np.float32).ravel()) if rows else None
        self._width = len(rows[0]) if rows else 0
        webs = {id(light.web): light.web for light in scene.lights if not isinstance(light, DirectionalLight)
                and light.web}
        if len(webs) > 1 and len({web.candela.tobytes() for web in webs.values()}) > 1:
            raise ValueError("webs of lights must be the same, not different")
        web = next(iter(webs.values()), None)
        degrees = np.radians(np.arange(181.0))
        self._web = mi.Float((web.factor(np.stack([-np.sin(degrees), 0 * degrees, np.cos(degrees)], axis=1))
                              if web else np.ones(181)).astype(np.float32))

    def irradiance(self, world, si, chance):
        """Of the chosen light on the plane at ``si``, over its probability."""
        number = dr.minimum(mi.UInt32(chance * self.count), self.count - 1)
        value = [dr.gather(mi.Float, self._rows, number * self._width + k) for k in range(self._width)]
        place, power, axis = mi.Vector3f(*value[:3]), mi.Color3f(*value[3:6]), mi.Vector3f(*value[6:9])
        inner, outer, far, web = value[9], value[10], value[11] > 0, value[12] > 0
        toward = dr.select(far, place, place - si.p)
        distance = dr.select(far, 1.0, dr.norm(toward))
        direction = toward / distance
        edge = dr.clip((-dr.dot(direction, axis) - outer) / dr.maximum(inner - outer, 1e-3), 0, 1)
        shape = dr.select(outer > -1.5, edge * edge, 1.0)
        angle = dr.acos(dr.clip(direction.z, -1, 1)) * (180 / np.pi)
        low = dr.minimum(mi.UInt32(angle), 179)
        below, above = dr.gather(mi.Float, self._web, low), dr.gather(mi.Float, self._web, low + 1)
        shape *= dr.select(web, below + (above - below) * (angle - mi.Float(low)), 1.0)
        light = power * shape * self.count / dr.square(distance)
        # A light at infinity is beyond all else.
        away = dr.select(far, 4 * dr.norm(world.bbox().extents()), distance)
        return light * _passed(world, si, si.p + away * direction), direction


def _passed(world, si, target):
    """The share of light that arrives at ``si`` from a point, through panes."""
    ray, share, active = si.spawn_ray_to(target), mi.Color3f(1), mi.Bool(True)
    for _ in range(PANES + 1):
        hit = world.ray_intersect(ray, active)
        bsdf = hit.bsdf()
        pane = hit.is_valid() & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Null)
        share[active & hit.is_valid() & ~pane] = 0
        active &= pane
        share[active] = share * bsdf.eval_null_transmission(hit, active)
        ray = hit.spawn_ray_to(target)
    share[active] = 0
    return share


@dr.syntax
def _radiance(world, lights, has_emitters, sampler, ray):
    """Radiance along rays, and what of it bodies of glass throw."""
    context = mi.BSDFContext()
    count = dr.width(ray)
    light, thrown, weight = dr.zeros(mi.Color3f, count), dr.zeros(mi.Color3f, count), mi.Color3f(1)
    depth, active = mi.UInt32(0), mi.Bool(True)
    diffuse, bent, delta = mi.Bool(False), mi.Bool(False), mi.Bool(True)
    before, density = dr.zeros(mi.Interaction3f), mi.Float(1)
    ray = mi.Ray3f(ray)
    while active:
        si = world.ray_intersect(ray, active)
        share = mi.Float(1)
        if dr.hint(has_emitters, mode="scalar"):
            emitter = si.emitter(world)
            sample = mi.DirectionSample3f(world, si, before)
            other = world.pdf_emitter_direction(before, sample, ~delta & active)
            share = dr.select(delta, 1.0, _balance(density, other))
            found = weight * emitter.eval(si, active) * share
            light += found
            thrown += dr.select(bent, found, 0)
        bsdf = si.bsdf(ray)
        going = active & si.is_valid() & (depth + 1 < LONGEST)
        smooth = going & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        if dr.hint(has_emitters, mode="scalar"):
            sample, incoming = world.sample_emitter_direction(si, sampler.next_2d(), False, smooth)
            value, other = bsdf.eval_pdf(context, si, si.to_local(sample.d), smooth)
            incoming *= _passed(world, si, sample.p)
            light += dr.select(smooth & (sample.pdf > 0), weight * value * incoming * _balance(sample.pdf, other), 0)
        if dr.hint(lights.count > 0, mode="scalar"):
            arriving, toward = lights.irradiance(world, si, sampler.next_1d())
            light += dr.select(smooth, weight * arriving * bsdf.eval(context, si, si.to_local(toward), smooth), 0)
        chosen, factor = bsdf.sample(context, si, sampler.next_1d(), sampler.next_2d(), going)
        passes = mi.has_flag(chosen.sampled_type, mi.BSDFFlags.Null)
        is_delta = mi.has_flag(chosen.sampled_type, mi.BSDFFlags.Delta)
        solid = mi.has_flag(bsdf.flags(), mi.BSDFFlags.DeltaTransmission)
        diffuse |= ~is_delta
        bent = is_delta & (bent | (solid & diffuse))
        # A pane that is passed straight changes nothing of what shadow rays through panes find as well.
        delta = dr.select(passes, delta, is_delta)
        density = dr.select(passes, density, chosen.pdf)
        before = dr.select(passes, before, mi.Interaction3f(si))
        weight *= factor
        ray = si.spawn_ray(si.to_world(chosen.wo))
        depth[going & ~passes] += 1
        brightest = dr.minimum(dr.max(weight), 0.95)
        kept = (depth < ROULETTE) | (sampler.next_1d() < brightest)
        weight[depth >= ROULETTE] *= dr.rcp(brightest)
        active = going & kept & (dr.max(weight) > 0)
    return light, thrown


def _balance(one, other):
    return dr.select(one > 0, one / (one + other), 0)


def _rgb(value):
    return {"type": "rgb", "value": list(value)}


def _bsdf(material, *, two_sided):
    """Of surfaces that are diffuse, or a mirror, or glass."""
    kinds = [name for name in ("diffuse", "specular", "transparent") if any(getattr(material, name))]
    if len(kinds) > 1:
        raise ValueError(f"material {material.name!r}: it must be diffuse, specular or transparent, not several")
    if kinds == ["transparent"]:
        return {"type": "thindielectric" if material.thin else "dielectric", "int_ior": material.refraction_index,
                "ext_ior": 1.0, "specular_reflectance": _rgb(material.transparent),
                "specular_transmittance": _rgb(material.transparent)}
    if kinds == ["specular"]:
        bsdf = {"type": "conductor", "material": "none", "specular_reflectance": _rgb(material.specular)}
    else:
        bsdf = {"type": "diffuse", "reflectance": _rgb(material.diffuse)}
    return {"type": "twosided", "bsdf": bsdf} if two_sided else bsdf

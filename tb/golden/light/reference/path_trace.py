"""Path-trace a built-in scene with Mitsuba: the reference of our rendered images.

``python -m tb.golden.light.reference.path_trace cornell`` writes ``cornell.npz`` beside this file: ``image``, 128 x 128
x 3 float16 radiance, and the settings it was made with. Needs ``pip install -e .[reference]``. Only diffuse materials.
"""

from pathlib import Path

import click
import mitsuba
import numpy as np

from golden.scene.builtin import builtin_scene
from golden.scene.scene import Scene

SIZE = 128


def path_trace(scene: Scene, *, samples: int, size: int = SIZE) -> np.ndarray:
    """Radiance of a scene of diffuse one-sided patches by unbounded path tracing, size x size x 3."""
    sensor = {
        "type": "perspective", "fov_axis": "y", "fov": scene.camera.fov, "near_clip": 1e-3 * scene.size,
        "to_world": mitsuba.ScalarTransform4f().look_at(origin=scene.camera.eye, target=scene.camera.target,
                                                        up=scene.camera.up),
        "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
        "sampler": {"type": "independent", "sample_count": samples},
    }
    shapes = {f"material-{number}": _shape(scene, number) for number in np.unique(scene.material).tolist()}
    world = mitsuba.load_dict({"type": "scene", "integrator": {"type": "path", "max_depth": -1, "rr_depth": 8},
                               "sensor": sensor} | shapes)
    return np.array(mitsuba.render(world, seed=0))


def _shape(scene, number):
    """All patches of one material as a mesh."""
    material = scene.materials[number]
    members = scene.material == number
    quads = scene.vertices[members]
    second = ~scene.is_triangle[members]
    triangles = np.concatenate([quads[:, :3], quads[second][:, [0, 2, 3]]])
    mesh = mitsuba.Mesh(f"material-{number}", vertex_count=3 * len(triangles), face_count=len(triangles),
                        has_vertex_normals=False, props=_properties(material))
    parameters = mitsuba.traverse(mesh)
    parameters["vertex_positions"] = triangles.astype(np.float32).ravel()
    parameters["faces"] = np.arange(3 * len(triangles), dtype=np.uint32)
    parameters.update()
    return mesh


def _properties(material):
    properties = mitsuba.Properties()
    reflectance = {"type": "rgb", "value": list(material.diffuse)}
    properties["bsdf"] = mitsuba.load_dict({"type": "diffuse", "reflectance": reflectance})
    if material.emits:
        properties["emitter"] = mitsuba.load_dict(
            {"type": "area", "radiance": {"type": "rgb", "value": list(material.emission)}})
    return properties


@click.command()
@click.argument("name")
@click.option("--samples", default=16384, show_default=True, help="Paths per pixel.")
def main(name: str, samples: int) -> None:
    """Write the reference image of the built-in scene NAME."""
    image = path_trace(builtin_scene(name), samples=samples)
    np.savez_compressed(Path(__file__).with_name(f"{name}.npz"), image=image.astype(np.float16), samples=samples,
                        mitsuba=mitsuba.__version__)


if __name__ == "__main__":
    mitsuba.set_variant("scalar_rgb")
    main()

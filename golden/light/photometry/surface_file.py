"""The solved light of a scene's surfaces, as a mesh with colours."""

from pathlib import Path

import numpy as np
import trimesh

from golden.base.output import whole_file
from golden.light.indirect import IndirectLight
from golden.light.photometry.quantities import lux
from golden.light.tone import automatic_exposure
from golden.scene.export import Y_UP, rotation_between
from golden.scene.scene import Scene

__all__ = ["write_surfaces"]

_UNLIT = "KHR_materials_unlit"


def write_surfaces(path: Path, scene: Scene, indirect: IndirectLight, *, efficacy: float,
                   exposure: float | None = None) -> None:
    """Write the elements as a .glb whose vertices have the colour of the solved radiosity.

    The colour is linear: the radiosity over pi times the exposure, cut off at 1; viewers show it unlit. Each vertex has
    two numbers more, ``_ILLUMINANCE`` in lux and ``_RADIOSITY`` (luminous exitance) in lm/m2. A value at a vertex is
    the mean of those of the elements that share its node; colours between vertices are interpolated. Backs of two-sided
    patches are triangles of their own.

    Parameters
    ----------
    scene, indirect
        The patches, and the light of their elements.
    efficacy
        Luminous efficacy, lm/W.
    exposure
        The factor of the colours. Default: that of `automatic_exposure`.
    """
    elements = indirect.elements
    nodes = _corner_nodes(elements)
    share = np.asarray(elements.of_corners.sum(axis=0)).ravel()
    received, radiosity = (((elements.of_corners.T @ light) / np.where(share > 0, share, 1)[:, None])[nodes]
                           for light in (indirect.received, indirect.radiosity))
    exposure = automatic_exposure(indirect.radiosity) if exposure is None else exposure
    faces = 4 * np.arange(len(elements))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    faces = np.where(elements.front[:, None, None], faces, faces[..., ::-1])
    faces = faces[np.stack((np.ones_like(elements.triangle), ~elements.triangle), axis=1)]
    attributes = {"_COLOR_0": np.clip(exposure * radiosity, 0, 1), "_ILLUMINANCE": lux(received, efficacy)[..., None],
                  "_RADIOSITY": lux(radiosity, efficacy)[..., None]}
    vertices = elements.vertices.reshape(-1, 3) @ rotation_between(scene.up, Y_UP).T + 0.0
    mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False, vertex_attributes={
        name: values.reshape(len(vertices), -1).astype(np.float32) for name, values in attributes.items()})

    def complete(tree: dict) -> None:
        tree["asset"]["generator"] = "radiosity-engine"
        tree["materials"] = [{"name": "radiosity", "extensions": {_UNLIT: {}}}]
        tree["extensionsUsed"] = [_UNLIT]
        primitive = tree["meshes"][0]["primitives"][0]
        primitive["material"] = 0
        # trimesh writes only bytes as colours, and other attributes with an underscore.
        primitive["attributes"]["COLOR_0"] = primitive["attributes"].pop("_COLOR_0")

    with whole_file(path) as part:
        part.write_bytes(trimesh.exchange.gltf.export_glb(trimesh.Scene(mesh), include_normals=False,
                                                          tree_postprocessor=complete))


def _corner_nodes(elements):
    """C x 4: the node at each corner of the elements."""
    position = elements.position
    away = np.linalg.norm(elements.vertices[:, :, None] - elements.lattice.position[position.nodes][:, None], axis=3)
    away[np.broadcast_to((position.weights == 0)[:, None], away.shape)] = np.inf
    return np.take_along_axis(position.nodes, away.argmin(axis=2), axis=1)

"""Small files of all formats, and the scenes that they become, as values that a reader can compare.

tb/golden/scene/loaded.json has the scenes, about ten values of which were compared by hand with the formats'
definitions; `python -m tb.golden.scene.loaded` makes it anew.
"""

import json
import struct
import tempfile
import warnings
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from golden.errors import InputError, InputWarning
from golden.scene.load import load_scene
from golden.scene.texture import Texture

__all__ = ["FILES", "RECORD", "loaded"]

RECORD = Path(__file__).parent / "loaded.json"
# Patches up to which vertices are listed.
_LISTED = 4

_SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0.5\nv 0 0 3\nv 2 0 3\nv 1 1 3\n"
_MTL = """# shares, in all of their spellings
newmtl dull
Kd 0.5
Ks 0.3 0.3 0.3
Ns 499
newmtl shiny
Kd 0.2 0.3 0.4
Ks 0.6 0.5 0.4
Ns 500
newmtl sheet
Kd 0.5 0.5 0.5
d 0.25
Tf 0.2 0.4 0.6
Ni 1.4
newmtl glass
Kd 0 0 0
Tr 0.9
Ni 1.6
illum 4
newmtl bright
Kd 0.9 0.9 0.9
Ks 0.6 0.3 0
illum 3
Ke 7 8 9
Ka 1 1 1
newmtl painted
map_Kd -clamp on picture.png
newmtl twice
Kd 0.5 1 1
map_Kd picture.png
bump picture.png
"""
_OBJ = f"""mtllib a.mtl gone.mtl
{_SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 2
usemtl dull\nf 1 2 3 4
usemtl {{name}}\nf -1/1 -2/2 \\
-3/3
vn 0 0 1
p 1
"""
_NFF = """b 0.1 0.2 0.3
v
from 1 2 3
at 0 0 1
up 0 1 0
angle 50
hither 1
resolution 20 10
l 3 0 0
l 0 -3 4 0.5 0.25 1
p 3
0 0 0
1 0 0
0 1 0
f 0.5 0.6 0.7 0.8 0.4 30 0 1.5
p 4
0 0 1
1 0 1
1 1 1
0 1 1
f 1 0.5 0.25 0.3 0.1 5 0.4 1.7
pp 3
0 0 2 0 0 1
1 0 2 0 1 1
0 1 2 1 0 1
pp 3
1 0 2 0 0 1
1 1 2 0 1 1
0 1 2 1 0 1
"""
_PLY = """ply
format ascii 1.0
comment made by hand
element vertex 5
property float x
property double y
property float z
{vertex}
element face 2
property list uchar int {corners}
{face}
element edge 1
property int a
end_header
"""
_STL = """solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid
"""
_VS3 = """T title
C encl=1
F 3
V 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nV 5 0 0 1\nV 6 1 0 1\nV 7 1 1 1
S 1 1 2 3 4 0 0 0.5 floor
S 2 5 7 6 0 0 1 0.9
O 3 1 2 6 5
End of data
"""


def _gltf(*, materials=(), nodes=None, root=0, primitive=None, uv=None, **more):
    """GLB of a square of which three corners have the height 0, with coordinates of a picture."""
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5)], dtype="<f4").tobytes()
    corners = np.array([0, 1, 2, 0, 2, 3], dtype="<u2").tobytes()
    coordinates = np.array([(0, 0), (1, 0), (1, 1), (0, 1)] if uv is None else uv, dtype="<f4").tobytes()
    colours = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], dtype="<f4").tobytes()
    binary = points + corners + coordinates + colours
    starts = np.cumsum([0, len(points), len(corners), len(coordinates)]).tolist()
    lengths = [len(points), len(corners), len(coordinates), len(colours)]
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [root]}], "nodes": nodes or [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1,
                                        **({"material": 0} if materials else {}), **(primitive or {})}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
                          {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
                          {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": length}
                            for start, length in zip(starts, lengths, strict=True)],
            "buffers": [{"byteLength": len(binary)}], "materials": list(materials), **more}
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4s4I", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text
            + struct.pack("<2I", len(binary), 0x004E4942) + binary)


def _binary_ply(order):
    mark = {"little": "<", "big": ">"}[order]
    rows = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 1)]
    data = b"".join(struct.pack(f"{mark}fff", *row) for row in rows)
    data += struct.pack(f"{mark}B4iHHH", 4, 0, 1, 2, 3, 65535, 32768, 0)
    data += struct.pack(f"{mark}B3iHHH", 3, 1, 4, 2, 0, 0, 13107)
    head = (f"ply\nformat binary_{order}_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
            "property float z\nelement face 2\nproperty list uchar int vertex_index\nproperty ushort red\n"
            "property ushort green\nproperty ushort blue\nend_header\n")
    return head.encode() + data


_LIGHTS = {"KHR_lights_punctual": {"lights": [
    {"type": "point", "intensity": 4, "color": [1, 0.5, 0.25]}, {"type": "directional", "intensity": 2},
    {"type": "spot", "intensity": 3, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}, "range": 3},
    {"type": "spot"}, {"type": "moon"}]}}
_TURN = [0.5, 0.5, 0.5, 0.5]
_NODES = [{"children": [1, 2, 3, 4, 5], "translation": [1, 2, 3], "scale": [2, 2, 2]},
          {"mesh": 0, "rotation": _TURN}, {"camera": 0, "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 4, 5, 6, 1]},
          {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 0, 1]},
          {"extensions": {"KHR_lights_punctual": {"light": 1}}, "rotation": _TURN},
          {"extensions": {"KHR_lights_punctual": {"light": 2}}, "rotation": _TURN, "children": [6]},
          {"extensions": {"KHR_lights_punctual": {"light": 3}}}]
_GLASS = {"name": "glass", "doubleSided": False, "pbrMetallicRoughness": {
    "baseColorFactor": [0.9, 0.8, 0.7, 0.5], "metallicFactor": 0.25, "roughnessFactor": 0.25},
    "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.8}, "KHR_materials_ior": {"ior": 1.7}}}
_PAINTED = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0},
            "emissiveTexture": {"index": 0}, "emissiveFactor": [2, 1, 1]}
_PICTURES = {"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33648, "wrapT": 33071}],
             "images": [{"uri": "picture.png"}]}

# The name of each file with its content.
FILES = {
    **{f"{name}.obj": _OBJ.format(name=name) for name in ("shiny", "sheet", "glass", "bright", "painted", "twice")},
    "concave.obj": "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nf 1 2 3 4\n",
    "creased.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0.2\nv 2 1 0.2\nv 3 0 1.5\nv 3 1 1.5\n"
                   "f 1 2 3 4\nf 2 5 6 3\nf 5 7 8 6\n",
    "all.nff": _NFF, "round.nff": "s 1 2 3 0.5\nc 0 0 0 1 0 0 2 0.5\nl 5 5 5\n",
    "vertex.ply": _PLY.format(vertex="property uchar red\nproperty uchar green\nproperty uchar blue", face="",
                              corners="vertex_indices").replace("\n\n", "\n")
    + "0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 0 128 128 128\n2 0 1 0 0 0\n4 0 1 2 3\n3 1 4 2\n7\n",
    "face.ply": _PLY.format(vertex="property float nx\nproperty float quality",
                            face="property float red\nproperty float green\nproperty float blue",
                            corners="vertex_index")
    + "0 0 0 1 9\n1 0 0 1 9\n1 1 0 1 9\n0 1 0 1 9\n2 0 1 1 9\n4 0 1 2 3 0.5 0.25 2\n3 1 4 2 0.1 0.2 0.3\n7\n",
    "little.ply": _binary_ply("little"), "big.ply": _binary_ply("big"), "text.stl": _STL,
    "binary.stl": b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0),
    "enclosure.vs3": _VS3, "plain.glb": _gltf(),
    "nodes.glb": _gltf(nodes=_NODES, extensions=_LIGHTS, extensionsUsed=["KHR_lights_punctual", "EXT_other"],
                       cameras=[{"type": "perspective", "perspective": {"yfov": 0.5}}] * 2),
    "mirrored.glb": _gltf(nodes=[{"mesh": 0, "scale": [-1, 1, 1]}], materials=[{"doubleSided": False}]),
    "glass.glb": _gltf(materials=[_GLASS]), "open.glb": _gltf(materials=[_GLASS | {"alphaMode": "BLEND"}]),
    "thick.glb": _gltf(materials=[_GLASS | {"extensions": _GLASS["extensions"] | {
        "KHR_materials_volume": {"thicknessFactor": 1}}}]),
    "rough.glb": _gltf(materials=[{"pbrMetallicRoughness": {"metallicFactor": 0.5, "roughnessFactor": 0.26}}]),
    "lamp.glb": _gltf(materials=[{"emissiveFactor": [1, 0.5, 0], "extensions": {
        "KHR_materials_emissive_strength": {"emissiveStrength": 3}}}]),
    "painted.glb": _gltf(materials=[_PAINTED], **_PICTURES),
    "far.glb": _gltf(materials=[_PAINTED], uv=[(1.2, 1.2), (1.4, 1.2), (1.4, 1.4), (1.2, 1.4)], **_PICTURES),
    "coloured.glb": _gltf(primitive={"attributes": {"POSITION": 0, "COLOR_0": 3}}, materials=[
        {"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 1, 1, 1]}}]),
}


def loaded(name: str) -> dict | str:
    """The scene of a file with what is warned of, or the error."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        path, content = Path(folder) / name, FILES[name]
        pixels = np.array([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (188, 188, 188)]], dtype=np.uint8)
        Image.fromarray(pixels).save(Path(folder) / "picture.png")
        (Path(folder) / "a.mtl").write_text(_MTL)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        try:
            scenes = [load_scene(path), load_scene(path, up=(1, 0, 0), facets=True)]
        except InputError as error:
            return str(error).replace(folder, "")
        whole, facets = (_plain({one.name: getattr(scene, one.name) for one in fields(scene)}) for scene in scenes)
        changed = {key: value for key, value in facets.items() if value != whole[key]}
        found = {"scene": whole, "as facets with up +x": changed,
                 "warnings": sorted({str(one.message) for one in caught})}
        return json.loads(json.dumps(found).replace(folder, ""))


def _plain(value):
    """In the types of JSON, numbers to nine digits."""
    if isinstance(value, np.ndarray) and value.ndim == 3 and len(value) > _LISTED:
        flat = value.ravel()
        return f"{len(value)} patches, {flat.sum():.6f}, {flat @ np.sqrt(1 + np.arange(len(flat))):.6f}"
    if isinstance(value, np.ndarray) and len(value) > 3 * _LISTED:
        return f"{len(value)}: {len(np.unique(value))} different, {(value * (1 + np.arange(len(value)))).sum()}"
    if isinstance(value, Texture):
        return _plain(value.at(np.array([(0.25, 0.75), (0.6, 0.4), (1.2, 0.7), (0.7, -0.3)])).tolist())
    if is_dataclass(value):
        return {one.name: _plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, (tuple, list)):
        return [_plain(one) for one in value]
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (float, np.floating)):
        return float(f"{value:.9g}") + 0.0
    return value if isinstance(value, int | None) else str(value)


if __name__ == "__main__":
    lines = (f" {json.dumps(name)}: {json.dumps(loaded(name))}" for name in FILES)
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n")

"""Scenes from files."""

from dataclasses import replace
from pathlib import Path

from golden.base.errors import InputError
from golden.base.input_warnings import caught_warnings, warn
from golden.scene.facets import facet_scene
from golden.scene.mesh import mesh_scene
from golden.scene.nff import read_nff
from golden.scene.obj import read_obj
from golden.scene.parser import check_regular
from golden.scene.ply import read_ply
from golden.scene.scene import Scene
from golden.scene.stl import read_stl
from golden.scene.vs3 import read_vs3

__all__ = ["FACETED", "SUFFIXES", "UP", "load_scene"]

SUFFIXES = (".obj", ".ply", ".stl", ".gltf", ".glb", ".nff", ".vs3")

LONGEST = 400
"""Most characters of a message: files may hold words of any length."""

_Y, _Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
UP = {".obj": _Y, ".gltf": _Y, ".glb": _Y, ".ply": _Z, ".stl": _Z, ".vs3": _Z}
"""The direction that is up in files of these suffixes; NFF files state it."""

FACETED = (".obj", ".ply", ".stl", ".gltf", ".glb")
"""Suffixes of the files whose faces ``facets`` keeps; VS3 files have facets in any case."""

_READERS = {".obj": read_obj, ".ply": read_ply, ".stl": read_stl}


def _read(path: Path, facets: bool) -> Scene:
    """The scene of a file with the reader of its suffix."""
    suffix, name, where = path.suffix.lower(), path.stem, str(path)
    if suffix == ".nff":
        return read_nff(path.read_bytes(), where)
    if suffix == ".vs3":
        return read_vs3(path)
    make = facet_scene if facets else mesh_scene
    properties = {"name": name, "where": where, "up": UP[suffix]}
    if suffix in _READERS:
        return make(_READERS[suffix](path), **properties)
    from golden.scene.gltf import read_gltf  # slow

    mesh, view = read_gltf(path)
    return make(mesh, **properties, **view)


def load_scene(path, *, facets: bool = False) -> Scene:
    """The scene of a file: .obj (with .mtl), .ply, .stl, .gltf, .glb, .nff or .vs3.

    Coordinates stay as they are in the file, in its unit of length. Pairs of triangles that form a quad are merged,
    polygons are cut into quads and triangles (`golden.scene.mesh.mesh_scene`). `read_mtl`, `gltf_material` and
    `read_ply` describe the materials; STL has none. All patches are two-sided, whether meshes are closed or not: the
    camera may be inside a closed room whose faces look outwards. Only glTF states sides: its faces are one-sided unless
    their material states ``doubleSided``. `read_vs3` has rules of its own, and ``facets`` those of `facet_scene`.

    Parameters
    ----------
    path
        Path of the file; its suffix selects the reader.
    facets
        Whether each face of the file is one surface, in the file's order, whose front alone radiates, see
        `facet_scene`.

    Raises
    ------
    InputError
        One line with the path, the fault and its position: no such file, a directory, an unknown suffix, bad content,
        or anything that `mesh_scene`, `facet_scene` or `read_vs3` refuses.

    Warns
    -----
    InputWarning
        One line with the path and all that the file holds and the scene does not use.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: it is a directory, not a scene file")
    if not path.exists():
        raise InputError(f"{path}: no such file")
    check_regular(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: Suffix must be one of {' '.join(SUFFIXES)}, not {path.suffix!r}")
    try:
        with caught_warnings() as caught:
            scene = _read(path, facets)
    except InputError as error:
        text = str(error) if str(error).startswith(str(path)) else f"{path}: {error}"
        raise InputError(_clipped(text, LONGEST + len(str(path)))) from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    for message in caught:
        warn(f"{path}: {_clipped(message, LONGEST)}")
    return replace(scene, files=(path, *scene.files))


def _clipped(text, length):
    return text if len(text) <= length else f"{text[:length]} ..."

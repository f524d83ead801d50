"""The machine in integers runs by numpy alone: a processor's port of it needs no compiler of ours."""

import subprocess
import sys

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene

# Arguments: modules that cannot be imported.
PROGRAM = """
import pkgutil, sys
from importlib import import_module
sys.modules.update(dict.fromkeys(sys.argv[1:]))
import golden.engine
for module in pkgutil.walk_packages(golden.engine.__path__, "golden.engine."):
    import_module(module.name)
from tb.golden.engine.test_without_compiler import cast
print(*cast())
"""


def cast() -> list[int]:
    """The patches that a hemisphere of rays from a patch of the Cornell box hits."""
    scene, config = open_scene("cornell"), PRESETS["small"]
    geometry = PatchGeometry.of(scene, config.numbers, scene.centres[:1])
    record = hemisphere_record(Hemisphere(32, 8), geometry.coordinates, scene.centres[0], scene.normals[0], source=0)
    return Shelling(geometry, config, cell=0.25).cast(record)[0].patch.tolist()


def test_every_module_is_imported_and_a_hemisphere_cast_as_with_a_compiler():
    without = subprocess.run([sys.executable, "-c", PROGRAM, "numba", "amaranth", "click"], check=True,
                             capture_output=True, text=True).stdout.split()
    assert list(map(int, without)) == cast()
    assert "numba" in sys.modules
    assert len(set(without)) > 5

"""Scenes: patches, materials, cameras, files and built-in scenes."""

from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material, Rgb
from golden.scene.scene import Scene

__all__ = ["Camera", "Material", "PointLight", "Rgb", "Scene"]

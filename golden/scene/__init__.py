"""Scenes: patches, materials, cameras, files and built-in scenes."""

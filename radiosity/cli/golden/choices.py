"""Names that options accept, without the modules that implement them: help must not import those.

A test compares every list with the registry that it names.
"""

__all__ = ["CURVES", "EXPORT_SUFFIXES", "FIXED_METHODS", "FRUSTUM_METHODS", "GATHER_ASSIGNMENTS",
           "GATHER_COMPLETIONS", "GATHER_SCHEMES", "GATHER_SOLVERS", "HIT_FORMATS", "LENGTH_UNITS",
           "MERGE_DIVISIONS", "MERGE_SCHEMES", "PRESETS", "RAY_METHODS", "RECORD_METHODS", "REFERENCES",
           "SCENE_SUFFIXES", "SKIES", "SKY_DIVISIONS", "SOLVERS", "STIMULUS_BLOCKS", "STIMULUS_SUFFIXES",
           "TOPOLOGIES", "TORUS_GROWTHS", "TORUS_STORAGES", "VOLUME_SPLITTERS"]

PRESETS = ("tiny", "small", "paper", "thesis", "large", "board")
TOPOLOGIES = ("mesh", "torus", "ring", "illiac", "hypercube")
# Methods that cast any rays, those in fixed point, and all that cast frusta for the renderer.
RAY_METHODS = ("grid", "naive", "embree")
FIXED_METHODS = ("shelling", "naive-fixed")
FRUSTUM_METHODS = (*RAY_METHODS, *FIXED_METHODS)
# Units of length of a scene.
LENGTH_UNITS = ("m", "mm", "cm", "km", "in", "ft")
# Methods of `cast`, and what it compares their hits with.
RECORD_METHODS = ("shelling", "naive")
REFERENCES = ("naive", "oracle")
SOLVERS = ("gauss-jacobi", "gauss-seidel", "over-relaxation", "progressive", "overshooting", "proximity",
           "conjugate-gradient")
# `golden.engine.jobs.result_formats.HitFormat`.
HIT_FORMATS = ("none", "full", "compact", "ids")
# Names of `radiosity.machines.gather`.
GATHER_SCHEMES = ("circulation", "sharing", "demand-driven")
GATHER_ASSIGNMENTS = ("random", "scattered", "tiled")
GATHER_SOLVERS = ("gauss-jacobi", "conjugate-gradient")
GATHER_COMPLETIONS = ("shift", "merge")
# `radiosity.machines.koan.pixel_items.SCHEDULES`.
KOAN_SCHEDULES = ("mixed", "static", "scattered")
# Names of `radiosity.machines.merge`.
MERGE_SCHEMES = ("ring", "mesh", "pair", "aapc")
MERGE_DIVISIONS = ("equal", "recursive", "packed")
VOLUME_SPLITTERS = ("hs", "rs", "rrs", "mahd", "hcs", "gs")
# Names of `radiosity.machines.torus`.
TORUS_GROWTHS = ("axis", "volume")
TORUS_STORAGES = ("array", "hash")
CURVES = ("reinhard", "linear")
SKY_DIVISIONS = ("tregenza", "reinhart")
SKIES = ("uniform", "cie-overcast", "cie-clear", "perez")
SCENE_SUFFIXES = (".obj", ".ply", ".stl", ".gltf", ".glb", ".nff", ".vs3")
EXPORT_SUFFIXES = (".glb", ".obj", ".ply", ".stl")
STIMULUS_SUFFIXES = (".npz", ".jsonl")
STIMULUS_BLOCKS = (
    "cordic", "ctu.cell_traversal", "ctu.grid_rays", "ctu.near_cells", "ctu.ray_memory", "ctu.sector",
    "ctu.settle_pyramid", "ctu.survival", "ctu.unit", "icu.patch_sums", "icu.edge_planes", "icu.g2r_transform",
    "icu.intersection", "icu.inverse_distance", "icu.ipbb", "icu.patch_setup", "icu.plane_factor", "icu.ray_memory",
    "icu.reciprocal", "icu.sbb", "icu.screening", "icu.section_clip", "icu.settle_code", "icu.uv_subdivision",
    "icu.vertex_direction", "icu.window_walk", "memsys.cell_table", "memsys.filter", "memsys.istructure",
    "memsys.patch_table")

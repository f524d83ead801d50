"""What a user of meshes does first: view factors, a table, an exchange, a picture, and a cast on the simulated machine.

``python notebook.py`` does all but the last, ``python notebook.py machine`` all.
"""

import sys

import trimesh

import radiosity

# %% A closed room, seen from inside.
box = trimesh.creation.box((4, 3, 2.5))
box.invert()
names = ["lamp" if height > 1.2 else "floor" if height < -1.2 else "wall" for height in box.triangles_center[:, 2]]
lamp = radiosity.Material(name="lamp", diffuse=(0.8, 0.8, 0.8), emission=(10, 10, 10))
scene = radiosity.Scene.from_trimesh(box, names=names, materials={"lamp": lamp})
print(scene)  # noqa: T201

# %% View factors, and a table of them by surface.
factors = radiosity.view_factors(scene, error=0.05, jobs=1)
table = factors.to_dataframe()
assert abs(table.sum(axis=1) - 1).max() < 1e-9

# %% The heat that the surfaces exchange.
heat = factors.exchange(temperature={"lamp": 350, "floor": 290, "wall": 293}, emissivity=0.9)
assert abs((heat.flux * factors.area).sum()) < 1e-6

# %% A picture.
camera = radiosity.Camera(eye=(1.8, 1.3, 0), target=(0, 0, -0.3), fov=70)
picture = radiosity.render(scene, camera=camera, size=(6, 4), samples=1, light_samples=1, depth=1, elements=12,
                           rays=(16, 4), jobs=1)
picture.save("room.png")
assert picture.statistics.rays["primary"].rays == 24

# %% A hemisphere on the simulated machine.
if sys.argv[1:] == ["machine"]:
    cast = radiosity.machine(scene, patch=0, rays=(16, 8), preset="small", clusters=1, casts=2)
    assert cast.agrees
    assert cast.counters["cycles"].shape == (2, 1)

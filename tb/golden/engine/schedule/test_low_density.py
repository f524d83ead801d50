"""What a sparse casting takes for a hit."""

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.low_density import low_density
from tb.golden.engine.schedule.scenes import CONFIG
from tb.golden.light.scenes import BLACK, rectangle, scene_of


def test_rays_pass_where_a_plane_is_beyond_the_farthest_vertex():
    """In half of the triangle's window its plane recedes: those rays are tested against the wall behind."""
    triangle = [[(-0.3, -0.3, 0.5), (0.3, -0.3, 1), (-0.3, 0.3, 1), (-0.3, 0.3, 1)]]
    wall = rectangle((-8, 8, 4), (16, 0, 0), (0, -16, 0))
    scene = scene_of((np.array(triangle), BLACK, {"two_sided": True}), (wall, BLACK, {"two_sided": True}))
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [(0, 0, 0)])
    record = hemisphere_record(Hemisphere(64, 32), geometry.coordinates, (0, 0, 0), (0, 0, 1))
    shelling = Shelling(geometry, CONFIG, cell=0.125)
    hits = shelling.cast(record)[0]
    found = low_density(record, geometry, shelling.table, CONFIG, ratio=1)
    # The window has three times the triangle's rays. Where its plane is near, they all end there.
    reach_wall = (hits.patch == 1).sum()
    assert found.frequency[0] > 3 * (hits.patch == 0).sum()
    assert 0.8 * reach_wall < found.frequency[1] < reach_wall

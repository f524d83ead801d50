"""Light that arrives at sensors."""

import numpy as np

from golden.cast.casters import CastsRays
from golden.cast.hemisphere import Hemisphere
from golden.cast.methods import shadow_caster
from golden.light.direct import DirectLight
from golden.light.final_gather import FinalGather
from golden.light.indirect import IndirectLight
from golden.light.photometry.sensors import Sensors
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.scene import Scene

__all__ = ["sensor_light"]

# Of the rays of a sensor's hemisphere one in so many gathers, where it ends within so many elements' lengths.
LESS, NEARBY = 16, 4.0


def sensor_light(scene: Scene, sensors: Sensors, indirect: IndirectLight, caster: CastsRays, tally: Tally, *,
                 hemisphere: Hemisphere, light_samples: int, seed: int, frusta=None) -> np.ndarray:
    """Irradiance over pi at S sensors, S x 3 in units of radiance: direct light by shadow rays, the rest by rows.

    Light that changes within the elements nearby is gathered by rays.

    Parameters
    ----------
    scene, sensors, indirect
        The patches, the points, and the light of the elements.
    caster, tally
        Caster of shadow rays, and the counts of rays.
    hemisphere
        The grid of rays at each sensor.
    light_samples
        Shadow rays per sensor to area lights.
    seed
        Seed of the shadow rays.
    frusta
        Caster of frusta, or None: ``caster`` casts all rays.
    """
    points = SurfacePoints(sensors.position, sensors.normal, sensors.patches(scene, caster))
    number = np.arange(len(sensors))
    direct = DirectLight(scene, caster, tally, light_samples, frusta=shadow_caster(frusta),
                         rays=light_samples * len(points))
    nearby = FinalGather(scene, indirect, caster, tally, len(hemisphere) // LESS, shadow_caster(frusta), reach=NEARBY)
    around = indirect.rows.cast(points.position, points.normal, points.sources(scene), hemisphere)
    return (direct.irradiance(points, mix(seed, 7, number)) + nearby.correction(points, mix(seed, 8, number))
            + around.gathered(indirect.display))

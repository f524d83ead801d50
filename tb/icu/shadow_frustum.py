"""Shadow frusta for blocks that take frusta of all kinds."""

import numpy as np

from golden.engine.config import Config
from golden.engine.frustum.shadow_record import ShadowRecord, position, shadow_record
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.stimulus.frusta import SOURCE

__all__ = ["random_shadow"]


def random_shadow(random: np.random.Generator, config: Config, bits: int = 4) -> ShadowRecord:
    """A shadow frustum from a random point, with rays in most of its positions."""
    axes, coordinates = np.linalg.qr(random.normal(size=(3, 3)))[0], GCoordinates(
        corner=np.zeros(3), scale=1.0, numbers=config.numbers, bounds=np.array([[0.1] * 3, [0.9] * 3]))
    axes[0] *= np.linalg.det(axes)
    one = 1 << config.numbers.direction_fraction
    slopes = random.integers(-one, one, (2 << 2 * bits, 2))
    _, first = np.unique(position(slopes, bits, config.numbers), return_index=True)
    end = random.integers(1, config.numbers.inverse.high, len(first), endpoint=True)
    return shadow_record(coordinates, coordinates.integers(random.uniform(0.3, 0.7, 3)), axes, bits,
                         slopes=slopes[first], end=end, source=SOURCE)[0]

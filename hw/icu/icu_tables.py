"""Constants and tables of the golden model that the intersection unit is built from.

Components of this folder import golden's numbers from here only, so that this is the list of what both must agree on.
"""

from golden.engine.icu.edge_planes import DIAGONAL, EDGES
from golden.engine.icu.inverse_distance import BOUND_BITS, SMALLEST
from golden.engine.icu.plane_factor import GUARD, NEAREST_PLANE
from golden.engine.icu.sbb import GAIN_FRACTION, SAGITTA_BITS, sagitta_table, window_errors
from golden.engine.icu.settle_code import scale
from golden.engine.lib.cordic import gain, linear_error
from golden.engine.memory_map import WEIGHT_BITS

__all__ = ["BOUND_BITS", "DIAGONAL", "EDGES", "GAIN_FRACTION", "GUARD", "NEAREST_PLANE", "SAGITTA_BITS", "SMALLEST",
           "WEIGHT_BITS", "gain", "linear_error", "sagitta_table", "scale", "window_errors"]

"""Routes, topologies and check bits of the golden model that the network is built from.

Components of this folder import them from here only, so that this is the list of what both must agree on.
"""

from golden.noc.packing import CHECK_BITS, VERTICES, check
from golden.noc.reach import reach
from golden.noc.routing import Routing, check_deadlock_free, route
from golden.noc.topology import LOCAL

__all__ = ["CHECK_BITS", "LOCAL", "VERTICES", "Routing", "check", "check_deadlock_free", "reach", "route"]

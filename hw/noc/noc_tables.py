"""Routes, topologies and check bits of the golden model that the network is built from.

Components of this folder import them from here only, so that this is the list of what both must agree on.
"""

from golden.engine.noc.packing import CHECK_BITS, check
from golden.engine.noc.reach import reach
from golden.engine.noc.routing import Routing, check_deadlock_free, route
from golden.engine.noc.topology import LOCAL

__all__ = ["CHECK_BITS", "LOCAL", "Routing", "check", "check_deadlock_free", "reach", "route"]

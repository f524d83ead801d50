"""Found ahead: how far a cluster alone runs ahead of patches that others hold when it explores a section."""

from radiosity.machines.engine.bus_path import BusTiming
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.joint_cast import JointTiming
from radiosity.machines.engine.store_path import StoreTiming

__all__ = ["found_ahead"]


def found_ahead(timing: ClusterTiming, joint: JointTiming, bus: BusTiming, store: StoreTiming | None = None) -> int:
    """Patches of others that a cluster has found and not read, at most.

    The patch filter stalls, and traversal behind it, when the queue in front of a path is full, which is not before the
    path has all its requests in flight (`hw.lib.credit_gate.CreditGate`). Until then traversal goes on, and survival
    judges grid rays by rays whose patches are still to be tested.

    Parameters
    ----------
    timing, joint, bus
        Of the cluster, of the network and of the bus.
    store
        Of the patch store in front of both. Default: there is none.
    """
    return store.waiting + store.requests if store else timing.requests + max(joint.outstanding, bus.outstanding)

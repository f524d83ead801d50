"""Exploration timing: that of the cluster alone whose cast a machine of several memories replays."""

from dataclasses import replace

from radiosity.machines.engine.bus_path import BusTiming
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.joint_cast import JointTiming
from radiosity.machines.engine.store_path import StoreTiming

__all__ = ["exploration_timing"]


def exploration_timing(timing: ClusterTiming, joint: JointTiming, bus: BusTiming,
                       store: StoreTiming | None = None) -> ClusterTiming:
    """The timing of a cluster that holds all patches and runs as far ahead of them as one whose patches others hold.

    The patch filter stalls, and traversal behind it, when the queue in front of a path is full, which is not before the
    path has all its requests in flight (`hw.lib.credit_gate.CreditGate`). Until then traversal goes on, and survival
    judges grid rays by rays whose patches are still to be tested. So a section that others' patches will be requested
    for is explored with the queue and the requests in flight as one queue. Patches of its own memory never have less
    than theirs.

    Parameters
    ----------
    timing, joint, bus
        Of the cluster, of the network and of the bus.
    store
        Of the patch store in front of both. Default: there is none.
    """
    ahead = store.waiting + store.requests if store else timing.requests + max(joint.outstanding, bus.outstanding)
    return replace(timing, requests=max(timing.requests, ahead))

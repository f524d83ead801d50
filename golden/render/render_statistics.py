"""What a render took."""

from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["RayCounts", "RenderStatistics"]


@dataclass(frozen=True, kw_only=True)
class RayCounts:
    """Rays of a kind, how many of them hit, and their ray-patch tests and cell steps."""

    rays: int
    hits: int
    tests: int
    steps: int


@dataclass(frozen=True, kw_only=True)
class RenderStatistics:
    """Counts and times of a render.

    Parameters
    ----------
    patches, elements, nodes
        Of the scene, of its first pass, and hemispheres that it cast.
    rays
        The counts of each kind: hemisphere, transmission, primary, shadow, single shadow (cast beside shadow frusta),
        reflection, refraction, gather, single gather (beside hemispheres that gather).
    total
        Of all kinds.
    seconds
        Of each stage, by the clock.
    solver_steps, converged
        Of the solver of the radiosity system.
    not_computed
        What the picture leaves out, a sentence each.
    noise
        Of a picture with a requested noise the root of the mean square of the pixels' estimated relative errors
        (``"estimate"``), its primary rays per pixel (``"samples"``), and how many pixels are ``"above"`` the request.
    settings
        Names and values that the picture depends on.
    """

    patches: int
    elements: int
    nodes: int
    rays: Mapping[str, RayCounts]
    total: RayCounts
    seconds: Mapping[str, float]
    solver_steps: int
    converged: bool
    not_computed: tuple[str, ...]
    noise: Mapping[str, float] | None
    settings: Mapping[str, object]

    @classmethod
    def of(cls, stats: dict) -> "RenderStatistics":
        """Those of `golden.render.two_pass.RenderResult.stats`."""
        return cls(rays={kind: RayCounts(**counts) for kind, counts in stats["rays"].items()},
                   total=RayCounts(**stats["total"]), solver_steps=stats["solver"]["steps"],
                   converged=stats["solver"]["converged"], not_computed=tuple(stats["not_computed"]),
                   **{name: stats[name] for name in ("patches", "elements", "nodes", "seconds", "noise",
                                                      "settings")})

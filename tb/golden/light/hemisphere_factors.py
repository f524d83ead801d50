"""View factors by hemispheres at fixed points."""

from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.view_factors import ViewFactors

__all__ = ["hemisphere_factors"]


def hemisphere_factors(scene, caster, *, rays: tuple[int, int], samples: int = 1) -> ViewFactors:
    """The view factors between all patches of a scene; the arguments are those of `HemisphereRows`."""
    return compute_view_factors(HemisphereRows(scene, caster, rays=rays, samples=samples))

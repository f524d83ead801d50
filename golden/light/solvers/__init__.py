"""Solvers of the radiosity system, by their names on the command line."""

from golden.light.solvers.conjugate_gradient import conjugate_gradient
from golden.light.solvers.gathering import gauss_jacobi, gauss_seidel, over_relaxation
from golden.light.solvers.iteration import TOLERANCE, Solution
from golden.light.solvers.shooting import ambient_overshooting, progressive_refinement, proximity_refinement
from golden.light.solvers.system import RadiositySystem

__all__ = ["SOLVERS", "TOLERANCE", "RadiositySystem", "Solution"]

# Each takes a `RadiositySystem` and ``tolerance``, ``max_steps`` and ``progress``, and returns a `Solution`.
SOLVERS = {
    "gauss-jacobi": gauss_jacobi,
    "gauss-seidel": gauss_seidel,
    "over-relaxation": over_relaxation,
    "progressive": progressive_refinement,
    "overshooting": ambient_overshooting,
    "proximity": proximity_refinement,
    "conjugate-gradient": conjugate_gradient,
}

"""Stimulus of `golden.engine.icu.plane_factor`."""

from golden.engine.icu.plane_factor import PlaneFactor, plane_factor
from golden.engine.lib.fixed import signed
from golden.engine.stimulus.block import FLAG, Arrays, Block, Field
from golden.engine.stimulus.patches import r_patches

__all__ = ["BLOCK", "factor_arrays", "factor_fields", "factor_of"]


def factor_fields(config) -> list[Field]:
    """Fields of `factor_arrays`."""
    return [Field("mantissa", config.numbers.mantissa, "m in units of 2^factor_exponent"),
            Field("factor_exponent", signed(7, 0), "of m"),
            Field("dropped", FLAG, "the plane passes through the origin, or there is none")]


def factor_arrays(factor: PlaneFactor) -> Arrays:
    """Arrays of plane factors."""
    return {"mantissa": factor.mantissa, "factor_exponent": factor.exponent, "dropped": factor.dropped}


def factor_of(given: Arrays) -> PlaneFactor:
    """The plane factors of their arrays."""
    return PlaneFactor(given["mantissa"], given["factor_exponent"], given["dropped"].astype(bool))


def _fields(config):
    return [Field("vertices", config.numbers.vector, "four vertices, R frame; a triangle's last one twice")], \
        factor_fields(config)


def _draw(random, count, config):
    return {"vertices": r_patches(random, count, config.numbers)}


def _expect(given, config):
    return factor_arrays(plane_factor(given["vertices"], config.numbers))


BLOCK = Block(about="a patch", fields=_fields, draw=_draw, expect=_expect)

"""Two unit squares at distance 1 with a plate between them."""

from tb.golden.light.scenes import BLACK, rectangle, scene_of

__all__ = ["plates"]


def plates(width: float = 0.5):
    """The scene: floor, ceiling, and a two-sided plate over the part 0..``width`` of the floor, halfway up."""
    floor, ceiling = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))
    return scene_of(([floor, ceiling], BLACK), ([rectangle((0, 0, 0.5), (width, 0, 0), (0, 1, 0))], BLACK,
                                                {"two_sided": True}))

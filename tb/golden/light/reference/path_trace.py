"""Path-trace a built-in scene with Mitsuba: the reference of our rendered images.

``python -m tb.golden.light.reference.path_trace cornell`` writes ``cornell.npz`` beside this file: ``image``, 128 x 128
x 3 float16 radiance, and the settings it was made with. Needs ``pip install -e .[reference]``.
"""

from pathlib import Path

import click
import mitsuba
import numpy as np

from benchmarks.path_tracer import PathTracer
from golden.scene.builtin import builtin_scene

SIZE = 128
# Paths of a pixel in one run, which bounds memory.
RUN = 64


@click.command()
@click.argument("name")
@click.option("--samples", default=16384, show_default=True, help=f"Paths per pixel, a multiple of {RUN}.")
def main(name: str, samples: int) -> None:
    """Write the reference image of the built-in scene NAME."""
    tracer, runs = PathTracer(builtin_scene(name)), samples // RUN
    image = sum(tracer.trace(width=SIZE, height=SIZE, samples=RUN, seed=run)[0] / runs for run in range(runs))
    np.savez_compressed(Path(__file__).with_name(f"{name}.npz"), image=image.astype(np.float16), samples=runs * RUN,
                        mitsuba=mitsuba.__version__)


if __name__ == "__main__":
    main()

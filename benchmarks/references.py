"""Pictures of 20 scenes beside stored ones of a path tracer.

``radiosity bench references`` renders each scene with default settings, but 16 primary rays a pixel, and compares the
mean and the blocks of 16 x 16 pixels with the pictures in ``benchmarks/traced``, which ``--trace``
computes again with Mitsuba.
"""

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import click
import numpy as np

from benchmarks import reference_scenes
from benchmarks.furnished_rooms import ROOMS
from benchmarks.report import benchmark, provenance, table, write_report
from golden.base.output import whole_file
from golden.light.image import write_png
from golden.light.tone import tone_map
from golden.render.two_pass import RenderSettings, render
from radiosity.cli.console import console

__all__ = ["Reference", "block_sums", "compare"]

SCENES = reference_scenes.SCENES | ROOMS
WIDTH, HEIGHT, BLOCK = 96, 64, 16
# Paths of a pixel in one run of the path tracer, which bounds its memory, and least and most runs. More are added, in
# pairs, until no block that counts has more noise than this.
SAMPLES, RUNS, MOST_RUNS, NOISE = 256, 4, 64, 0.01
# A block is left out if bodies of glass throw more than this share of its light: such light is not computed, and it is
# the bias that a block may have.
THROWN = 0.05
FOLDER = Path(__file__).with_name("traced")


@dataclass(frozen=True, kw_only=True)
class Reference:
    """A traced picture.

    Parameters
    ----------
    image
        HEIGHT x WIDTH x 3 radiance.
    noise
        Rows x columns of blocks: the relative difference of the means of two halves of the paths from that of all.
    thrown
        The share of each block's light that bodies of glass throw onto surfaces.
    samples
        Paths of each pixel.
    """

    image: np.ndarray
    noise: np.ndarray
    thrown: np.ndarray
    samples: int

    @classmethod
    def stored(cls, name: str) -> "Reference":
        """The one of a scene that is in the tree."""
        with np.load(_path(name)) as file:
            return cls(image=file["image"].astype(np.float64), noise=file["noise"], thrown=file["thrown"],
                       samples=int(file["samples"]))

    @classmethod
    def traced(cls, name: str) -> "Reference":
        """Traced now."""
        from benchmarks.path_tracer import PathTracer

        scene = SCENES[name]
        tracer = PathTracer((scene.traced or scene.make)(), balls=scene.balls, origin=scene.origin, scale=scene.scale)
        halves, thrown = np.zeros((2, HEIGHT, WIDTH, 3)), np.zeros((HEIGHT, WIDTH, 3))
        for run in range(MOST_RUNS):
            light, part = tracer.trace(width=WIDTH, height=HEIGHT, samples=SAMPLES, seed=run)
            halves[run % 2] += light
            thrown += part
            image, runs = halves.sum(axis=0), run + 1
            whole = block_sums(image)
            noise = (np.abs(block_sums(halves[0] - halves[1])) / whole).max(axis=2)
            share = (block_sums(thrown) / whole).max(axis=2)
            if run % 2 and runs >= RUNS and noise[share <= THROWN].max() <= NOISE:
                break
        return cls(image=image / runs, noise=noise, thrown=share, samples=runs * SAMPLES)

    def store(self, name: str) -> None:
        """Write it into the tree."""
        FOLDER.mkdir(exist_ok=True)
        with whole_file(_path(name)) as part, part.open("wb") as file:
            np.savez_compressed(file, image=self.image.astype(np.float16), noise=self.noise.astype(np.float16),
                                thrown=self.thrown.astype(np.float16), samples=self.samples,
                                mitsuba=version("mitsuba"))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A rendered picture beside a reference.

    Parameters
    ----------
    mean
        Three: relative differences of the channels' means, over the blocks that count.
    blocks
        Rows x columns: the largest relative difference of a channel, NaN in a masked block.
    """

    mean: np.ndarray
    blocks: np.ndarray

    @property
    def masked(self) -> float:
        """The share of blocks that do not count."""
        return float(np.isnan(self.blocks).mean())

    @property
    def worst(self) -> float:
        """The difference of the worst block, with its sign."""
        return float(self.blocks.flat[np.nanargmax(np.abs(self.blocks))])


def block_sums(image: np.ndarray) -> np.ndarray:
    """Sums over blocks: rows x columns x 3."""
    height, width, _ = image.shape
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).sum(axis=(1, 3))


def compare(image: np.ndarray, reference: Reference) -> Comparison:
    """A picture beside its reference."""
    ours, theirs = block_sums(image), block_sums(reference.image)
    counts = reference.thrown <= THROWN
    difference = ours / theirs - 1
    worst = np.take_along_axis(difference, np.abs(difference).argmax(axis=2)[..., None], axis=2)[..., 0]
    return Comparison(mean=ours[counts].sum(axis=0) / theirs[counts].sum(axis=0) - 1,
                      blocks=np.where(counts, worst, np.nan))


def rendered(name: str) -> np.ndarray:
    """Our picture of a scene."""
    scene = SCENES[name].make()
    return render(scene, camera=scene.camera, settings=RenderSettings(width=WIDTH, height=HEIGHT, samples=16)).image


def _path(name):
    return FOLDER / f"{name.replace(',', '').replace(' ', '-')}.npz"


def _side_by_side(ours, theirs):
    """Both with one exposure, and between them where ours is too bright (red) or too dark (blue), 10 % at full."""
    exposure = 0.22 / max(float(np.exp(np.log(np.maximum(theirs.mean(axis=2), 1e-9)).mean())), 1e-9)
    share = np.clip((ours.mean(axis=2) / np.maximum(theirs.mean(axis=2), 1e-9) - 1) / 0.1, -1, 1)
    colour = np.stack([np.minimum(1 + share, 1), 1 - np.abs(share), np.minimum(1 - share, 1)], axis=2)
    pictures = [tone_map(ours, exposure=exposure), (255 * colour).astype(np.uint8), tone_map(theirs, exposure=exposure)]
    return np.repeat(np.repeat(np.concatenate(pictures, axis=1), 4, axis=0), 4, axis=1)


@benchmark("references", SCENES, only=True)
@click.option("--trace", is_flag=True, help="Trace the references again and store them in the tree (needs Mitsuba).")
@click.option("--pictures", type=click.Path(file_okay=False, path_type=Path),
              help="Write ours, the difference and the reference side by side as PNG files into this folder.")
def main(scenes: tuple[str, ...], trace: bool, pictures: Path | None) -> None:
    """Compare pictures with those of a path tracer; SCENES: all of them by default."""
    rows = []
    for name in scenes:
        if trace:
            Reference.traced(name).store(name)
        reference = Reference.stored(name)
        image = rendered(name)
        found = compare(image, reference)
        rows.append([name, *(f"{round(share, 3) + 0.0:+.1%}" for share in found.mean), f"{found.worst:+.1%}",
                     f"{np.nanmedian(np.abs(found.blocks)):.1%}", f"{np.median(reference.noise):.1%}",
                     f"{found.masked:.0%}"])
        console().note(" | ".join(rows[-1]))
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            write_png(pictures / f"{_path(name).stem}.png", _side_by_side(image, reference.image))
    write_report("Pictures beside those of a path tracer",
                 f"{provenance('numpy', 'numba')}; {WIDTH} x {HEIGHT} pixels, 16 primary rays each.",
                 table(["scene", "red", "green", "blue", "worst block", "median block", "noise", "masked"], rows))

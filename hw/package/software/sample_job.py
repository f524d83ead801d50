"""A small job with its results, for the simulation beside an exported engine."""

from golden.config import Config
from golden.errors import InputError
from golden.jobs.core_manifest import CoreManifest
from golden.tasks.image import ImageFrusta, job_files
from hw.memsys.cache_policy import CachePolicy

__all__ = ["SAMPLE", "sample_job"]

# Options of `radiosity image` that give the same job.
SAMPLE = "cornell --patch 4 --rays 32x8 --cell 0.5 --sums --expected"


def sample_job(config: Config, *, sha256: str) -> dict[str, bytes]:
    """The files of `radiosity image` with the options `SAMPLE`, by their names; none if the job does not fit.

    Parameters
    ----------
    config, sha256
        Configuration and Verilog of the engine, as its manifest has them.
    """
    core = CoreManifest(config=config, policy=CachePolicy[config.memsys.cache_policy.upper()].value, sha256=sha256)
    frusta = ImageFrusta(patches=(4,), rays=(32, 8))
    try:
        return job_files("cornell", frusta, core, cell=0.5, sums=True, expected=True).contents
    except InputError:
        return {}

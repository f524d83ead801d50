"""A small job with its results, for the simulation beside an exported engine."""

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.jobs.core_manifest import CoreManifest
from hw.memsys.bus.cache_policy import CachePolicy
from radiosity.flow.job_image import ImageFrusta, job_files

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

"""What a process computes with: two processes with equal proofs give the same bytes."""

import hashlib
from dataclasses import dataclass
from functools import cache
from socket import gethostname

import numpy as np

from golden.base.errors import InputError
from golden.base.library_versions import library_versions
from golden.base.source_digest import source_digest
from golden.cast.methods import RAY_METHODS
from golden.engine.cast.methods import frustum_caster
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.rows import FactorRows
from golden.scene.builtin import builtin_scene

__all__ = ["Proof"]


@dataclass(frozen=True, kw_only=True)
class Proof:
    """Which code computes, by a digest and by versions, and the hash of a known-answer test: a small piece of work.

    Processors with other vector instructions round sines and sums of products differently: the hash differs.

    Parameters
    ----------
    method
        The casting method of the work.
    sources
        The `source_digest` of this package.
    versions
        The `library_versions` of the method.
    canary
        SHA-256 of the test's results, as hexadecimal digits.
    """

    method: str
    sources: str
    versions: dict[str, str]
    canary: str

    @classmethod
    def of_this_process(cls, method: str) -> "Proof":
        """The proof of this process, which computes it once."""
        return cls(method=method, sources=source_digest(), versions=library_versions(method), canary=_canary(method))

    def check(self) -> None:
        """Compare with the process in which it is called, a worker.

        Raises
        ------
        InputError
            The sources, a version or the hash differs.
        """
        worker = f"worker on {gethostname()}"
        if source_digest() != self.sources:
            raise InputError(f"{worker}: it has other sources of this package; their digest must be "
                             f"{self.sources[:12]}, not {source_digest()[:12]}")
        for library, found in library_versions(self.method).items():
            if found != self.versions[library]:
                raise InputError(f"{worker}: {library} must be {self.versions[library]}, not {found}")
        canary = _canary(self.method)
        if canary != self.canary:
            raise InputError(f"{worker}: it computes other bits with the same packages; the hash of its test must be "
                             f"{self.canary[:12]}, not {canary[:12]}")


@cache
def _canary(method):
    """Rows of view factors by the method, elementary functions, and a product of matrices."""
    scene = builtin_scene("cornell")
    caster = frustum_caster(scene, method, jobs=1)
    casts_rays = method in RAY_METHODS
    rows = FactorRows(scene, caster, error=0.1) if casts_rays else HemisphereRows(scene, caster, rays=(16, 4))
    block = rows.rows(0, 2)
    numbers = np.linspace(0.001, 0.999, 999)
    values = [function(numbers) for function in (np.sin, np.cos, np.tan, np.arcsin, np.arctan, np.exp, np.log, np.sqrt)]
    square = np.sin(np.arange(64 * 64)).reshape(64, 64)
    whole = hashlib.sha256()
    for array in (*vars(block).values(), *values, np.arctan2(numbers, numbers[::-1]), square @ square):
        whole.update(np.ascontiguousarray(array).tobytes())
    return whole.hexdigest()

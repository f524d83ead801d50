"""Rays and hits as NumPy archives, for exchange with other programs."""

import zipfile
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.output import whole_file
from golden.cast.rays import Hits, Rays

__all__ = ["read_rays", "write_hits"]


def read_rays(path: Path) -> tuple[Rays, bool]:
    """The rays of an ``.npz`` file, and whether any hit suffices.

    The file holds ``origin`` and ``direction``, R x 3. With ``tmax`` (R) any hit nearer than that suffices; without it
    the nearest hit is sought. Other arrays are ignored.

    Raises
    ------
    InputError
        The file cannot be read, is no archive, lacks an array, or holds anything but real numbers of the right shape.
    """
    try:
        with path.open("rb") as file:  # np.load leaves a damaged archive open
            if not zipfile.is_zipfile(file):
                raise InputError("rays: not a .npz file")
            file.seek(0)
            arrays = _arrays(np.load(file, allow_pickle=False))
        return Rays(**arrays), "tmax" in arrays
    except OSError as error:
        raise InputError(f"{str(path)!r}: rays: cannot be read ({error.strerror or error})") from error
    except zipfile.BadZipFile as error:
        raise InputError(f"{str(path)!r}: rays: the file is damaged ({error})") from error
    except InputError as error:
        raise InputError(f"{str(path)!r}: {error}") from error
    except (ValueError, EOFError) as error:
        raise InputError(f"{str(path)!r}: rays: not an archive of numbers") from error


def _arrays(archive) -> dict[str, np.ndarray]:
    """The arrays of real numbers that rays consist of; InputError if they are not there."""
    arrays = {name: np.asarray(archive[name]) for name in ("origin", "direction", "tmax") if name in archive}
    for name in ("origin", "direction"):
        if name not in arrays:
            raise InputError(f"rays: there must be an array {name!r}, not only {archive.files!r}")
    for name, value in arrays.items():
        if value.dtype.kind not in "fiu":
            raise InputError(f"rays: {name.capitalize()} must hold real numbers, not {value.dtype}", parameter=name)
    return arrays


def write_hits(path: Path, hits: Hits) -> None:
    """Write ``patch`` (int32, -1 for none), ``t``, ``u`` and ``v`` (float64), R each, atomically."""
    with whole_file(path) as part:
        np.savez(part, patch=hits.patch, t=hits.t, u=hits.u, v=hits.v)

"""View factors between the patches of a scene, with their files, tables and what follows from them."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from golden.base.errors import InputError
from golden.base.output import check_outputs, whole_file
from golden.light.factors.exchange import Exchange, net_exchange, script_f
from golden.light.factors.factor_matrix import FactorMatrix
from golden.light.factors.groups import by_surface
from golden.light.factors.netcdf_file import read_netcdf, variables, write_netcdf
from golden.light.factors.npz_file import read_npz, write_npz

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ["ViewFactors"]

_READERS = {".npz": read_npz, ".nc": read_netcdf}


class ViewFactors(FactorMatrix):
    """View factors between N patches; what they are made of, and what they answer, is `FactorMatrix`'s.

    Raises
    ------
    InputError
        Shapes or patterns do not match, or a value is not finite or is negative.
    """

    def by_surface(self) -> "ViewFactors":
        """The factors between surfaces, see `golden.light.factors.groups.by_surface`."""
        return by_surface(self)

    @classmethod
    def open(cls, path) -> "ViewFactors":
        """The view factors of a .npz or .nc file that `to_npz`, `to_netcdf` or `write_view_factors` wrote.

        Raises
        ------
        InputError
            One line with the path and the fault.
        """
        path = Path(path)
        read = _READERS.get(path.suffix.lower())
        if read is None:
            raise InputError(f"{path}: Name must end in {' or '.join(_READERS)}, not {path.suffix!r}",
                             parameter="path")
        if not path.exists():
            raise InputError(f"{path}: no such file", parameter="path")
        try:
            return cls(**read(path))
        except InputError as error:
            raise InputError(f"{path}: {error}", parameter="path") from error
        except Exception as error:  # the libraries raise errors of any type for bad content
            raise InputError(f"{path}: it holds no view factors ({' '.join(str(error).split())})",
                             parameter="path") from error

    def exchange(self, *, temperature, emissivity, flux=None, sky_temperature: float = 0.0) -> Exchange:
        """Net radiative exchange, see `golden.light.factors.exchange.net_exchange`.

        Values are N numbers, one number, or a mapping from names of surfaces to numbers; a surface that is not named
        has no temperature or no flux.
        """
        return net_exchange(self, temperature=self._values("temperature", temperature),
                            emissivity=self._values("emissivity", emissivity),
                            flux=None if flux is None else self._values("flux", flux), sky_temperature=sky_temperature)

    def script_f(self, *, emissivity) -> np.ndarray:
        """Script-F between the surfaces in the order of their names, see `golden.light.factors.exchange.script_f`."""
        return script_f(self, emissivity=self._values("emissivity", emissivity),
                        group=np.unique(self.surface, return_inverse=True)[1])

    def _values(self, name, given):
        """N values of what is given for patches or for surfaces."""
        if not isinstance(given, Mapping):
            return np.full(len(self), given, dtype=np.float64) if np.ndim(given) == 0 else given
        unknown = sorted(set(given) - set(self.surface.tolist()))
        if unknown:
            raise InputError(f"view factors: {name.capitalize()} must be of surfaces that there are, not of "
                             f"{unknown[0]!r}", parameter=name)
        return np.array([given.get(surface, np.nan) for surface in self.surface.tolist()], dtype=np.float64)

    def to_dataframe(self, by: str = "surface") -> "pandas.DataFrame":
        """A table of all factors, from a row's to a column's, with the sky and black backs as last columns.

        Parameters
        ----------
        by
            ``surface``: between surfaces, see `by_surface`. ``patch``: between patches; N columns need N^2 numbers.
        """
        import pandas as pd

        if by not in ("surface", "patch"):
            raise InputError(f"view factors: By must be surface or patch, not {by!r}", parameter="by")
        factors = self.by_surface() if by == "surface" else self
        labels = pd.Index(factors.surface if by == "surface" else range(len(factors)), name=by)
        table = pd.DataFrame(factors.F.toarray(), index=labels, columns=labels)
        return table.assign(sky=factors.sky, back=factors.back)

    def to_xarray(self) -> "xarray.Dataset":
        """A Dataset with the variables of `to_netcdf`, the matrix as a list of entries."""
        import xarray as xr

        columns = {name: (dimensions, values, {"long_name": about} | ({} if units is None else {"units": units}))
                   for name, (dimensions, units, about, values) in variables(self).items()}
        return xr.Dataset(columns, coords={"surface_name": ("patch", self.surface)},
                          attrs={"settings": json.dumps(self.settings), "hidden_error": self.hidden_error})

    def to_npz(self, path) -> None:
        """Write a .npz, atomically; `scipy.sparse.load_npz` reads ``F``.

        InputError if the name ends otherwise or no file can be made there, OSError if it cannot be written.
        """
        check_outputs(Path(path), suffixes=(".npz",))
        with whole_file(Path(path)) as part:
            write_npz(self, part)

    def to_netcdf(self, path) -> None:
        """Write a .nc, atomically, with CF-style names and units; errors as of `to_npz`."""
        check_outputs(Path(path), suffixes=(".nc",))
        with whole_file(Path(path)) as part:
            write_netcdf(self, part)

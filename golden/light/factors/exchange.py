"""What follows from view factors: net radiative heat fluxes, and Hottel's script-F."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, gmres, splu

from golden.base.errors import InputError
from golden.base.plural import counted
from golden.light.factors.factor_matrix import CLOSED, FactorMatrix

__all__ = ["STEFAN_BOLTZMANN", "Exchange", "PatchError", "net_exchange", "script_f"]

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m2 K4)."""

# Radiosities are in balance if the residual is at most this share of the largest of them and of what patches emit by
# themselves: float64 reaches it however much larger the first are than the second, as behind polished metal.
_EXACT = 1e-13

# Share of a residual that one search leaves, the steps after which it starts anew, how often, and the searches.
_SEARCHED, _RESTART, _STEPS, _SEARCHES = 1e-7, 100, 3, 3

# Least share of the radiosities of a part of the scene that is absorbed or leaves at a reflection: rounding, 2^-52 of
# the radiosities, is then a small share of what decides them.
_LEAST_LOST = 1e-9

# Share of the largest radiation that meets in a patch's emission, by which that may be below zero and still be zero.
_NO_EMISSION = 1e-9

# Up to these float64 holds the squares of radiosities.
_HOTTEST, _MOST_FLUX = 1e25, 1e100


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Exchange:
    """Net radiative exchange of N patches, N float64 each.

    Parameters
    ----------
    temperature
        K; of patches with a given flux the one that follows.
    radiosity, irradiance
        W/m2 that leave and that arrive.
    flux
        W/m2, net: radiosity minus irradiance, positive where the patch loses heat.
    """

    temperature: np.ndarray
    radiosity: np.ndarray
    irradiance: np.ndarray
    flux: np.ndarray

    def __repr__(self) -> str:
        return (f"<Exchange: {counted(len(self.flux), 'patch')}, temperatures {self.temperature.min():g} to "
                f"{self.temperature.max():g} K, fluxes {self.flux.min():g} to {self.flux.max():g} W/m2>")


class PatchError(InputError):
    """A patch's values cannot be used.

    Parameters
    ----------
    patch
        Its number, from 0.
    fault
        What is wrong, without the patch.
    parameter
        The parameter of the value that is wrong, or None.
    """

    def __init__(self, patch: int, fault: str, *, parameter: str | None = None):
        super().__init__(f"exchange: patch {patch}: {fault}", parameter=parameter)
        self.patch, self.fault = patch, fault


def net_exchange(factors: FactorMatrix, *, temperature, emissivity, flux=None,
                 sky_temperature: float = 0.0) -> Exchange:
    """Net radiative exchange between grey, diffuse patches; each has a temperature or a net flux.

    Radiosity J = e s T^4 + (1 - e) H where the temperature T is given, J = q + H where the flux q is, irradiance
    H = F J + S s T_sky^4 with the sky view factor S (black backs count as sky) and the Stefan-Boltzmann constant s.

    Parameters
    ----------
    temperature
        N values in K, NaN where the flux is given.
    emissivity
        N values, 0 to 1; above 0 where the flux is given.
    flux
        N values in W/m2, NaN where the temperature is given. Default: given nowhere.
    sky_temperature
        K, of the sky as a black body.

    Raises
    ------
    PatchError
        A value of a patch is out of range; it has both or neither of temperature and flux; nothing sets its
        temperature, as all that it sees on any path has fluxes and none sees the sky; so little of the radiation around
        it is absorbed or leaves, below a share of 1e-9, that float64 does not resolve it; or it takes in more than
        arrives.
    InputError
        A value for all patches is out of range.
    """
    count = len(factors)
    temperature, emissivity = _values("Temperature", temperature, count), _emissivities(emissivity, count)
    flux = np.full(count, np.nan) if flux is None else _values("Flux", flux, count)
    given = ~np.isnan(temperature)
    _check_patches(given != ~np.isnan(flux), "it must have either a temperature or a flux")
    _check_patches(~given | ((temperature >= 0) & (temperature < np.inf)),
                   "Temperature must be finite and at least 0 K", temperature=temperature)
    _check_patches(~given | (temperature <= _HOTTEST), f"Temperature must be at most {_HOTTEST:.0e} K",
                   temperature=temperature)
    _check_patches(given | np.isfinite(flux), "Flux must be finite", flux=flux)
    _check_patches(given | (np.abs(flux) <= _MOST_FLUX), f"Flux must be at most {_MOST_FLUX:.0e} W/m2", flux=flux)
    _check_patches(given | (emissivity > 0), "Emissivity must be above 0 where the flux is given",
                   emissivity=emissivity)
    if not 0 <= sky_temperature < np.inf:
        raise InputError(f"exchange: Sky temperature must be finite and at least 0 K, not {sky_temperature!r}",
                         parameter="sky_temperature")
    if sky_temperature > _HOTTEST:
        raise InputError(f"exchange: Sky temperature must be at most {_HOTTEST:.0e} K, not {sky_temperature!r}",
                         parameter="sky_temperature")
    anchors = (given & (emissivity > 0)) | (factors.sky + factors.back > CLOSED)
    parts, part = connected_components(factors.F, directed=False)
    _check_patches(given | (np.bincount(part, anchors, parts) > 0)[part], "nothing sets its temperature: all that it "
                   "sees has a flux, and none sees the sky")
    reflected = np.where(given, 1 - emissivity, 1.0)
    _check_resolved(factors, np.where(given, emissivity, 0.0))
    own = np.where(given, emissivity * STEFAN_BOLTZMANN * np.nan_to_num(temperature)**4, np.nan_to_num(flux))
    outside = (factors.sky + factors.back) * STEFAN_BOLTZMANN * sky_temperature**4
    radiosity = _radiosity(factors.F, reflected, own + reflected * outside)
    irradiance = factors.F @ radiosity + outside
    net = np.where(given, emissivity * (STEFAN_BOLTZMANN * np.nan_to_num(temperature)**4 - irradiance), flux)
    reflection = np.divide((1 - emissivity) * net, emissivity, out=np.zeros(count), where=emissivity > 0)
    black = radiosity + reflection
    terms = np.maximum(np.abs(reflection), max(np.abs(radiosity).max(), irradiance.max()))
    _check_patches(given | (black >= -_NO_EMISSION * terms), "it cannot take in more than arrives: Flux is too low",
                   flux=flux)
    found = np.maximum(black / STEFAN_BOLTZMANN, 0)**0.25
    return Exchange(temperature=np.where(given, temperature, found), radiosity=radiosity, irradiance=irradiance,
                    flux=net)


def script_f(factors: FactorMatrix, *, emissivity, group) -> np.ndarray:
    """Script-F between groups of grey, diffuse patches, G x G float64.

    Of the radiation that a black group I would emit, the share script-F[I, J] is absorbed by J on any path: the net
    exchange of two is A_I script-F[I, J] s (T_I^4 - T_J^4). A row sums to the group's emissivity minus what leaves for
    the sky.

    Source: Hottel, Sarofim, Radiative Transfer, 1967.

    Parameters
    ----------
    emissivity
        N values, 0 to 1.
    group
        N int: number of each patch's group, 0 to G - 1, none without a patch.

    Raises
    ------
    PatchError
        An emissivity is out of range, or float64 does not resolve the radiation around the patch (see `net_exchange`).
    """
    count = len(factors)
    emissivity, group = _emissivities(emissivity, count), np.asarray(group)
    _check_resolved(factors, emissivity)
    exchange = np.zeros((group.max() + 1,) * 2)
    for column in range(len(exchange)):
        # What each patch absorbs of the radiation that one group emits.
        arriving = factors.F @ _radiosity(factors.F, 1 - emissivity, np.where(group == column, emissivity, 0.0))
        exchange[:, column] = np.bincount(group, factors.area * emissivity * arriving)
    return exchange / np.bincount(group, factors.area)[:, None]


def _radiosity(matrix: sparse.csr_array, reflected: np.ndarray, own: np.ndarray) -> np.ndarray:
    """The solution of J = own + reflected F J."""
    radiosity = own.copy()
    if not own.any() or not reflected.any():
        return radiosity
    searches = iter((*[_searched] * _SEARCHES, _eliminated, _eliminated))
    while True:
        residual = own - radiosity + reflected * (matrix @ radiosity)
        if np.abs(residual).max() <= _EXACT * (np.abs(radiosity).max() + np.abs(own).max()):
            return radiosity
        search = next(searches, None)
        if search is None:
            raise InputError("exchange: float64 does not resolve the radiosities")
        radiosity += search(matrix, reflected, residual)


def _searched(matrix, reflected, own):
    """Nearly the solution of J = own + reflected F J, by products with F alone."""
    system = LinearOperator(matrix.shape, lambda radiosity: radiosity - reflected * (matrix @ radiosity), dtype=float)
    return gmres(system, own, rtol=_SEARCHED, atol=0.0, restart=min(len(own), _RESTART), maxiter=_STEPS)[0]


def _eliminated(matrix, reflected, own):
    """The same by elimination, where light is reflected so often that a search does not end."""
    parts, part = connected_components(matrix, directed=False)
    # Where no light is, mirrors all around would make the system singular.
    rows = np.flatnonzero((np.bincount(part, own != 0, parts) > 0)[part])
    system = sparse.eye_array(len(rows)) - sparse.diags_array(reflected[rows]) @ matrix[rows][:, rows]
    found = np.zeros(len(own))
    found[rows] = splu(sparse.csc_array(system)).solve(own[rows])
    return found


def _check_resolved(factors, absorbed):
    """Enough of the radiation in each part of the scene is absorbed, of which the shares are given, or leaves."""
    parts, part = connected_components(factors.F, directed=False)
    leaves = factors.sky + factors.back
    absorbed = absorbed + np.where(leaves > CLOSED, leaves, 0.0)
    lost, area = (np.bincount(part, factors.area * weight, parts)[part] for weight in (absorbed, 1.0))
    _check_patches((lost == 0) | (lost >= _LEAST_LOST * area), f"less than {_LEAST_LOST:g} of the radiation around it "
                   "is absorbed or leaves, which float64 does not resolve: emissivities are too low")


def _values(name, given, count):
    values = np.asarray(given, dtype=np.float64)
    if values.shape != (count,):
        raise InputError(f"exchange: {name} must be one value for each of {count} patches, not {values.shape!r}",
                         parameter=name.lower())
    return values


def _emissivities(given, count):
    values = _values("Emissivity", given, count)
    _check_patches((values >= 0) & (values <= 1), "Emissivity must be 0 to 1", emissivity=values)
    return values


def _check_patches(right, what, **values):
    """Refuse the first patch that is not right, with its value of a parameter, which is given by name."""
    wrong = np.flatnonzero(~right)
    if not len(wrong):
        return
    patch = int(wrong[0])
    if not values:
        raise PatchError(patch, what)
    (name, given), = values.items()
    raise PatchError(patch, f"{what}, not {given[patch]:g}", parameter=name)

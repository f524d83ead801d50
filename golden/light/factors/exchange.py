"""What follows from view factors: net radiative heat fluxes, and Hottel's script-F."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, gmres

from golden.errors import InputError
from golden.light.factors.view_factors import ViewFactors

__all__ = ["STEFAN_BOLTZMANN", "Exchange", "net_exchange", "script_f"]

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m2 K4)."""

# Residual, relative to the emitted flux, at which the search for radiosities ends, and its most steps.
_EXACT, _STEPS = 1e-13, 20

# Up to these float64 holds the squares of radiosities.
_HOTTEST, _MOST_FLUX = 1e25, 1e100


@dataclass(frozen=True, kw_only=True, eq=False)
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


def net_exchange(factors: ViewFactors, *, temperature, emissivity, flux=None, sky_temperature: float = 0.0) -> Exchange:
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
    InputError
        A value is out of range, a patch has both or neither of temperature and flux, or all have a flux and none sees
        the sky.
    """
    count = len(factors)
    temperature, emissivity = _values("Temperature", temperature, count), _emissivities(emissivity, count)
    flux = np.full(count, np.nan) if flux is None else _values("Flux", flux, count)
    given = ~np.isnan(temperature)
    wrong = np.flatnonzero(given == ~np.isnan(flux))
    if len(wrong):
        raise InputError(f"exchange: patch {wrong[0]} must have either a temperature or a flux")
    if not np.isfinite(temperature[given]).all() or temperature[given].min(initial=0) < 0:
        raise InputError("exchange: Temperature must be finite and at least 0 K")
    if not np.isfinite(flux[~given]).all():
        raise InputError("exchange: Flux must be finite")
    if not 0 <= sky_temperature < np.inf:
        raise InputError(f"exchange: Sky temperature must be finite and at least 0 K, not {sky_temperature!r}")
    if (emissivity[~given] == 0).any():
        raise InputError("exchange: Emissivity must be above 0 where the flux is given")
    if not given.any() and not (factors.sky + factors.back).any():
        raise InputError("exchange: At least one patch must have a temperature or see the sky")
    reflected = np.where(given, 1 - emissivity, 1.0)
    if max(temperature[given].max(initial=0), sky_temperature) > _HOTTEST:
        raise InputError(f"exchange: Temperature must be at most {_HOTTEST:.0e} K")
    if np.abs(flux[~given]).max(initial=0) > _MOST_FLUX:
        raise InputError(f"exchange: Flux must be at most {_MOST_FLUX:.0e} W/m2")
    own = np.where(given, emissivity * STEFAN_BOLTZMANN * np.nan_to_num(temperature)**4, np.nan_to_num(flux))
    outside = (factors.sky + factors.back) * STEFAN_BOLTZMANN * sky_temperature**4
    radiosity = _radiosity(factors.F, reflected, own + reflected * outside)
    irradiance = factors.F @ radiosity + outside
    net = np.where(given, emissivity * (STEFAN_BOLTZMANN * np.nan_to_num(temperature)**4 - irradiance), flux)
    black = radiosity + np.divide((1 - emissivity) * net, emissivity, out=np.zeros(count), where=emissivity > 0)
    found = np.maximum(black / STEFAN_BOLTZMANN, 0)**0.25
    return Exchange(temperature=np.where(given, temperature, found), radiosity=radiosity, irradiance=irradiance,
                    flux=net)


def script_f(factors: ViewFactors, *, emissivity, group) -> np.ndarray:
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
    InputError
        An emissivity is out of range.
    """
    count = len(factors)
    emissivity, group = _emissivities(emissivity, count), np.asarray(group)
    exchange = np.zeros((group.max() + 1,) * 2)
    for column in range(len(exchange)):
        # What each patch absorbs of the radiation that one group emits.
        arriving = factors.F @ _radiosity(factors.F, 1 - emissivity, np.where(group == column, emissivity, 0.0))
        exchange[:, column] = np.bincount(group, factors.area * emissivity * arriving)
    return exchange / np.bincount(group, factors.area)[:, None]


def _radiosity(matrix: sparse.csr_array, reflected: np.ndarray, own: np.ndarray) -> np.ndarray:
    """The solution of J = own + reflected F J."""
    if not own.any() or not reflected.any():
        return own.copy()
    system = LinearOperator(matrix.shape, lambda radiosity: radiosity - reflected * (matrix @ radiosity), dtype=float)
    found, failed = gmres(system, own, rtol=_EXACT, atol=0.0, restart=min(len(own), 100), maxiter=_STEPS)
    if failed:
        raise InputError("exchange: no radiosities are in balance: fluxes into a closed scene must sum to zero")
    return found


def _values(name, given, count):
    values = np.asarray(given, dtype=np.float64)
    if values.shape != (count,):
        raise InputError(f"exchange: {name} must be one value for each of {count} patches, not {values.shape!r}")
    return values


def _emissivities(given, count):
    values = _values("Emissivity", given, count)
    if not ((values >= 0) & (values <= 1)).all():
        raise InputError("exchange: Emissivity must be 0 to 1")
    return values

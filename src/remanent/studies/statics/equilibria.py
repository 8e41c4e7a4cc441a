"""Equilibria under a constant magnetic load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._status import Status
from remanent._typing import FloatArray, IntArray
from remanent.analysis.equilibria import slope, zeros
from remanent.integrate.variations import transverse_field
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import Constant
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.ensemble import Ensemble, Over, ensemble
from remanent.studies.ensemble.two_coordinates import two_coordinates
from remanent.studies.statics._biaxial import in_plane
from remanent.studies.statics._folds import folds
from remanent.studies.statics._static_ensemble import AtRest

#: Thickness stretches at which the potential is tabulated, around equilibria and rest.
_POINTS = 401


def equilibria(actuator: Actuator, m: float = 0.0, *, over: Over | None = None) -> xr.Dataset:
    """Find every equilibrium under the constant load `m`, with its stability.

    Parameters
    ----------
    actuator
        The actuator.  Branches are relaxed, temperature is that of the surroundings.
    m
        Magnetic load, dimensionless.
    over
        Values of numeric fields (``m`` among them); they become dimensions.  Along the
        first of them, between its least and largest value, folds are located.

    Returns
    -------
    xarray.Dataset
        Along ``equilibrium``, in order of the in-plane stretch, NaN where there are
        fewer: ``equilibrium_stretch`` (thickness stretch), ``stretch``,
        ``equilibrium_potential``, ``natural_frequency`` (radians per unit of tau, NaN
        where unstable) and ``stability`` (``stable``, ``unstable`` or empty), within
        equal stretches; ``transverse_stiffness``, ω_a² of λ₁ − λ₂, negative where the
        stretches do not stay equal.
        ``potential`` against ``thickness_stretch`` is the potential energy per
        reference volume over mu, ``level`` that of rest, whose motion runs between
        ``turning_lower`` and ``turning_upper``.  With `over`, along ``fold``, the values
        of its first field at which two equilibria meet, ``fold_m`` for example, and the
        ``fold_stretch`` and ``fold_thickness_stretch`` there.  With two coordinates:
        ``stretch_1``, ``stretch_2``, ordered by the first, and ``natural_frequency`` along
        ``mode`` too; no folds and no table of the potential.

    Notes
    -----
    Sign changes of the force on 4001 stretches from 0.05 to 20, or between the limits of the
    material where these are nearer, refined to round-off;
    the natural frequency is √(−∂λ''/∂λ) at rest, by a complex step.  Without dissipation
    ω_a² of a neo-Hookean solid is 3[θ(1 + λ⁻⁶) − mλ⁻⁴].  At a fold the parameter
    that balances the force, as a function of the stretch, has an extremum: a sign change of
    ∂f/∂λ along it.  One value of the parameter is found for each stretch, which is all there
    is for loads, prestress and temperature, in which the force is linear.  With two
    coordinates Newton's method starts where both forces change sign between neighbouring
    pairs of stretches, in 96 directions from rest and at 96 distances up to stretches of 0.001
    and 1000 or the limit of the material: what is missed are pairs that are about to merge.

    Examples
    --------
    >>> import remanent as rm
    >>> rm.equilibria(rm.Actuator(), 0.16).equilibrium_stretch.values.round(4).tolist()
    [1.0563]
    >>> curve = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": np.linspace(1, 4, 31)})
    >>> curve.fold_m.values.round(4).tolist()
    [2.1777, 2.8483]
    """
    ens = ensemble(actuator, Constant(m), over)
    if actuator.coordinates == 2:
        return in_plane(ens)
    at_rest = AtRest(ens)
    found = zeros(at_rest.force, ens.count, at_rest.grid)
    found[ens.invalid] = np.nan
    case = np.repeat(np.arange(ens.count), found.shape[1]).reshape(found.shape)
    stiffness = -slope(at_rest.force, case, found)
    stability = np.where(stiffness > 0, "stable", np.where(stiffness <= 0, "unstable", ""))
    dims = (*ens.dims, "equilibrium")
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(np.where(stiffness > 0, stiffness, np.nan))
    along: dict[str, FloatArray] = {
        "equilibrium_stretch": at_rest.thickness(case, found),
        "stretch": found,
        "equilibrium_potential": at_rest.potential(case, found),
        "natural_frequency": frequency,
        "stability": stability,
        "transverse_stiffness": _transverse_stiffness(ens, case, found),
    }
    variables: dict[str, Labelled] = {k: (dims, ens.shaped(v)) for k, v in along.items()}
    status = np.where(ens.invalid, Status.INVALID, Status.OK).astype(np.int8)
    variables["status"] = (ens.dims, ens.shaped(status))
    variables |= folds(at_rest)
    variables |= _landscape(ens, at_rest, along["equilibrium_stretch"])
    thickness = variables.pop("thickness_stretch")
    coords: dict[str, Labelled] = {
        **ens.coords,
        **({"fold": variables.pop("fold")} if "fold" in variables else {}),
        "equilibrium": (("equilibrium",), np.arange(found.shape[1])),
        "thickness_stretch": thickness,
    }
    attributes = provenance.attributes(actuator, Constant(m), None, over=ens.coords)
    return build.dataset(variables, coords, attributes)


def _transverse_stiffness(ens: Ensemble, case: IntArray, stretch: FloatArray) -> FloatArray:
    """omega_a^2 of a small difference of the in-plane stretches at rest."""
    both, pairs = two_coordinates(ens)
    at_rest = AtRest(replace(both, field=transverse_field(both.field, pairs)))
    rates = at_rest.run(at_rest.ens.field.rates, case, stretch)
    return np.asarray(-rates[at_rest.ens.field.state.index("transverse.stretch_1_rate")])


def _landscape(ens: Ensemble, at_rest: AtRest, found: FloatArray) -> dict[str, Labelled]:
    """The potential on a common grid that holds rest, equilibria and turning points."""
    seen = np.concatenate([found[np.isfinite(found)], [1.0]])
    low, high = seen.min(), seen.max()
    room = 0.75 * (high - low) + 0.1
    grid = np.linspace(max(0.05, low - room), high + room, _POINTS)
    case = np.repeat(np.arange(ens.count), _POINTS)
    potential = at_rest.potential(case, np.tile(grid**-0.5, ens.count))
    potential = potential.reshape(ens.count, _POINTS)
    level = at_rest.potential(np.arange(ens.count), np.ones(ens.count))
    with np.errstate(all="ignore"):  # of loads near the largest number
        lower, upper = np.sort(_turning_points(ens, at_rest, level), axis=0)
    return {
        "thickness_stretch": (("thickness_stretch",), grid),
        "potential": ((*ens.dims, "thickness_stretch"), ens.shaped(potential)),
        "level": (ens.dims, ens.shaped(level)),
        "turning_lower": (ens.dims, ens.shaped(lower)),
        "turning_upper": (ens.dims, ens.shaped(upper)),
    }


def _turning_points(ens: Ensemble, at_rest: AtRest, level: FloatArray) -> FloatArray:
    """Thickness stretches (2, trajectory) between which the motion from rest runs."""
    case = np.arange(ens.count)
    rest = np.ones(ens.count)
    crossings = zeros(
        lambda i, x: at_rest.potential(i, x) - level[i], ens.count, at_rest.grid * (1.0 - 1e-9)
    )
    push = np.sign(at_rest.force(case, rest))[:, None]
    ahead = np.where((crossings - 1.0) * push > 1e-8, np.abs(crossings - 1.0), np.inf)
    nearest = ahead.min(axis=1, initial=np.inf)
    away = np.where(np.isfinite(nearest), nearest, np.nan) * push[:, 0]
    other = np.where(push[:, 0] == 0.0, 1.0, 1.0 + away)
    return np.stack([at_rest.thickness(case, rest), at_rest.thickness(case, other)])

"""The one place where results of an ensemble get status, error, labels and attributes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._status import Status
from remanent.integrate.ensemble.problem import Outcome
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.invalid import reasons_of_invalid

#: An array (trajectory, ...) with the names of its later dimensions; none if it is bare.
PerTrajectoryArray = NDArray[Any] | tuple[tuple[str, ...], NDArray[Any]]


def to_dataset(
    ens: Ensemble,
    variables: Mapping[str, PerTrajectoryArray],
    *,
    tolerance: float | None,
    coords: Mapping[str, Labelled] | None = None,
    shared: Mapping[str, Labelled] | None = None,
    outcome: Outcome | None = None,
    error: str = "error",
    status: NDArray[Any] | None = None,
    driven: bool = True,
    **settings: Any,
) -> xr.Dataset:
    """Label the results of an ensemble: the dimensions of ``over`` first, then their own.

    Parameters
    ----------
    ens : Ensemble
        What was computed; the results have its dimensions, coordinates and attributes.
    variables : mapping of name to array (trajectory, ...)
        With the names of the later dimensions, ``(("time",), array)``, where there are any.
    tolerance : float or None
        What was asked for; None where nothing was integrated.
    coords : mapping of name to Labelled, optional
        Coordinates beside those of `ens`, which all trajectories share.
    shared : mapping of name to Labelled, optional
        Variables that do not have the dimensions of `ens`, or only some of them.
    outcome : Outcome, optional
        Of the integration: its ``error``, ``horizon`` and ``status`` become variables.
    error : str
        Name of the variable that takes the error of `outcome`.
    status : array (trajectory,) of int, optional
        Where there is no `outcome`; by default ``ok``, or ``invalid`` where a value breaks
        a rule.
    driven : bool
        False where the load is what the result is about: then no drive made it.
    **settings
        What else decides the numbers, for the attributes.

    Returns
    -------
    xarray.Dataset
        Where values of ``over`` break a rule, ``reason`` says which.
    """
    evidence: dict[str, PerTrajectoryArray] = {}
    if outcome is not None:
        evidence = {error: outcome.error, "horizon": outcome.horizon, "status": outcome.status}
    elif status is not None:
        evidence = {"status": status}
    elif "status" not in variables:
        evidence = {"status": np.where(ens.is_invalid, Status.INVALID, Status.OK)}
    if ens.is_invalid.any() and "reason" not in (shared or {}):
        evidence["reason"] = _with_reasons_of_invalid(ens, variables.get("reason"))
    labelled = {
        name: _label_for_ensemble(ens, values) for name, values in {**variables, **evidence}.items()
    }
    drive = ens.drive if driven else None
    attributes = provenance.attributes(ens.system, drive, tolerance, over=ens.coords, **settings)
    observable = ens.vector_field.observable_name
    if observable != provenance.ACTUATOR_OBSERVABLE:
        attributes[provenance.OBSERVABLE_ATTRIBUTE] = observable
    result = build.dataset(
        {**labelled, **(shared or {})},
        {**ens.coords, **(coords or {})},
        attributes,
        ens.system.variable_texts(),
    )
    return build.with_labels(result, ens.labels)


def _with_reasons_of_invalid(ens: Ensemble, given: PerTrajectoryArray | None) -> PerTrajectoryArray:
    """The reasons that a verb gave, and why nothing is computed where a value breaks a rule."""
    if isinstance(given, tuple):  # along dimensions of their own
        return given
    reasons = reasons_of_invalid(ens)
    return reasons if given is None else np.where(given == "", reasons, given)


def _label_for_ensemble(ens: Ensemble, values: PerTrajectoryArray) -> Labelled:
    dims, array = values if isinstance(values, tuple) else ((), values)
    return (*ens.dims, *dims), ens.reshape_to_dims(array)

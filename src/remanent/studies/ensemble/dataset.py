"""What every Dataset of an ensemble carries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from remanent.integrate.ensemble.problem import Outcome
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.ensemble import Ensemble


def label(
    ens: Ensemble,
    outcome: Outcome,
    variables: Mapping[str, Labelled],
    coords: Mapping[str, Labelled],
    tolerance: float,
    **settings: Any,
) -> xr.Dataset:
    """Variables with their error, horizon and status, labelled and attributed."""
    evidence: dict[str, Labelled] = {
        "error": (ens.dims, ens.shaped(outcome.error)),
        "horizon": (ens.dims, ens.shaped(outcome.horizon)),
        "status": (ens.dims, ens.shaped(outcome.status)),
    }
    attributes = provenance.attributes(
        ens.actuator,
        ens.drive,
        tolerance,
        over=ens.coords,
        **settings,
    )
    return build.dataset({**variables, **evidence}, {**ens.coords, **coords}, attributes)

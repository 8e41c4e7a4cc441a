"""The parameters that a fit found, with their covariance."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray

#: What a fit has of its parameters.
_NEEDED_VARIABLES = ("parameter", "estimate", "covariance")


@dataclass(frozen=True)
class FittedParameters:
    """Estimates of parameters and the covariance of their errors.

    Attributes
    ----------
    names : list of str
    estimate : array (parameter,)
    covariance : array (parameter, parameter)
    """

    names: list[str]
    estimate: FloatArray
    covariance: FloatArray

    @classmethod
    def from_fit(cls, fit: object, reserved: Collection[str]) -> Self:
        """Those of a result of :func:`remanent.fit`; none where there is no fit.

        Parameters
        ----------
        fit : xarray.Dataset or None
            What was passed for the argument ``fit``.
        reserved : collection of str
            Names that must not be among them.
        """
        if fit is None:
            return cls([], np.empty(0), np.empty((0, 0)))
        needed = set(_NEEDED_VARIABLES)
        if not isinstance(fit, xr.Dataset) or not needed <= set(map(str, fit.variables)):
            raise _fit_error("be a result of rm.fit", shortened_repr(fit))
        if "scales_applied" in fit.attrs:
            raise _fit_error("be dimensionless, as rm.fit returned it", "a fit in SI")
        names = [str(name) for name in fit["parameter"].values]
        if twice := sorted(set(names) & set(reserved)):
            raise _fit_error("name no field of `parameter_ranges` again", ", ".join(twice))
        covariance = fit["covariance"].transpose("parameter", "other_parameter").values
        return cls(names, np.asarray(fit["estimate"].values), np.asarray(covariance))


def _fit_error(must: str, got: str) -> InputError:
    return InputError(
        "fit",
        must=must,
        got=got,
        why="Its estimates and their covariance say what is uncertain.",
        fix="Pass what rm.fit(...) returned.",
    )

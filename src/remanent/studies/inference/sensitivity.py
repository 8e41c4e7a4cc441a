"""How a measure depends on numeric fields."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import Rule, require_real
from remanent._status import Status
from remanent._typing import FloatArray
from remanent.analysis.inference.differences import richardson_derivative, richardson_offsets
from remanent.results import build
from remanent.results.build import Labelled
from remanent.studies.inference._measures import (
    MeasureLayout,
    as_measure,
    as_parameter_values,
    measure_provenance,
)
from remanent.studies.inference.measure import Measure, OfArgument

_LARGEST_RELATIVE_STEP_RULE = Rule(
    "lie between 1e-9 and 1",
    lambda x: np.asarray((x >= 1e-9) & (x < 1)),
    "It is the largest relative change of a field, which must not change its sign and must be "
    "seen above rounding.",
    "Pass for example 0.02.",
)
#: Change of a field, over its size, by which the error of a measure becomes another.
_ERROR_SCALE = 0.7
#: Why a derivative is not known.
_UNKNOWN_DERIVATIVE_REASON = (
    "Where the status is incomplete, the measure is not known at some of the changed values of "
    "the field: they break a rule, or the verb has no value there."
)
#: Why an error is not known.
_UNKNOWN_ERROR_REASON = (
    "The measure states no error of its own, so that the errors are not known; derivatives are "
    "extrapolated as if its numbers were exact."
)
#: Differences of each field, each half as wide as the last.
_EXTRAPOLATION_LEVELS = 6


def sensitivity(
    measure: Measure | Callable[..., Any],
    *arguments: Any,
    parameters: str | Sequence[str],
    of: OfArgument | None = None,
    step: float = 0.02,
    **options: Any,
) -> xr.Dataset:
    """Derivatives of what a verb computes by numeric fields.

    Parameters
    ----------
    measure : Measure or callable
        A :class:`remanent.Measure`, or a verb, followed by its arguments and options.
    *arguments : Any
        Of the verb, where `measure` is one.
    parameters : str or sequence of str
        Fields of the actuator or the drive, ``initial.stretch`` ...; ``shear_modulus``,
        ``density``, ``remanence`` where the verb knows them.
    of : str or callable, optional
        The variable of the verb's result, or a function of that result.
    step : float
        Largest change of a field, relative to its value, or absolute where that is 0.  Six
        differences are formed, each half as wide as the last.
    **options : Any
        Of the verb, by name.

    Returns
    -------
    xarray.Dataset
        Along ``field``, and the dimensions of the measure: ``value``, ``value_error``;
        ``derivative`` with ``derivative_error``; ``elasticity``, the relative change of the
        measure over that of the field, with ``elasticity_error``; ``status``, ``incomplete``
        where a derivative is not known.  Errors are NaN where the measure states none of its
        own; the attribute ``reason`` says so.

    Raises
    ------
    InputError
        A bad argument.

    See Also
    --------
    remanent.uncertainty : What ranges of fields make of a measure.
    remanent.design : Fields with which a measure takes a given value.

    Notes
    -----
    All runs are one ensemble.  Richardson's extrapolation of central differences; the error
    is the disagreement within its table, with what the scatter of the values makes of it, and
    the slope that the errors of the verb can have.  Where a
    measure jumps or has a corner within the step, the error is as large as the derivative.  A
    field whose change breaks its rule (a viscosity of 0) has NaN and the status ``incomplete``.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.sensitivity(
    ...     rm.shape_commands, rm.Actuator(), 1.5, of="switch_time", parameters=["temperature", "c"]
    ... )
    >>> [round(x, 6) for x in ds.elasticity.values.tolist()]
    [-0.5, 0.390917]
    """
    measure = as_measure(measure, arguments, of, **options)
    step = require_real("step", step, _LARGEST_RELATIVE_STEP_RULE)
    centre = as_parameter_values(parameters, measure.nominal_values())
    differences = _DifferenceStencil.centred_at(np.array(list(centre.values())), step)
    values, errors = measure.at(dict(zip(centre, differences.points.T, strict=True)))
    layout = MeasureLayout.from_values(values)
    flat, noise = (
        array.values.reshape(len(values), -1).astype(float) for array in (values, errors)
    )
    slope, slope_error = differences.derivatives(flat, noise)
    value, value_error = flat[0], noise[0]
    lost = ~np.isfinite(slope)
    reasons = [
        *([_UNKNOWN_DERIVATIVE_REASON] if lost.any() else []),
        *([_UNKNOWN_ERROR_REASON] if (np.isnan(noise) & np.isfinite(flat)).any() else []),
    ]
    with np.errstate(all="ignore"):
        ratio = differences.centre[:, None] / value
        relative_error = slope_error + np.abs(slope) * value_error / np.abs(value)
    variables: dict[str, Labelled] = {
        "value": layout.label_numbers(value),
        "value_error": layout.label_numbers(value_error),
        "derivative": layout.label_numbers(slope, "field"),
        "derivative_error": layout.label_numbers(slope_error, "field"),
        "elasticity": layout.label_numbers(slope * ratio, "field"),
        "elasticity_error": layout.label_numbers(np.abs(ratio) * relative_error, "field"),
        "status": layout.label_numbers(np.where(lost, Status.INCOMPLETE, Status.OK), "field"),
    }
    coords: dict[str, Labelled] = {"field": (("field",), np.array(list(centre))), **layout.coords}
    attributes = measure_provenance([measure], step=step)
    if reasons:
        attributes["reason"] = " ".join(reasons)
    return build.dataset(variables, coords, attributes)


@dataclass(frozen=True)
class _DifferenceStencil:
    """Points about a centre from which derivatives by each parameter are extrapolated.

    Attributes
    ----------
    centre, largest_parameter_steps : array (parameter,)
        The largest change of each parameter.
    points : array (point, parameter)
        The centre first, then the points of each parameter in turn.
    """

    centre: FloatArray
    largest_parameter_steps: FloatArray
    points: FloatArray

    @classmethod
    def centred_at(cls, centre: FloatArray, step: float) -> _DifferenceStencil:
        """Differences whose largest is `step`, relative where the centre is not 0."""
        widths = step * np.where(centre == 0.0, 1.0, np.abs(centre))
        changes = np.concatenate(
            [richardson_offsets(width, _EXTRAPOLATION_LEVELS) for width in widths]
        )
        points = np.repeat(centre[None], 1 + changes.size, axis=0)
        changed = np.repeat(np.arange(centre.size), 2 * _EXTRAPOLATION_LEVELS)
        points[np.arange(1, changes.size + 1), changed] += changes
        return cls(centre, widths, points)

    @property
    def parameter_scales(self) -> FloatArray:
        """Sizes of the parameters, over which errors of a measure become others."""
        size = np.where(self.centre == 0.0, 1.0, np.abs(self.centre))
        return np.asarray(_ERROR_SCALE * size)

    def derivatives(self, values: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives and their errors, arrays (parameter, number).

        Parameters
        ----------
        values, noise : array (point, number)
            The measure and its errors; where one is not known, derivatives have none either.
        """
        counted = np.nan_to_num(noise)
        rows = [
            slice(1 + 2 * _EXTRAPOLATION_LEVELS * k, 1 + 2 * _EXTRAPOLATION_LEVELS * (k + 1))
            for k in range(len(self.largest_parameter_steps))
        ]
        tables = [
            richardson_derivative(values[block], counted[block], width, scale)
            for block, width, scale in zip(
                rows, self.largest_parameter_steps, self.parameter_scales, strict=True
            )
        ]
        slopes, errors = (np.array(part) for part in zip(*tables, strict=True))
        unknown = np.array([np.isnan(noise[block]).any(axis=0) for block in rows])
        return slopes, np.where(unknown, np.nan, errors)

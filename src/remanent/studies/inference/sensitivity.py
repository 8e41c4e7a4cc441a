"""How a measure depends on numeric fields."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import positive, require_real
from remanent._typing import FloatArray
from remanent.analysis.differences import offsets, richardson
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.inference.measure import SAMPLE, Measure, Of, as_measure, chosen, listed

_STEP = positive("It is the largest relative change of a field.", "Pass for example 0.02.")
#: Differences of each field, each half as wide as the last.
_LEVELS = 6


def sensitivity(
    measure: Measure | Callable[..., Any],
    *arguments: Any,
    parameters: str | Sequence[str],
    of: Of | None = None,
    step: float = 0.02,
    **options: Any,
) -> xr.Dataset:
    """Derivatives of what a verb computes by numeric fields.

    Parameters
    ----------
    measure
        A :class:`remanent.Measure`, or a verb, followed by its arguments and options.
    parameters
        Fields of the actuator or the drive, ``initial.stretch`` ...; ``shear_modulus``,
        ``density``, ``remanence`` where the verb knows them.
    of
        The variable of the verb's result.
    step
        Largest change of a field, relative to its value, or absolute where that is 0.  Six
        differences are formed, each half as wide as the last.

    Returns
    -------
    xarray.Dataset
        Along ``field``, and the dimensions of the measure: ``value``, ``value_error``;
        ``derivative`` with ``derivative_error``; ``elasticity``, the relative change of the
        measure over that of the field, with ``elasticity_error``.

    Raises
    ------
    InputError
        A bad argument.

    Notes
    -----
    All runs are one ensemble.  Richardson's extrapolation of central differences; the error
    is the disagreement within its table and what the errors of the verb make of it.  Where a
    measure jumps or has a corner within the step, the error is as large as the derivative.  A
    field whose change breaks its rule (a viscosity of 0) has NaN.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.sensitivity(
    ...     rm.shape_commands, rm.Actuator(), 1.5, of="switch_time", parameters=["temperature", "c"]
    ... )
    >>> [round(x, 6) for x in ds.elasticity.values.tolist()]
    [-0.5, 0.390917]
    """
    asked = as_measure(measure, arguments, of, **options)
    step = require_real("step", step, _STEP)
    asked.require(listed(parameters))
    at = chosen(parameters, asked.own())
    names, centre = list(at), np.array(list(at.values()))
    widths = step * np.where(centre == 0.0, 1.0, np.abs(centre))
    away = np.concatenate([offsets(width, _LEVELS) for width in widths])
    rows = np.repeat(centre[None], 1 + away.size, axis=0)
    rows[np.arange(1, away.size + 1), np.repeat(np.arange(len(names)), 2 * _LEVELS)] += away
    values, errors = asked.at(dict(zip(names, rows.T, strict=True)))
    dims = tuple(str(d) for d in values.dims if d != SAMPLE)
    shape = values.shape[1:]
    flat, noise = (array.values.reshape(len(rows), -1).astype(float) for array in (values, errors))
    found = [richardson(_block(flat, k), _block(noise, k), width) for k, width in enumerate(widths)]
    slope, wrong = (np.array(part) for part in zip(*found, strict=True))
    with np.errstate(all="ignore"):
        relative = centre[:, None] / flat[0]
    variables: dict[str, Labelled] = {
        "value": (dims, flat[0].reshape(shape)),
        "value_error": (dims, noise[0].reshape(shape)),
    }
    for name, part in {
        "derivative": slope,
        "derivative_error": wrong,
        "elasticity": slope * relative,
        "elasticity_error": np.abs(relative) * (wrong + np.abs(slope) * noise[0] / np.abs(flat[0])),
    }.items():
        variables[name] = (("field", *dims), part.reshape(len(names), *shape))
    coords: dict[str, Labelled] = {"field": (("field",), np.array(names))}
    for d in dims:
        if d in values.coords:
            coords[d] = ((d,), values[d].values)
    attributes = provenance.attributes(
        asked.actuator, asked.drive, None, measure=repr(asked), step=step, scaled=False
    )
    return build.dataset(variables, coords, attributes)


def _block(values: FloatArray, k: int) -> FloatArray:
    """Rows of the differences in field k."""
    start = 1 + 2 * _LEVELS * k
    return values[start : start + 2 * _LEVELS]

"""Fields that put measures where they are wanted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from remanent._checks import positive, require_numbers, require_real
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.fitting import Box, jacobian
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.inference.measure import Measure, chosen, listed, together

_STEP = positive("It is the relative change of a field in a difference.", "Pass 1e-3.")


def design(
    measures: Measure | Sequence[Measure],
    targets: float | Sequence[float],
    parameters: Mapping[str, float] | Sequence[str] | str,
    *,
    parameter_ranges: Mapping[str, tuple[float, float]] | None = None,
    step: float = 1e-3,
) -> xr.Dataset:
    """Find the fields with which measures take given values.

    Parameters
    ----------
    measures
        What is to be placed, each one number.
    targets
        Where, one for each.
    parameters
        What may change: names, or names with first guesses.  As many as measures, for an
        answer to the point; fewer come as near as they can, more stay near the guess.
    parameter_ranges
        Lowest and highest value of some of the fields.
    step
        Relative change of a field in differences.

    Returns
    -------
    xarray.Dataset
        Along ``field``: ``solution``, with ``solution_error``, what the errors of the measures
        and what is left of the distance make of it (NaN where fields can be exchanged for one
        another); along ``measure``: ``target``, ``reached`` and ``reached_error``.

    Raises
    ------
    InputError
        A bad argument, or a guess at which a measure is not known.

    Notes
    -----
    Least squares of the relative distances (SciPy's trust-region reflective method); the
    differences of a step are one ensemble.

    Examples
    --------
    >>> import remanent as rm
    >>> switch = rm.Measure(rm.shape_commands, rm.Actuator(), 1.5, of="switch_time")
    >>> ds = rm.design(switch, 1.2, "temperature")
    >>> round(float(ds.solution[0]), 3)  # 293 (1.42388/1.2)^2
    412.529
    """
    asked = [measures] if isinstance(measures, Measure) else list(measures)
    step = require_real("step", step, _STEP)
    wanted = np.array(require_numbers("targets", np.atleast_1d(np.asarray(targets, dtype=float))))
    guess = _guesses(asked, parameters)
    if len(wanted) != len(asked):
        raise InputError(
            "targets", f"have {len(asked)} values", len(wanted),
            "Each measure has one.", "Pass one target per measure.",
        )  # fmt: skip
    names, start = list(guess), np.array(list(guess.values()))
    box = _box(guess, parameter_ranges or {})
    weight = np.maximum(np.abs(wanted), 1e-3)

    def distance(rows: FloatArray) -> FloatArray:
        values, _ = together(asked, names, rows)
        return np.asarray((values - wanted) / weight)

    def residual(x: FloatArray) -> FloatArray:
        return np.asarray(distance(x[None])[0])

    def slopes(x: FloatArray) -> FloatArray:
        return jacobian(distance, x, box, step)

    begin = distance(start[None])
    if not np.isfinite(begin).all() or begin.shape[1] != len(asked):
        raise InputError(
            "parameters", "start where each measure is one known number", guess,
            "The search starts there.", "Pass other guesses, or reduce the measure by `of`.",
        )  # fmt: skip
    with np.errstate(all="ignore"):  # of a measure that stops changing
        found = least_squares(
            residual, start, jac=slopes, bounds=(box.lower, box.upper), x_scale=box.scale,
            xtol=1e-12, ftol=1e-15, gtol=None, max_nfev=60,
        )  # fmt: skip
    values, errors = together(asked, names, found.x[None])
    slope = slopes(found.x) * box.scale
    unknown = np.full(len(names), np.nan)
    if np.linalg.matrix_rank(slope, rtol=1e-8) == len(names):
        doubt = (errors[0] + np.abs(values[0] - wanted)) / weight
        unknown = box.scale * (np.abs(np.linalg.pinv(slope)) @ doubt)
    variables: dict[str, Labelled] = {
        "solution": (("field",), np.asarray(found.x)),
        "solution_error": (("field",), unknown),
        "target": (("measure",), wanted),
        "reached": (("measure",), values[0]),
        "reached_error": (("measure",), errors[0]),
    }
    labels = np.array([repr(m) for m in asked])
    coords: dict[str, Labelled] = {
        "field": (("field",), np.array(names)),
        "measure": (("measure",), labels),
    }
    attributes = provenance.attributes(
        asked[0].actuator, asked[0].drive, None, over=names, scaled=False
    )
    return build.dataset(variables, coords, attributes)


def _guesses(
    asked: Sequence[Measure], fields: Mapping[str, float] | Sequence[str] | str
) -> dict[str, float]:
    for measure in asked:
        measure.require(listed(fields))
    return chosen(fields, asked[0].own())


def _box(guess: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]) -> Box:
    value = np.array(list(guess.values()))
    ends = np.array([bounds.get(name, (-np.inf, np.inf)) for name in guess], dtype=float)
    if not ((ends[:, 0] < ends[:, 1]) & (ends[:, 0] <= value) & (value <= ends[:, 1])).all():
        raise InputError(
            "bounds", "lie around the guesses", dict(bounds),
            "The search starts there.", "Pass other guesses or wider bounds.",
        )  # fmt: skip
    return Box(np.where(value == 0.0, 1.0, np.abs(value)), ends[:, 0], ends[:, 1])

"""Nonlinear least squares with its uncertainty: covariance, intervals, profiles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import t as student

from remanent._errors import InputError
from remanent._typing import BoolArray, FloatArray

#: ``model(x)`` with candidates (candidate, parameter) gives predictions (candidate, datum).
PredictionFunction = Callable[[FloatArray], FloatArray]

#: Step of a difference, relative to the parameter or its scale, on either side.
_RELATIVE_DIFFERENCE_STEP = 1e-4
#: Distance from the estimate up to which the end of a profile is looked for, in half widths of
#: the linear interval.
_MAX_PROFILE_DISTANCE_IN_HALF_WIDTHS = 8.0
#: Places on each side at which a profile is tried before its end is located.
_PROFILE_TRIALS_PER_SIDE = 4
#: Tolerance of the end of a profile, in half widths of the linear interval.
_PROFILE_END_TOLERANCE_IN_HALF_WIDTHS = 1e-3
#: Condition number of the curvature above which the data do not determine the parameters.
_MAX_CONDITION_NUMBER = 1e14
#: Relative change of the parameters at which least squares stop.
_LEAST_SQUARES_PARAMETER_TOLERANCE = 1e-10
#: Relative change of the sum of squares at which they stop.
_LEAST_SQUARES_COST_TOLERANCE = 1e-12
#: Evaluations of least squares, at most.
_MAX_LEAST_SQUARES_EVALUATIONS = 200


@dataclass(frozen=True)
class Observations:
    """What was measured.

    Attributes
    ----------
    measured_values : array (datum,)
    standard_deviations : array (datum,)
        Standard deviations, up to a common factor where they are not `has_absolute_deviations`.
    has_absolute_deviations : bool
        Whether the deviations are true; else the scatter about the fit says how large they are.
    """

    measured_values: FloatArray
    standard_deviations: FloatArray
    has_absolute_deviations: bool


@dataclass(frozen=True)
class LeastSquaresFit:
    """Parameters that fit best.

    Attributes
    ----------
    estimate : array (parameter,)
    covariance : array (parameter, parameter)
        s^2 (J^T W J)^-1; s = 1 where deviations are known.
    predicted_values : array (datum,)
    chi_square : float
        Sum of squares of residuals over deviations.
    residual_variance : float
        s^2: 1, or chi_square over the degrees of freedom.
    degrees_of_freedom : int
        Data less parameters.
    has_converged : bool
        Whether the search came to its end within the evaluations that it has.
    """

    estimate: FloatArray
    covariance: FloatArray
    predicted_values: FloatArray
    chi_square: float
    residual_variance: float
    degrees_of_freedom: int
    has_converged: bool = True

    @property
    def standard_errors(self) -> FloatArray:
        """Standard errors, array (parameter,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def two_sided_t_quantile(self, confidence: float) -> float:
        """Half width of a two-sided interval in standard errors (Student's t)."""
        # Half the remaining probability lies beyond either end.
        return float(student.ppf(0.5 * (1.0 + confidence), self.degrees_of_freedom))


@dataclass(frozen=True)
class ParameterBox:
    """Scales and bounds of parameters, arrays (parameter,).

    Attributes
    ----------
    scales : array (parameter,)
        Their units, for differences and for least squares.
    lower_bounds, upper_bounds : array (parameter,)
        Infinite where there is no bound.
    """

    scales: FloatArray
    lower_bounds: FloatArray
    upper_bounds: FloatArray

    def subset(self, mask: BoolArray) -> ParameterBox:
        """The box of some of the parameters."""
        return ParameterBox(self.scales[mask], self.lower_bounds[mask], self.upper_bounds[mask])


def fit_least_squares(
    model: PredictionFunction, data: Observations, guess: FloatArray, box: ParameterBox
) -> LeastSquaresFit:
    """Minimise sum [(model(x) - values)/deviation]^2 over x.

    The Jacobian is a central difference, all of whose candidates are one call of the model.

    Parameters
    ----------
    model : callable
        Of candidates (candidate, parameter), predictions (candidate, datum).
    data : Observations
    guess : array (parameter,)
        To start from.
    box : ParameterBox

    Raises
    ------
    InputError
        The guess cannot be computed, or the data do not determine the parameters.
    """
    degrees = data.measured_values.size - guess.size
    if degrees < 1:
        raise InputError(
            "data",
            must=f"have more than {guess.size} values",
            got=data.measured_values.size,
            why="As many parameters fit them whatever they are.",
            fix="Measure more, or fit fewer.",
        )
    x, residual, converged = _minimise_residuals(model, data, guess, box)
    slope = difference_jacobian(model, x, box) / data.standard_deviations[:, None]
    curvature = slope.T @ slope * np.outer(box.scales, box.scales)
    if not np.linalg.cond(curvature) < _MAX_CONDITION_NUMBER:
        raise InputError(
            "parameters",
            must="each change the prediction in a way of its own",
            got=x.tolist(),
            why="Some combination of them leaves all data as they are.",
            fix="Fit fewer of them.",
        )
    chi_square = float(residual @ residual)
    variance = 1.0 if data.has_absolute_deviations else chi_square / degrees
    inverse = np.linalg.inv(curvature) * np.outer(box.scales, box.scales)
    predicted = data.measured_values + residual * data.standard_deviations
    return LeastSquaresFit(
        x, variance * inverse, predicted, chi_square, variance, degrees, converged
    )


def difference_jacobian(
    model: PredictionFunction,
    x: FloatArray,
    box: ParameterBox,
    step: float = _RELATIVE_DIFFERENCE_STEP,
) -> FloatArray:
    """Derivatives of predictions by differences, central but at the bounds of what is known.

    Parameters
    ----------
    model : callable
        Of candidates (candidate, parameter), predictions (candidate, datum).
    x : array (parameter,)
        Where.
    box : ParameterBox
    step : float
        Relative to the parameter or its scale, whichever is larger.

    Returns
    -------
    array (datum, parameter)
        NaN by parameters that the model can be computed to neither side of.
    """
    steps = step * np.diag(np.maximum(np.abs(x), box.scales))
    ends = np.concatenate([x + steps, x - steps]).clip(box.lower_bounds, box.upper_bounds)
    values = model(ends)
    lost = ~np.isfinite(values).all(axis=1)
    if lost.any():  # beyond what the model can compute: to one side only
        ends[lost], values[lost] = x, model(x[None])[0]
    count = x.size
    width = np.diag(ends[:count] - ends[count:])
    return np.asarray((values[:count] - values[count:]).T / np.where(width == 0.0, np.nan, width))


def profile_likelihood_interval(
    model: PredictionFunction,
    data: Observations,
    best: LeastSquaresFit,
    box: ParameterBox,
    k: int,
    confidence: float,
) -> FloatArray:
    """Interval of parameter k by its profile likelihood.

    Its ends are where the least sum of squares at fixed x_k exceeds the minimum by s^2 t^2: the
    interval is not symmetric where the model is not linear.

    Parameters
    ----------
    model : callable
        Of candidates (candidate, parameter).
    data : Observations
    best : LeastSquaresFit
        Of all parameters.
    box : ParameterBox
    k : int
        Number of the parameter.
    confidence : float
        Probability that the interval holds it.

    Returns
    -------
    array (2,)
        An end that is not found within the bounds and eight half widths is infinite.
    """
    threshold = best.residual_variance * best.two_sided_t_quantile(confidence) ** 2
    free = np.arange(best.estimate.size) != k
    rest = best.estimate[free]

    def excess(value: float) -> float:
        # The other parameters start from their best values at the place before.
        nonlocal rest

        def held(x: FloatArray) -> FloatArray:
            return model(np.insert(x, k, value, axis=1))

        if free.any():
            if not np.isfinite(held(rest[None])).all():
                return np.nan
            rest, residual, _ = _minimise_residuals(held, data, rest, box.subset(free))
        else:
            residual = (held(np.empty((1, 0)))[0] - data.measured_values) / data.standard_deviations
        return float(residual @ residual) - best.chi_square - threshold

    half = best.standard_errors[k] * best.two_sided_t_quantile(confidence)
    ends = []
    for side, bound in ((-1.0, box.lower_bounds[k]), (1.0, box.upper_bounds[k])):
        rest, inner, end = best.estimate[free], best.estimate[k], side * np.inf
        for width in np.geomspace(
            1.0, _MAX_PROFILE_DISTANCE_IN_HALF_WIDTHS, _PROFILE_TRIALS_PER_SIDE
        ):
            outer = float(np.clip(best.estimate[k] + side * width * half, *sorted((inner, bound))))
            beyond = excess(outer)
            if beyond > 0.0:
                end = brentq(
                    excess, inner, outer, xtol=_PROFILE_END_TOLERANCE_IN_HALF_WIDTHS * half
                )
                break
            if np.isnan(beyond):  # the model is not known so far out
                break
            inner = outer
        ends.append(end)
    return np.array(ends)


def _minimise_residuals(
    model: PredictionFunction, data: Observations, guess: FloatArray, box: ParameterBox
) -> tuple[FloatArray, FloatArray, bool]:
    """Best parameters, residuals over deviations, and whether the search came to its end."""

    def residual(x: FloatArray) -> FloatArray:
        return np.asarray((model(x[None])[0] - data.measured_values) / data.standard_deviations)

    def slope(x: FloatArray) -> FloatArray:
        slopes = difference_jacobian(model, x, box)
        if not np.isfinite(slopes).all():
            raise InputError(
                "parameters",
                must="lead to values whose motion can be computed, a little to either side too",
                got=x.tolist(),
                why="The search came to the end of what the model can compute.",
                fix="Use earlier data, a larger tolerance, narrower ranges or a better guess.",
            )
        return np.asarray(slopes / data.standard_deviations[:, None])

    if not np.isfinite(residual(guess)).all():
        raise InputError(
            "parameters",
            must="start from values whose motion can be computed over all the data",
            got=guess.tolist(),
            why="Its error bound is not met up to the last of them.",
            fix="Use earlier data, a larger tolerance, or a better guess.",
        )
    with np.errstate(all="ignore"):  # SciPy takes back steps at whose end nothing is known
        solution = least_squares(
            residual, guess, jac=slope, x_scale=box.scales,
            bounds=(box.lower_bounds, box.upper_bounds),
            xtol=_LEAST_SQUARES_PARAMETER_TOLERANCE, ftol=_LEAST_SQUARES_COST_TOLERANCE,
            gtol=None, max_nfev=_MAX_LEAST_SQUARES_EVALUATIONS,
        )  # fmt: skip
    return np.asarray(solution.x), np.asarray(solution.fun), bool(solution.status > 0)

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
Model = Callable[[FloatArray], FloatArray]

#: Differences span this share of a parameter's scale on either side.
_STEP = 1e-4
#: A profile is looked for up to so many times the half width of the linear interval.
_FARTHEST = 8.0


@dataclass(frozen=True)
class Observations:
    """What was measured.

    Attributes
    ----------
    values : array (datum,)
    deviation : array (datum,)
        Standard deviations, up to a common factor where they are not `known`.
    known : bool
        Whether the deviations are absolute; else the scatter about the fit says how large.
    """

    values: FloatArray
    deviation: FloatArray
    known: bool


@dataclass(frozen=True)
class LeastSquaresFit:
    """Parameters that fit best.

    Attributes
    ----------
    estimate : array (parameter,)
    covariance : array (parameter, parameter)
        s^2 (J^T W J)^-1; s = 1 where deviations are known.
    predicted : array (datum,)
    chi_square : float
        Sum of squares of residuals over deviations.
    variance : float
        s^2: 1, or chi_square over the degrees of freedom.
    degrees : int
        Data less parameters.
    """

    estimate: FloatArray
    covariance: FloatArray
    predicted: FloatArray
    chi_square: float
    variance: float
    degrees: int

    @property
    def deviation(self) -> FloatArray:
        """Standard errors, array (parameter,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def quantile(self, confidence: float) -> float:
        """Half width of a two-sided interval in standard errors (Student's t)."""
        return float(student.ppf(0.5 * (1.0 + confidence), self.degrees))


@dataclass(frozen=True)
class ParameterBox:
    """Scales and bounds of parameters, arrays (parameter,)."""

    scale: FloatArray
    lower: FloatArray
    upper: FloatArray

    def only(self, kept: BoolArray) -> ParameterBox:
        return ParameterBox(self.scale[kept], self.lower[kept], self.upper[kept])


def fit_least_squares(
    model: Model, data: Observations, guess: FloatArray, box: ParameterBox
) -> LeastSquaresFit:
    """Minimise sum [(model(x) - values)/deviation]^2 over x.

    The Jacobian is a central difference, all of whose candidates are one call of the model.

    Raises
    ------
    InputError
        The guess cannot be computed, or the data do not determine the parameters.
    """
    degrees = data.values.size - guess.size
    if degrees < 1:
        raise InputError(
            "data",
            must=f"have more than {guess.size} values",
            got=data.values.size,
            why="As many parameters fit them whatever they are.",
            fix="Measure more, or fit fewer.",
        )
    x, residual = _minimum(model, data, guess, box)
    slope = difference_jacobian(model, x, box) / data.deviation[:, None]
    curvature = slope.T @ slope * np.outer(box.scale, box.scale)
    if not np.linalg.cond(curvature) < 1e14:
        raise InputError(
            "parameters",
            must="each change the prediction in a way of its own",
            got=x.tolist(),
            why="Some combination of them leaves all data as they are.",
            fix="Fit fewer of them.",
        )
    chi_square = float(residual @ residual)
    variance = 1.0 if data.known else chi_square / degrees
    inverse = np.linalg.inv(curvature) * np.outer(box.scale, box.scale)
    predicted = data.values + residual * data.deviation
    return LeastSquaresFit(x, variance * inverse, predicted, chi_square, variance, degrees)


def difference_jacobian(
    model: Model, x: FloatArray, box: ParameterBox, step: float = _STEP
) -> FloatArray:
    """Derivatives (datum, parameter) by differences, central but at the bounds."""
    steps = step * np.diag(np.maximum(np.abs(x), box.scale))
    ends = np.concatenate([x + steps, x - steps]).clip(box.lower, box.upper)
    values = model(ends)
    count = x.size
    width = np.diag(ends[:count] - ends[count:])
    return np.asarray((values[:count] - values[count:]).T / width)


def profile_interval(
    model: Model,
    data: Observations,
    found: LeastSquaresFit,
    box: ParameterBox,
    k: int,
    confidence: float,
) -> FloatArray:
    """Interval of parameter k by its profile likelihood, array (2,).

    Where the least sum of squares at fixed x_k exceeds the minimum by s^2 t^2; an end that is
    not found within the bounds and eight half widths is infinite.
    """
    threshold = found.variance * found.quantile(confidence) ** 2
    others = np.arange(found.estimate.size) != k
    rest = found.estimate[others]

    def excess(value: float) -> float:
        nonlocal rest

        def held(x: FloatArray) -> FloatArray:
            return model(np.insert(x, k, value, axis=1))

        if others.any():
            rest, residual = _minimum(held, data, rest, box.only(others))
        else:
            residual = (held(np.empty((1, 0)))[0] - data.values) / data.deviation
        return float(residual @ residual) - found.chi_square - threshold

    half = found.deviation[k] * found.quantile(confidence)
    ends = []
    for side, bound in ((-1.0, box.lower[k]), (1.0, box.upper[k])):
        rest, inner, end = found.estimate[others], found.estimate[k], side * np.inf
        for width in np.geomspace(1.0, _FARTHEST, 4):
            outer = float(np.clip(found.estimate[k] + side * width * half, *sorted((inner, bound))))
            if excess(outer) > 0.0:
                end = brentq(excess, inner, outer, xtol=1e-3 * half)
                break
            inner = outer
        ends.append(end)
    return np.array(ends)


def _minimum(
    model: Model, data: Observations, guess: FloatArray, box: ParameterBox
) -> tuple[FloatArray, FloatArray]:
    """Best parameters, and residuals over deviations."""

    def residual(x: FloatArray) -> FloatArray:
        return np.asarray((model(x[None])[0] - data.values) / data.deviation)

    def slope(x: FloatArray) -> FloatArray:
        return np.asarray(difference_jacobian(model, x, box) / data.deviation[:, None])

    if not np.isfinite(residual(guess)).all():
        raise InputError(
            "parameters",
            must="start from values whose motion can be computed over all the data",
            got=guess.tolist(),
            why="Its error bound is not met up to the last of them.",
            fix="Use earlier data, a larger tolerance, or a better guess.",
        )
    found = least_squares(
        residual, guess, jac=slope, bounds=(box.lower, box.upper), x_scale=box.scale,
        xtol=1e-10, ftol=1e-12, gtol=None, max_nfev=200,
    )  # fmt: skip
    return np.asarray(found.x), np.asarray(found.fun)

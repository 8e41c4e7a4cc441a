"""What uncertain arguments make of a function: quantiles and Sobol' indices, with errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.stats import norm, qmc, sobol_indices
from scipy.stats import t as student

from remanent._typing import FloatArray

#: ``function(x)`` with points (point, argument) gives values (point, number).
PointwiseFunction = Callable[[FloatArray], FloatArray]
#: Independently scrambled parts of a sample, whose scatter is the error of what they give.
SCRAMBLED_REPLICATE_COUNT = 8
#: Standard errors of means over the parts: within them lies the truth as often as within one
#: standard deviation of a normal variable, with Student's t for so few parts.
_STANDARD_ERROR_FACTOR = float(
    student.ppf(norm.cdf(1.0), SCRAMBLED_REPLICATE_COUNT - 1) / np.sqrt(SCRAMBLED_REPLICATE_COUNT)
)


class Distribution(Protocol):
    """A frozen distribution of SciPy, or anything with its quantiles."""

    def ppf(self, q: FloatArray, /) -> FloatArray:
        """The values below which shares `q` lie."""


@dataclass(frozen=True)
class UncertainArguments:
    """Arguments of a function as random variables.

    Attributes
    ----------
    distributions : sequence of Distribution
        Of arguments that are independent of all others.
    mean, covariance : array (argument,) and array (argument, argument)
        Of further arguments, which are normal together.
    """

    distributions: Sequence[Distribution]
    mean: FloatArray = field(default_factory=lambda: np.empty(0))
    covariance: FloatArray = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def count(self) -> int:
        """Number of arguments, the independent ones first."""
        return len(self.distributions) + self.mean.size

    def points(self, shares: FloatArray) -> FloatArray:
        """Points (point, argument) from points of the unit cube."""
        # Scrambled points can fall on 0, where quantiles are infinite.
        inside = np.clip(shares, 0.5**54, 1.0 - 0.5**53)
        independent = [d.ppf(q) for d, q in zip(self.distributions, inside.T, strict=False)]
        joint = self.mean + norm.ppf(inside[:, len(independent) :]) @ self._root().T
        return np.column_stack([*independent, joint])

    def _root(self) -> FloatArray:
        """A matrix whose product with its transpose is the covariance."""
        scales = np.sqrt(np.diag(self.covariance))
        scales = np.where(scales > 0.0, scales, 1.0)
        values, vectors = np.linalg.eigh(self.covariance / np.outer(scales, scales))
        return np.asarray(scales[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


@dataclass(frozen=True)
class PropagatedStatistics:
    """Statistics of values under uncertain arguments, and their sampling errors.

    Attributes
    ----------
    quantiles, quantiles_error : array (quantile, number)
    average, average_error, deviation, deviation_error : array (number,)
    known_share : array (number,)
        Share of the points where the value is known; the rest is left out.
    """

    quantiles: FloatArray
    quantiles_error: FloatArray
    average: FloatArray
    average_error: FloatArray
    deviation: FloatArray
    deviation_error: FloatArray
    known_share: FloatArray


@dataclass(frozen=True)
class SobolIndices:
    """Sobol' indices and their errors, arrays (argument, number)."""

    first_order: FloatArray
    first_order_error: FloatArray
    total_effect: FloatArray
    total_effect_error: FloatArray


def propagate_distributions(
    function: PointwiseFunction,
    arguments: UncertainArguments,
    quantiles: FloatArray,
    samples: int,
    rng: np.random.Generator,
) -> PropagatedStatistics:
    """Propagate uncertain arguments through a function.

    Sobol' points in :data:`SCRAMBLED_REPLICATE_COUNT` parts, each scrambled by itself (Owen 1998).
    Quantiles are means over the parts, averages and deviations those of the whole sample; the
    scatter of the parts gives their standard errors.  NaN where some part knows no value.

    Parameters
    ----------
    function : callable
        Of points (point, argument), values (point, number).
    arguments : UncertainArguments
    quantiles : array (quantile,)
        Probabilities.
    samples : int
        A power of two; a part should have a point beyond each quantile.
    rng : numpy.random.Generator
        Scrambles the points.
    """
    blocks = [
        _draw_sobol_points(arguments, samples // SCRAMBLED_REPLICATE_COUNT, rng)
        for _ in range(SCRAMBLED_REPLICATE_COUNT)
    ]
    values = function(np.concatenate(blocks))
    finite = np.isfinite(values)
    values = np.where(finite, values, np.nan)
    parts = values.reshape(SCRAMBLED_REPLICATE_COUNT, samples // SCRAMBLED_REPLICATE_COUNT, -1)
    # A statistic is given only where every replicate has a value for it.
    unknown = ~finite.reshape(parts.shape).any(axis=1).all(axis=0)

    def with_error(
        statistic: Callable[[FloatArray], FloatArray], *, of_all: bool = False
    ) -> tuple[FloatArray, FloatArray]:
        by_part = np.stack([statistic(np.where(unknown, 0.0, part)) for part in parts])
        error = by_part.std(axis=0, ddof=1) * _STANDARD_ERROR_FACTOR
        best = statistic(np.where(unknown, 0.0, values)) if of_all else by_part.mean(axis=0)
        return np.where(unknown, np.nan, best), np.where(unknown, np.nan, error)

    def sample_quantiles(x: FloatArray) -> FloatArray:
        # Hazen's positions: where evenly spread points are, in the middle of their shares.
        return np.asarray(np.nanquantile(x, quantiles, axis=0, method="hazen"))

    return PropagatedStatistics(
        *with_error(sample_quantiles),
        *with_error(lambda x: np.nanmean(x, axis=0), of_all=True),
        # Without a degree of freedom less: the mean of Sobol' points moves far less than that
        # of independent ones, for which it makes up.
        *with_error(lambda x: np.nanstd(x, axis=0), of_all=True),
        finite.mean(axis=0),
    )


def estimate_sobol_indices(
    function: PointwiseFunction,
    arguments: UncertainArguments,
    samples: int,
    rng: np.random.Generator,
) -> SobolIndices:
    """Shares of the variance that arguments account for alone, and with all others.

    Saltelli's estimators (2010) as SciPy has them, for each of
    :data:`SCRAMBLED_REPLICATE_COUNT` parts scrambled by itself; their mean, and its standard
    error.  (A bootstrap takes the points for independent, which they are not.)
    ``samples * (arguments + 2)`` points, all in one call.  NaN where the function is
    constant, or unknown somewhere.

    Parameters
    ----------
    function : callable
        Of points (point, argument), values (point, number).
    arguments : UncertainArguments
    samples : int
        A power of two.
    rng : numpy.random.Generator
        Scrambles the points.
    """
    count, size = arguments.count, samples // SCRAMBLED_REPLICATE_COUNT
    sequence = [_scrambled_shares(2 * count, size, rng) for _ in range(SCRAMBLED_REPLICATE_COUNT)]
    rows = [_saltelli_points(part[:, :count], part[:, count:]) for part in sequence]
    values = function(arguments.points(np.concatenate(rows)))
    values = values.reshape(SCRAMBLED_REPLICATE_COUNT, count + 2, size, -1).transpose(1, 0, 3, 2)
    usable = np.isfinite(values).all(axis=(0, 1, 3)) & (np.ptp(values, axis=(0, 1, 3)) > 0.0)
    by_part = np.full((2, SCRAMBLED_REPLICATE_COUNT, count, len(usable)), np.nan)
    for part in range(SCRAMBLED_REPLICATE_COUNT):
        # Less the mean, which changes no variance but saves digits.
        runs = values[:, part, usable] - values[:2, part, usable].mean(axis=(0, 2))[:, None]
        if usable.any():
            # SciPy stumbles over a single number of a single argument: it gets one twice.
            runs = np.concatenate([runs, runs[:, :1]], axis=1)
            blocks = {"f_A": runs[0], "f_B": runs[1], "f_AB": runs[2:]}
            shares = sobol_indices(func=blocks, n=size)  # type: ignore[arg-type]
            for k, order in enumerate((shares.first_order, shares.total_order)):
                by_part[k, part][:, usable] = np.reshape(order, (-1, count))[:-1].T
    first, total = by_part.mean(axis=1)
    error = by_part.std(axis=1, ddof=1) * _STANDARD_ERROR_FACTOR
    return SobolIndices(first, error[0], total, error[1])


def _saltelli_points(a: FloatArray, b: FloatArray) -> FloatArray:
    """Points a, points b, and a with one column after the other from b."""
    columns = np.arange(a.shape[1])
    return np.concatenate([a, b, *(np.where(columns == k, b, a) for k in columns)])


def _draw_sobol_points(
    arguments: UncertainArguments, count: int, rng: np.random.Generator
) -> FloatArray:
    return arguments.points(_scrambled_shares(arguments.count, count, rng))


def _scrambled_shares(dimensions: int, count: int, rng: np.random.Generator) -> FloatArray:
    """Scrambled Sobol' points of the unit cube, array (point, dimension).

    The digits beyond those in which `count` points are evenly spread are drawn anew for each
    point, as in Owen's scrambling (1995).  SciPy's is linear in the digits: means of nearly
    linear functions are then exact in most parts and far off in a few, and their scatter says
    little.
    """
    cells = np.floor(qmc.Sobol(dimensions, rng=rng).random(count) * count)
    return np.asarray((cells + rng.random(cells.shape)) / count)

"""What uncertain arguments make of a function: quantiles and Sobol' indices, with errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.stats import qmc, sobol_indices

from remanent._typing import FloatArray

#: ``function(x)`` with points (point, argument) gives values (point, number).
PointwiseFunction = Callable[[FloatArray], FloatArray]
#: Independently scrambled parts of a sample, whose scatter is the error of what they give.
SCRAMBLED_REPLICATE_COUNT = 8


class Distribution(Protocol):
    """A frozen distribution of SciPy, or anything with its quantiles."""

    def ppf(self, q: FloatArray, /) -> FloatArray:
        """The values below which shares `q` lie."""


@dataclass(frozen=True)
class PropagatedStatistics:
    """Statistics of values under uncertain arguments, and their sampling errors.

    Attributes
    ----------
    quantiles, quantiles_error : array (quantile, number)
    average, average_error, deviation, deviation_error : array (number,)
    known : array (number,)
        Share of the points where the value is known; the rest is left out.
    """

    quantiles: FloatArray
    quantiles_error: FloatArray
    average: FloatArray
    average_error: FloatArray
    deviation: FloatArray
    deviation_error: FloatArray
    known: FloatArray


@dataclass(frozen=True)
class SobolIndices:
    """Sobol' indices and their errors, arrays (argument, number)."""

    first_order: FloatArray
    first_order_error: FloatArray
    total_effect: FloatArray
    total_effect_error: FloatArray


def propagate_distributions(
    function: PointwiseFunction,
    distributions: Sequence[Distribution],
    quantiles: FloatArray,
    samples: int,
    rng: np.random.Generator,
) -> PropagatedStatistics:
    """Propagate independent distributions through a function.

    Sobol' points in :data:`SCRAMBLED_REPLICATE_COUNT` parts, each scrambled by itself (Owen 1998).
    Results are means over the parts, and their errors the standard errors of these means.  NaN
    where some part knows no value.

    Parameters
    ----------
    function : callable
        Of points (point, argument), values (point, number).
    distributions : sequence
        One for each argument.
    quantiles : array (quantile,)
        Probabilities.
    samples : int
        A power of two; a part should have a point beyond each quantile.
    rng : numpy.random.Generator
        Scrambles the points.
    """
    blocks = [
        _draw_sobol_points(distributions, samples // SCRAMBLED_REPLICATE_COUNT, rng)
        for _ in range(SCRAMBLED_REPLICATE_COUNT)
    ]
    values = function(np.concatenate(blocks))
    finite = np.isfinite(values)
    values = np.where(finite, values, np.nan)
    parts = values.reshape(SCRAMBLED_REPLICATE_COUNT, samples // SCRAMBLED_REPLICATE_COUNT, -1)
    # A statistic is given only where every replicate has a value for it.
    unknown = ~finite.reshape(parts.shape).any(axis=1).all(axis=0)

    def with_error(
        statistic: Callable[[FloatArray], FloatArray],
    ) -> tuple[FloatArray, FloatArray]:
        by_part = np.stack([statistic(np.where(unknown, 0.0, part)) for part in parts])
        error = by_part.std(axis=0, ddof=1) / np.sqrt(SCRAMBLED_REPLICATE_COUNT)
        return np.where(unknown, np.nan, by_part.mean(axis=0)), np.where(unknown, np.nan, error)

    def sample_quantiles(x: FloatArray) -> FloatArray:
        # Hazen's positions: where evenly spread points are, in the middle of their shares.
        return np.asarray(np.nanquantile(x, quantiles, axis=0, method="hazen"))

    return PropagatedStatistics(
        *with_error(sample_quantiles),
        *with_error(lambda x: np.nanmean(x, axis=0)),
        *with_error(lambda x: np.nanstd(x, axis=0, ddof=1)),
        finite.mean(axis=0),
    )


def estimate_sobol_indices(
    function: PointwiseFunction,
    distributions: Sequence[Distribution],
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
    distributions : sequence
        One for each argument.
    samples : int
        A power of two.
    rng : numpy.random.Generator
        Scrambles the points.
    """
    count, size = len(distributions), samples // SCRAMBLED_REPLICATE_COUNT
    sequence = [
        qmc.Sobol(2 * count, rng=rng).random(size) for _ in range(SCRAMBLED_REPLICATE_COUNT)
    ]
    rows = [_saltelli_points(part[:, :count], part[:, count:]) for part in sequence]
    values = function(_map_from_unit_cube(distributions, np.concatenate(rows)))
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
    error = by_part.std(axis=1, ddof=1) / np.sqrt(SCRAMBLED_REPLICATE_COUNT)
    return SobolIndices(first, error[0], total, error[1])


def _saltelli_points(a: FloatArray, b: FloatArray) -> FloatArray:
    """Points a, points b, and a with one column after the other from b."""
    columns = np.arange(a.shape[1])
    return np.concatenate([a, b, *(np.where(columns == k, b, a) for k in columns)])


def _draw_sobol_points(
    distributions: Sequence[Distribution], count: int, rng: np.random.Generator
) -> FloatArray:
    return _map_from_unit_cube(distributions, qmc.Sobol(len(distributions), rng=rng).random(count))


def _map_from_unit_cube(distributions: Sequence[Distribution], shares: FloatArray) -> FloatArray:
    """Points of the distributions, array (point, argument), from points of the unit cube."""
    # Scrambled points can fall on 0, where quantiles are infinite.
    inside = np.clip(shares, 0.5**54, 1.0 - 0.5**53)
    columns = [d.ppf(q) for d, q in zip(distributions, inside.T, strict=True)]
    return np.column_stack(columns)

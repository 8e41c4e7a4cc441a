"""What uncertain fields make of anything a verb computes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import uniform

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.uncertainty import PARTS, Distribution, indices, spread
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.results.schema import describe
from remanent.studies.ensemble.durations import require_count
from remanent.studies.inference.measure import SAMPLE, Measure, Of, as_measure


def uncertainty(
    measure: Measure | Callable[..., Any],
    *arguments: Any,
    parameter_ranges: Mapping[str, Any],
    of: Of | None = None,
    samples: int = 1024,
    quantiles: Sequence[float] = (0.05, 0.5, 0.95),
    sobol: bool = False,
    rng: int | np.random.Generator = 0,
    **options: Any,
) -> xr.Dataset:
    """Propagate uncertain fields through a verb.

    Parameters
    ----------
    measure
        A :class:`remanent.Measure`, or a verb, followed by its arguments and options.
    parameter_ranges
        What is not known: fields by name, each with ``(low, high)`` between which all values
        are alike, or a frozen distribution of ``scipy.stats``.  They are independent.
    of
        The variable of the verb's result: one number, or a history or response.
    samples
        Points of a Sobol' sequence, a power of two, at least eight over the outermost share.
    quantiles
        Increasing, between 0 and 1.
    sobol
        Whether to find the indices too, which takes samples × (fields + 2) more runs.
    rng
        Seed or generator of the scrambling.

    Returns
    -------
    xarray.Dataset
        The measure (under its own name, ``value`` for a function) along ``quantile`` and its
        own dimensions, ``average``, ``deviation``, each with the standard error of sampling;
        ``known``, the share of points at which the measure is known: the others are left out.
        Along ``field``, where asked: ``first_index``, the share of the variance that a field
        accounts for alone, and ``total_index``, with all it does together with others, each
        with its standard error.

    Raises
    ------
    InputError
        A bad argument.

    Notes
    -----
    Sobol' points in eight parts, each scrambled by itself, whose scatter gives the errors
    (Owen 1998); indices by Saltelli's estimators (2010) in each of them.  The errors are those
    of sampling; that of the verb's own numbers is far smaller at default tolerances.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.uncertainty(
    ...     rm.backbone,
    ...     rm.Actuator(),
    ...     [1.0001],
    ...     of=lambda found: found.frequency.isel({"initial.stretch": 0}),
    ...     parameter_ranges={"temperature": (280.0, 300.0)},
    ... )
    >>> ds.value.values.round(3).tolist()  # (6 T/293)^(1/2)
    [2.399, 2.437, 2.475]
    """
    asked = as_measure(measure, arguments, of, **options)
    names, distributions = (
        list(parameter_ranges),
        [_distribution(n, r) for n, r in parameter_ranges.items()],
    )
    if not names:
        raise InputError(
            "parameter_ranges", "name at least one field", parameter_ranges,
            "Something must be uncertain.",
            "Pass for example {'temperature': (280, 300)}.",
        )  # fmt: skip
    asked.require(names)
    shares = _shares(quantiles)
    samples = _samples(samples, shares)
    generator = np.random.default_rng(rng)
    like: list[xr.DataArray] = []

    def function(points: FloatArray) -> FloatArray:
        values, _ = asked.at(dict(zip(names, points.T, strict=True)))
        like[:] = [values]
        return values.values.reshape(len(points), -1).astype(np.float64)

    found = spread(function, distributions, shares, samples, generator)
    template = like[0]
    dims = tuple(str(d) for d in template.dims if d != SAMPLE)
    shape = template.shape[1:]

    def along(first: str, values: FloatArray) -> Labelled:
        return (first, *dims), values.reshape(-1, *shape)

    name = asked.of if isinstance(asked.of, str) else "value"
    variables: dict[str, Labelled] = {
        name: along("quantile", found.quantiles),
        f"{name}_error": along("quantile", found.quantiles_error),
    }
    for key in ("average", "average_error", "deviation", "deviation_error", "known"):
        variables[key] = (dims, getattr(found, key).reshape(shape))
    if sobol:
        shared = indices(function, distributions, samples, generator)
        for key in ("first", "total"):
            variables[f"{key}_index"] = along("field", getattr(shared, key))
            variables[f"{key}_index_error"] = along("field", getattr(shared, f"{key}_error"))
    coords: dict[str, Labelled] = {"quantile": (("quantile",), shares)}
    if sobol:
        coords["field"] = (("field",), np.array(names))
    for d in dims:
        if d in template.coords:
            coords[d] = ((d,), template[d].values)
    attributes = provenance.attributes(
        asked.actuator, asked.drive, None, over=names, measure=repr(asked), samples=samples,
        scaled=False,
    )  # fmt: skip
    return build.dataset(variables, coords, attributes)


def _samples(samples: int, shares: FloatArray) -> int:
    samples = require_count("samples", samples, "They fill the ranges.")
    needed = PARTS / float(np.minimum(shares, 1.0 - shares).min())
    if samples & (samples - 1) or samples < needed:
        raise InputError(
            "samples", f"be a power of two, at least {needed:.0f} for these quantiles", samples,
            "Sobol' points are evenly spread for these numbers only, and each of eight parts "
            "of them has to reach beyond the quantiles.", "Pass 256, 512, 1024 ...",
        )  # fmt: skip
    return samples


def _distribution(name: str, given: Any) -> Distribution:
    """A distribution as it is, or the uniform one between two numbers."""
    describe(name)
    if hasattr(given, "ppf"):
        return given  # type: ignore[no-any-return]
    try:
        low, high = (float(x) for x in given)
    except (TypeError, ValueError):
        low = high = np.nan
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise InputError(
            f"ranges[{name!r}]", "be a lower and a larger upper number, or a distribution",
            repr(given)[:80], "Values are drawn from it.",
            "Pass (280, 300), or scipy.stats.norm(293, 5).",
        )  # fmt: skip
    return uniform(low, high - low)


def _shares(quantiles: Sequence[float]) -> FloatArray:
    shares = np.atleast_1d(np.asarray(quantiles, dtype=np.float64))
    inside = (shares > 0.0) & (shares < 1.0)
    if shares.ndim != 1 or not shares.size or not inside.all() or (np.diff(shares) <= 0.0).any():
        raise InputError(
            "quantiles", "increase between 0 and 1", quantiles,
            "They are shares of what may happen.", "Pass (0.05, 0.5, 0.95).",
        )  # fmt: skip
    return shares

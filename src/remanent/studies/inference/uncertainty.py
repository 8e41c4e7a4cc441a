"""What uncertain fields make of anything a verb computes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import uniform

from remanent._checks import as_float_array, require_flag
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.inference.uncertainty import (
    SCRAMBLED_REPLICATE_COUNT,
    Distribution,
    PropagatedStatistics,
    SobolIndices,
    estimate_sobol_indices,
    propagate_distributions,
)
from remanent.results import build
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import RngArgument, as_seed, require_interval
from remanent.studies.ensemble.durations import require_count
from remanent.studies.inference._measures import MeasureLayout, as_measure, measure_provenance
from remanent.studies.inference.measure import Measure, OfArgument

#: Statistics without a dimension of their own.
_SCALAR_STATISTIC_NAMES = ("average", "average_error", "deviation", "deviation_error", "known")


def uncertainty(
    measure: Measure | Callable[..., Any],
    *arguments: Any,
    parameter_ranges: Mapping[str, Any],
    of: OfArgument | None = None,
    samples: int = 1024,
    quantiles: Sequence[float] = (0.05, 0.5, 0.95),
    sobol: bool = False,
    rng: RngArgument = None,
    **options: Any,
) -> xr.Dataset:
    """Propagate uncertain fields through a verb.

    Parameters
    ----------
    measure : Measure or callable
        A :class:`remanent.Measure`, or a verb, followed by its arguments and options.
    parameter_ranges : mapping of str to (float, float) or distribution
        What is not known: fields by name, each with ``(low, high)`` between which all values
        are alike, or a frozen distribution of ``scipy.stats``.  They are independent.
    of : str or callable, optional
        The variable of the verb's result, or a function of that result: one number, or a
        history or response.
    samples : int
        Points of a Sobol' sequence, a power of two, at least eight over the outermost share.
    quantiles : sequence of float
        Increasing, between 0 and 1.
    sobol : bool
        Whether to find the indices too, which takes samples × (fields + 2) more runs.
    rng : int, numpy.random.Generator or None
        Scrambles the points.  None is a fixed seed.  A generator is copied: it is not
        advanced.

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

    See Also
    --------
    remanent.sensitivity : derivatives by fields, for small ranges.
    remanent.fit : fields from measurements, with their errors.
    """
    measure = as_measure(measure, arguments, of, **options)
    names = _require_parameter_names(parameter_ranges)
    measure.require_parameters("parameter_ranges", names)
    distributions = [_as_distribution(name, parameter_ranges[name]) for name in names]
    sobol = require_flag("sobol", sobol)
    shares = _require_quantiles(quantiles)
    samples = _require_sample_count(samples, shares)
    generator = np.random.default_rng(as_seed(rng))
    function = _MeasureEvaluation(measure, names)
    statistics = propagate_distributions(function, distributions, shares, samples, generator)
    layout = function.layout
    name = measure.of if isinstance(measure.of, str) else "value"
    variables: dict[str, Labelled] = {
        name: layout.label_numbers(statistics.quantiles, "quantile"),
        f"{name}_error": layout.label_numbers(statistics.quantiles_error, "quantile"),
        **_scalar_statistic_variables(statistics, layout),
    }
    coords: dict[str, Labelled] = {"quantile": (("quantile",), shares)}
    if sobol:
        variables |= _sobol_variables(
            estimate_sobol_indices(function, distributions, samples, generator), layout
        )
        coords["field"] = (("field",), np.array(names))
    return build.dataset(
        variables,
        {**coords, **layout.coords},
        measure_provenance(measure, over=names, measure=repr(measure), samples=samples),
    )


@dataclass
class _MeasureEvaluation:
    """The measure as a function of points (point, parameter), one row of numbers for each.

    It learns one thing from its first call: the layout of the measure, which is known from
    a result alone.
    """

    measure: Measure
    parameter_names: Sequence[str]
    _layout: MeasureLayout | None = None

    def __call__(self, points: FloatArray) -> FloatArray:
        values, _ = self.measure.at(dict(zip(self.parameter_names, points.T, strict=True)))
        self._layout = MeasureLayout.from_values(values)
        return values.values.reshape(len(points), -1).astype(np.float64)

    @property
    def layout(self) -> MeasureLayout:
        """The measure's own dimensions."""
        assert self._layout is not None
        return self._layout


def _scalar_statistic_variables(
    statistics: PropagatedStatistics, layout: MeasureLayout
) -> dict[str, Labelled]:
    return {
        name: layout.label_numbers(getattr(statistics, name)) for name in _SCALAR_STATISTIC_NAMES
    }


def _sobol_variables(sobol: SobolIndices, layout: MeasureLayout) -> dict[str, Labelled]:
    values = {
        "first_index": sobol.first_order,
        "first_index_error": sobol.first_order_error,
        "total_index": sobol.total_effect,
        "total_index_error": sobol.total_effect_error,
    }
    return {name: layout.label_numbers(array, "field") for name, array in values.items()}


def _require_parameter_names(parameter_ranges: object) -> list[str]:
    if not isinstance(parameter_ranges, Mapping) or not parameter_ranges:
        raise InputError(
            "parameter_ranges",
            must="name at least one field",
            got=repr(parameter_ranges)[:80],
            why="Something must be uncertain.",
            fix="Pass for example {'temperature': (280, 300)}.",
        )
    return list(parameter_ranges)


def _require_sample_count(samples: int, shares: FloatArray) -> int:
    samples = require_count("samples", samples, "They fill the ranges.")
    needed = SCRAMBLED_REPLICATE_COUNT / float(np.minimum(shares, 1.0 - shares).min())
    if samples & (samples - 1) or samples < needed:
        raise InputError(
            "samples",
            must=f"be a power of two, at least {needed:.0f} for these quantiles",
            got=samples,
            why="Sobol' points are evenly spread for these numbers only, and each of eight parts "
            "of them has to reach beyond the quantiles.",
            fix="Pass 256, 512, 1024 ...",
        )
    return samples


def _as_distribution(name: str, given: Any) -> Distribution:
    """A distribution as it is, or the uniform one between two numbers."""
    if hasattr(given, "ppf"):
        return given  # type: ignore[no-any-return]
    low, high = require_interval(
        f"parameter_ranges[{name!r}]",
        given,
        what="a lower and a larger upper number, or a distribution",
        why="Values are drawn from it.",
    )
    return uniform(low, high - low)


def _require_quantiles(quantiles: Sequence[float]) -> FloatArray:
    shares = np.atleast_1d(
        as_float_array(
            "quantiles",
            quantiles,
            what="shares between 0 and 1",
            why="They are shares of what may happen.",
            fix="Pass (0.05, 0.5, 0.95).",
            least=1,
        )
    )
    inside = (shares > 0.0) & (shares < 1.0)
    if shares.ndim != 1 or not shares.size or not inside.all() or (np.diff(shares) <= 0.0).any():
        raise InputError(
            "quantiles",
            must="increase between 0 and 1",
            got=quantiles,
            why="They are shares of what may happen.",
            fix="Pass (0.05, 0.5, 0.95).",
        )
    return shares

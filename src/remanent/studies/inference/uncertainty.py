"""What uncertain fields make of anything a verb computes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import uniform

from remanent._checks import as_float_array, require_flag, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.inference.uncertainty import (
    SCRAMBLED_REPLICATE_COUNT,
    Distribution,
    PropagatedStatistics,
    SobolIndices,
    UncertainArguments,
    estimate_sobol_indices,
    propagate_distributions,
)
from remanent.results import build
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import RngArgument, as_seed, require_interval
from remanent.studies.ensemble.durations import require_count
from remanent.studies.inference._fitted_parameters import FittedParameters
from remanent.studies.inference._measures import MeasureLayout, as_measure, measure_provenance
from remanent.studies.inference.measure import Measure, OfArgument

#: Statistics without a dimension of their own.
_SCALAR_STATISTIC_NAMES = (
    "average",
    "average_error",
    "deviation",
    "deviation_error",
    "known_share",
)


def uncertainty(
    measure: Measure | Callable[..., Any],
    *arguments: Any,
    parameter_ranges: Mapping[str, Any] | None = None,
    fit: xr.Dataset | None = None,
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
    *arguments : Any
        Of the verb, where `measure` is one.
    parameter_ranges : mapping of str to (float, float) or distribution, optional
        What is not known: fields by name, each with ``(low, high)`` between which all values
        are alike, or a frozen distribution of ``scipy.stats``.  They are independent.
    fit : xarray.Dataset, optional
        What :func:`remanent.fit` found: its parameters are normal with its estimates and
        covariance.  Other fields are those of the measure: pass ``rm.read_system(found)`` for
        all that was fitted.
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
    **options : Any
        Of the verb, by name.

    Returns
    -------
    xarray.Dataset
        The measure (under its own name, ``value`` for a function) along ``quantile`` and its
        own dimensions, ``average``, ``deviation``, each with its standard error, of sampling
        and of the measure where that has an error (the attribute ``errors`` says which);
        ``known_share``, the share of points at which the measure is known: the others are left out.
        Along ``field``, where asked: ``first_index``, the share of the variance that a field
        accounts for alone, and ``total_index``, with all it does together with others, each
        with its standard error.

    Raises
    ------
    InputError
        A bad argument.

    See Also
    --------
    remanent.sensitivity : Derivatives by fields, for small ranges.
    remanent.fit : Fields from measurements, with their errors.

    Notes
    -----
    Sobol' points in eight parts, each scrambled by itself, whose scatter gives the errors
    (Owen 1998), with Student's t for eight; indices by Saltelli's estimators (2010) in each of
    them, which are for independent fields.

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
    measure = as_measure(measure, arguments, of, **options)
    sobol = require_flag("sobol", sobol)
    ranges = _require_parameter_ranges(parameter_ranges, fit)
    measure.require_parameters("parameter_ranges", list(ranges))
    fitted = FittedParameters.from_fit(fit, reserved=list(ranges))
    measure.require_parameters("fit", fitted.names)
    if sobol and len(fitted.names) > 1:
        raise InputError(
            "sobol",
            must="be False for several fitted parameters",
            got=True,
            why="They depend on each other, so that the variance has no shares of each.",
            fix="Leave it out, or pass independent parameter_ranges.",
        )
    names = [*ranges, *fitted.names]
    uncertain = UncertainArguments(
        [_as_distribution(name, given) for name, given in ranges.items()],
        fitted.estimate,
        fitted.covariance,
    )
    shares = _require_quantiles(quantiles)
    samples = _require_sample_count(samples, shares)
    seed = as_seed(rng)
    generator = np.random.default_rng(seed)
    function = _MeasureEvaluation(measure, names)
    statistics = propagate_distributions(function, uncertain, shares, samples, generator)
    statistics = function.with_measure_errors(statistics)
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
            function.with_index_errors(
                estimate_sobol_indices(function, uncertain, samples, generator), statistics
            ),
            layout,
        )
        coords["field"] = (("field",), np.array(names))
    return build.dataset(
        variables,
        {**coords, **layout.coords},
        measure_provenance([measure], samples=samples, rng=seed)
        | {"uncertain": " ".join(names), "errors": function.describe_errors()},
    )


@dataclass
class _MeasureEvaluation:
    """The measure as a function of points (point, parameter), one row of numbers for each.

    It learns from its first call what is known from a result alone: the layout of the
    measure, and how large its errors are.
    """

    measure: Measure
    parameter_names: Sequence[str]
    _layout: MeasureLayout | None = None
    _errors: FloatArray | None = None

    def __call__(self, points: FloatArray) -> FloatArray:
        columns = dict(zip(self.parameter_names, points.T, strict=True))
        if self._layout is None:
            values, errors = self.measure.at(columns)
            self._layout = MeasureLayout.from_values(values)
            self._errors = errors.values.reshape(len(points), -1)
        else:
            values = self.measure.values_at(columns)
        return values.values.reshape(len(points), -1).astype(np.float64)

    def with_measure_errors(self, statistics: PropagatedStatistics) -> PropagatedStatistics:
        """Statistics with the errors of the measure itself beside those of sampling."""
        known = self._known_errors()
        deviation = np.sqrt((known**2).mean(axis=0))
        return replace(
            statistics,
            quantiles_error=np.hypot(statistics.quantiles_error, known.max(axis=0)),
            average_error=np.hypot(statistics.average_error, known.mean(axis=0)),
            deviation_error=np.hypot(statistics.deviation_error, deviation),
        )

    def with_index_errors(
        self, indices: SobolIndices, statistics: PropagatedStatistics
    ) -> SobolIndices:
        """Indices with what the errors of the measure make of shares of its variance."""
        root_mean_square = np.sqrt((self._known_errors() ** 2).mean(axis=0))
        with np.errstate(all="ignore"):
            share = 2.0 * np.nan_to_num(root_mean_square / statistics.deviation, posinf=1.0)
        return replace(
            indices,
            first_order_error=np.hypot(indices.first_order_error, share),
            total_effect_error=np.hypot(indices.total_effect_error, share),
        )

    def describe_errors(self) -> str:
        """What the errors count, in words."""
        assert self._errors is not None
        if np.isfinite(self._errors).any():
            return "of sampling and of the measure"
        return "of sampling alone: the measure states no error of its own"

    def _known_errors(self) -> FloatArray:
        """Errors of the measure (point, number), 0 where there are none."""
        assert self._errors is not None
        return np.where(np.isfinite(self._errors), self._errors, 0.0)

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


def _require_parameter_ranges(
    parameter_ranges: object, fit: xr.Dataset | None
) -> Mapping[str, Any]:
    if parameter_ranges is None and fit is not None:
        return {}
    if not isinstance(parameter_ranges, Mapping) or not (parameter_ranges or fit is not None):
        raise InputError(
            "parameter_ranges",
            must="name at least one field",
            got=shortened_repr(parameter_ranges),
            why="Something must be uncertain.",
            fix="Pass for example {'temperature': (280, 300)}, or fit=rm.fit(...).",
        )
    return parameter_ranges


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

"""Parameters from measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from remanent._checks import Rule, not_negative_rule, require_flag, require_real
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.inference import fitting
from remanent.analysis.inference.fitting import LeastSquaresFit, Observations, ParameterBox
from remanent.models.drives.base import Drive
from remanent.models.physical_sizes import PHYSICAL_SIZE_RULE, PHYSICAL_SIZES
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.results.read_measurements import MeasurementSource, read_measurements
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_drive,
    require_intervals,
    require_tolerance,
)
from remanent.studies.ensemble.durations import (
    DEFAULT_RESPONSE_DURATION_IN_TAU,
    require_count,
    require_duration,
)
from remanent.studies.ensemble.layout import lay_out_ensemble, numeric_fields
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.inference._measures import as_parameter_values, with_parameters
from remanent.studies.inference._predictions import (
    MeasurementPredictor,
    Measurements,
    ResponseWindow,
)

_CONFIDENCE_RULE = Rule(
    "lie between 0 and 1",
    lambda x: np.asarray((x > 0) & (x < 1)),
    "It is the share of repeated experiments whose interval holds the truth.",
    "Pass 0.95.",
)
_DISCARD_RULE = not_negative_rule("It is the time before the window.", "Pass 0 to start at once.")
#: Scale of a parameter whose guess is smaller.
_SMALLEST_PARAMETER_SCALE = 0.1
#: Distance from an end that a rule excludes, over the parameter's scale.
_RELATIVE_DISTANCE_FROM_OPEN_END = 1e-6
#: Why a fit is incomplete.
_NO_END_REASON = "The least squares came to no end within the evaluations that they have."
#: A number that breaks every rule with an upper end.
_VALUE_BEYOND_UPPER_BOUNDS = 1e6


def fit(
    system: System,
    drive: DriveArgument,
    data: MeasurementSource,
    parameters: Sequence[str] | Mapping[str, float],
    *,
    parameter_ranges: Mapping[str, tuple[float, float]] | None = None,
    initial: ArrayLike | None = None,
    duration: float | None = None,
    periods: int | None = None,
    discard: float = 0.0,
    confidence: float = 0.95,
    profile: bool = False,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Find the parameters with which the model comes nearest to measurements.

    Parameters
    ----------
    system : System
        What was measured, with guesses for what is not known.
    drive : Drive, or mapping of str to Drive
        The load on it.
    data : xarray.Dataset, pandas.DataFrame, mapping or path
        What :func:`remanent.read_measurements` returns or reads: along ``time`` any of the
        variables of :func:`remanent.simulate`, or along ``omega`` an ``amplitude``,
        ``maximum`` or ``minimum`` as of :func:`remanent.frequency_response`;
        ``thickness_stretch_error`` and the like are standard deviations.  Without them all
        values of all variables have the same, and the scatter says how large it is.
    parameters : sequence of str, or mapping of str to float
        Numeric fields of actuator and drive, ``initial.stretch`` and the like, and
        ``shear_modulus``, ``density``, ``remanence`` over their nominal values; with first
        guesses, or just names, from the values there are.
    parameter_ranges : mapping of str to (float, float), optional
        Lowest and highest value of some of the parameters; by default those that the fields
        themselves have.
    initial : array_like (state,), optional
        State at τ = 0: stretch and rate of each coordinate in turn, to which internal variables
        and the temperature may be added; rest, (1, 0), by default.
    duration : float, str or quantity, optional
        Length of the run of a response in τ, 100 by default; with a unit, ``"60 ms"``, where the
        actuator has SI sizes.
    periods : int, optional
        The same in drive periods, in place of `duration`.
    discard : float, str or quantity
        Time at the beginning of the run of a response that does not count, as `duration`.
    confidence : float
        Of the intervals, between 0 and 1.
    profile : bool
        Whether to find ``profile_interval`` too, which takes some dozen further fits.
    tolerance : float
        Bound of the absolute global error of the computed motion.

    Returns
    -------
    xarray.Dataset
        Along ``parameter``: ``estimate``, its standard error ``estimate_error``, its
        ``interval`` by Student's t and, where asked, ``profile_interval``; the ``guess`` it
        started from; ``covariance`` and ``correlation``; ``chi_square`` over the given
        deviations, ``degrees`` of freedom, ``noise``, the deviation of the data over the given
        one (or over 1); along ``observation`` what was ``observed`` and ``predicted``, of which
        ``quantity`` and when or at which ω.  ``status`` is ``incomplete``, with the attribute
        ``reason``, where the search came to no end.

        The attributes ``system`` and ``drive`` are those that fit: :func:`remanent.read_system`
        and :func:`remanent.read_drive` give them back, and ``rm.uncertainty(..., fit=found)``
        takes the estimates with their covariance.

    Raises
    ------
    InputError
        A bad argument; a guess whose motion cannot be computed up to the last datum; data that
        do not tell the parameters apart.

    See Also
    --------
    remanent.read_measurements : Tables of measurements, with units.
    remanent.logarithmic_decrement : Damping from a ring-down, without a model.
    remanent.uncertainty : What errors of parameters make of a prediction.

    Notes
    -----
    A fit is of one record, with one set of starting values, and takes no ``over``: for several
    records, or starts, call it for each.

    Minimises the sum of [(predicted − observed)/deviation]² (SciPy's trust-region reflective
    method); all differences of a step are one ensemble, and a step beyond what the model can
    compute is taken back.  Covariance s²(JᵀWJ)⁻¹.  The minimum
    is the one near the guess: of a ring-down, a guess within half a cycle over the record.

    Examples
    --------
    >>> import numpy as np, remanent as rm
    >>> true = rm.Actuator(dissipation=rm.Rayleigh(0.2))
    >>> run = rm.simulate(true, rm.Constant(0.3), times=np.linspace(0, 10, 60))
    >>> noisy = run[["thickness_stretch"]] + np.random.default_rng(1).normal(0, 0.01, 60)
    >>> guess = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    >>> found = rm.fit(guess, rm.Constant(0.3), noisy, ["dissipation.0.eta"])
    >>> bool(abs(found.estimate[0] - 0.2) < 3 * found.estimate_error[0])
    True
    >>> rm.read_system(found).dissipation[0].eta == float(found.estimate[0])
    True
    """
    tolerance = require_tolerance(tolerance, "the error of the computed motion")
    confidence = require_real("confidence", confidence, _CONFIDENCE_RULE)
    duration = without_unit("duration", duration, "time", system)
    discard = require_real(
        "discard", without_unit("discard", discard, "time", system), _DISCARD_RULE
    )
    profile = require_flag("profile", profile)
    _require_run_length(duration, periods)
    drive = require_drive(drive)
    guess = _parameter_guesses(system, drive, parameters, initial)
    measurements = Measurements(read_measurements(data, system))
    if measurements.dimension_name == "omega" and duration is None and periods is None:
        duration = DEFAULT_RESPONSE_DURATION_IN_TAU
    model = MeasurementPredictor(
        system=system,
        drive=drive,
        parameter_names=tuple(guess),
        initial=initial,
        measurements=measurements,
        response_window=ResponseWindow(duration, periods, discard),
        motion_tolerance=tolerance,
    )
    observed, box = (
        measurements.observations(),
        _parameter_box(system, drive, guess, parameter_ranges),
    )
    best = fitting.fit_least_squares(model, observed, np.array(list(guess.values())), box)
    variables = {
        "guess": (("parameter",), np.array(list(guess.values()))),
        **_fit_variables(best, observed, confidence),
    }
    if profile:
        ends = [
            fitting.profile_likelihood_interval(model, observed, best, box, k, confidence)
            for k in range(len(guess))
        ]
        variables["profile_interval"] = (("parameter", "bound"), np.array(ends))
    found = dict(zip(guess, best.estimate.tolist(), strict=True))
    attributes = provenance.attributes(
        with_parameters(system, found),
        with_parameters(drive, found),
        tolerance,
        confidence=confidence,
        duration=duration,
        periods=periods,
        discard=discard,
    )
    attributes["deviations"] = "given" if observed.has_absolute_deviations else "equal"
    if not best.has_converged:
        attributes["reason"] = _NO_END_REASON
    coords = _fit_coordinates(guess, measurements)
    return build.dataset(variables, coords, attributes, system.variable_texts())


def _require_run_length(duration: float | None, periods: int | None) -> None:
    """Check the length of a response's runs, also where the data are a history."""
    if duration is not None:
        require_duration(duration)
    if periods is not None:
        require_count("periods", periods, "Runs are counted in whole drive periods.")


def _correlation(best: LeastSquaresFit) -> FloatArray:
    """Correlations, NaN where an estimate has no error, as of data that fit exactly."""
    products = np.outer(best.standard_errors, best.standard_errors)
    return np.divide(
        best.covariance, products, out=np.full_like(products, np.nan), where=products > 0.0
    )


def _fit_variables(
    best: LeastSquaresFit, observed: Observations, confidence: float
) -> dict[str, Labelled]:
    """What is told of a fit, by name."""
    half_width = best.two_sided_t_quantile(confidence) * best.standard_errors
    return {
        "estimate": (("parameter",), best.estimate),
        "estimate_error": (("parameter",), best.standard_errors),
        "interval": (
            ("parameter", "bound"),
            best.estimate[:, None] + half_width[:, None] * [-1.0, 1.0],
        ),
        "covariance": (("parameter", "other_parameter"), best.covariance),
        "correlation": (
            ("parameter", "other_parameter"),
            _correlation(best),
        ),
        "chi_square": ((), np.array(best.chi_square)),
        "degrees": ((), np.array(best.degrees_of_freedom)),
        "noise": ((), np.sqrt(best.chi_square / best.degrees_of_freedom)),
        "status": ((), np.array(Status.OK if best.has_converged else Status.INCOMPLETE)),
        "observed": (("observation",), observed.measured_values),
        "predicted": (("observation",), best.predicted_values),
    }


def _fit_coordinates(guess: Mapping[str, float], measurements: Measurements) -> dict[str, Labelled]:
    names = np.array(list(guess))
    return {
        "parameter": (("parameter",), names),
        "other_parameter": (("other_parameter",), names),
        "bound": (("bound",), np.array(["lower", "upper"])),
        **measurements.observation_labels(),
    }


def _parameter_guesses(
    system: System,
    drive: Drive,
    parameters: Sequence[str] | Mapping[str, float],
    initial: ArrayLike | None,
) -> dict[str, float]:
    ens = lay_out_ensemble(system, drive, None, initial)
    start = {
        f"initial.{n}": float(v)
        for n, v in zip(ens.vector_field.state_names, ens.initial_states[0], strict=True)
    }
    nominal = {**numeric_fields(system), **drive.parameter_values(), **start}
    return as_parameter_values(parameters, nominal)


def _parameter_box(
    system: System,
    drive: Drive,
    guess: Mapping[str, float],
    parameter_ranges: object,
) -> ParameterBox:
    """Scales of the parameters, and ranges inside which the rules of the fields hold."""
    ranges = require_intervals(
        "parameter_ranges", parameter_ranges, guess, "`parameters`", "The search stays inside."
    )
    rules = {
        **dict.fromkeys(PHYSICAL_SIZES, PHYSICAL_SIZE_RULE),
        **system.parameter_rules(),
        **drive.parameter_rules(),
    }
    values = np.array(list(guess.values()))
    scale = np.maximum(np.abs(values), _SMALLEST_PARAMETER_SCALE)
    ends = np.array(
        [
            ranges.get(name, _admissible_range(rules.get(name), size))
            for name, size in zip(guess, scale, strict=True)
        ]
    )
    lower, upper = ends.T
    for k, name in enumerate(guess):
        if not lower[k] < upper[k] or not lower[k] <= values[k] <= upper[k]:
            raise InputError(
                "parameter_ranges",
                must=f"lie around the guess of {name}, {values[k]}",
                got=(lower[k], upper[k]),
                why="The search starts there.",
                fix="Pass a guess between the two values.",
            )
    return ParameterBox(scale, lower, upper)


def _admissible_range(rule: Rule | None, scale: float) -> tuple[float, float]:
    """The range in which a rule holds, as far as trying some values tells.

    Rules say what holds, not where: all of them are half lines or the interval from 0 to 1,
    open or closed at 0.  An open end is kept a little away from.
    """
    lower, upper = -np.inf, np.inf
    if rule is not None and not rule.is_satisfied_by(-1.0):
        lower = 0.0 if rule.is_satisfied_by(0.0) else _RELATIVE_DISTANCE_FROM_OPEN_END * scale
    if rule is not None and not rule.is_satisfied_by(_VALUE_BEYOND_UPPER_BOUNDS):
        upper = 1.0
    return lower, upper

"""Fields that put measures where they are wanted."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from remanent._checks import as_float_array, positive_rule, require_real, shortened_repr
from remanent._errors import InputError, InputWarning
from remanent._status import Status
from remanent._typing import FloatArray
from remanent.analysis.inference.fitting import ParameterBox, difference_jacobian
from remanent.results import build
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_intervals
from remanent.studies.inference._measures import (
    as_parameter_values,
    evaluate_measures,
    measure_provenance,
    values_of_measures,
)
from remanent.studies.inference.measure import Measure

_RELATIVE_STEP_RULE = positive_rule(
    "It is the relative change of a field in a difference.", "Pass 1e-3."
)
#: Distances are relative to the target, or to this where the target is smaller.
_SMALLEST_TARGET_SCALE = 1e-3
#: Relative distance from the target up to which it counts as reached, whatever the error.
_REACHED_TOLERANCE = 1e-6
#: Why a design is incomplete.
_MISSED_REASON = (
    "The target is missed by {}: it may be out of reach of these fields, within their ranges or "
    "from this guess."
)
#: Evaluations of the measures in the search, at most, beside those of differences.
_MAX_SEARCH_EVALUATIONS = 60
#: Singular values of the slopes over the largest, below which fields can be exchanged.
_RELATIVE_RANK_TOLERANCE = 1e-8


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
    measures : Measure or sequence of Measure
        What is to be placed, each one number.
    targets : float or sequence of float
        Where, one for each.
    parameters : str, sequence of str, or mapping of str to float
        What may change: names, or names with first guesses.  As many as measures, for an
        answer to the point; fewer come as near as they can, more stay near the guess.
    parameter_ranges : mapping of str to (float, float), optional
        Lowest and highest value of some of the fields.
    step : float
        Relative change of a field in differences.

    Returns
    -------
    xarray.Dataset
        Along ``field``: ``solution``, with ``solution_error``, what the errors of the measures
        and what is left of the distance make of it (NaN where fields can be exchanged for one
        another); along ``measure``: ``target``, ``reached`` and ``reached_error``.  Errors
        are NaN where a measure states none of its own.  ``status`` is ``incomplete``, with the
        attribute ``reason``, where a target is missed by more than the measure's error: the
        solution then comes as near as it can.  The attributes ``system`` and ``drive`` are
        those of the solution: :func:`remanent.read_system` gives them back.

    Raises
    ------
    InputError
        A bad argument, or a guess at which a measure is not known.

    See Also
    --------
    remanent.sensitivity : Derivatives of measures by fields.
    remanent.fit : Fields from measurements.
    remanent.Measure : What a verb computes, as a function of fields.

    Notes
    -----
    Least squares of the relative distances (SciPy's trust-region reflective method); the
    differences of a step are one ensemble, and a step to where a measure is not known is taken
    back.

    Examples
    --------
    >>> import remanent as rm
    >>> switch = rm.Measure(rm.shape_commands, rm.Actuator(), 1.5, of="switch_time")
    >>> ds = rm.design(switch, 1.2, "temperature")
    >>> round(float(ds.solution[0]), 3)  # 293 (1.42388/1.2)^2
    412.529
    """
    measures = _require_measures(measures)
    step = require_real("step", step, _RELATIVE_STEP_RULE)
    guess = _parameter_guesses(measures, parameters)
    problem = _InverseDesignProblem(
        measures,
        _require_targets(targets, measures),
        list(guess),
        _parameter_box(guess, parameter_ranges),
        step,
    )
    solution = problem.solve(np.array(list(guess.values())))
    reached, errors = (
        part[0] for part in evaluate_measures(measures, problem.parameter_names, solution[None])
    )
    missed = problem.missed_measures(reached, errors)
    variables: dict[str, Labelled] = {
        "solution": (("field",), solution),
        "solution_error": (
            ("field",),
            problem.estimate_parameter_errors(solution, reached, errors),
        ),
        "target": (("measure",), problem.targets),
        "reached": (("measure",), reached),
        "reached_error": (("measure",), errors),
        "status": ((), np.array(Status.INCOMPLETE if missed else Status.OK)),
    }
    coords: dict[str, Labelled] = {
        "field": (("field",), np.array(problem.parameter_names)),
        "measure": (("measure",), np.array([repr(measure) for measure in measures])),
    }
    attributes = measure_provenance(
        measures, dict(zip(guess, solution.tolist(), strict=True)), step=step
    )
    if missed:
        attributes["reason"] = _MISSED_REASON.format(", ".join(missed))
    return build.dataset(variables, coords, attributes)


@dataclass(frozen=True)
class _InverseDesignProblem:
    """Least squares of the relative distances of measures from their targets.

    Attributes
    ----------
    measures : sequence of Measure
    targets : array (measure,)
    parameter_names : sequence of str
        Of the fields that change.
    parameter_box : ParameterBox
        Their scales and ranges.
    relative_step : float
        Relative change of a field in differences.
    """

    measures: Sequence[Measure]
    targets: FloatArray
    parameter_names: Sequence[str]
    parameter_box: ParameterBox
    relative_step: float

    @property
    def target_scales(self) -> FloatArray:
        """What distances are relative to, array (measure,)."""
        return np.maximum(np.abs(self.targets), _SMALLEST_TARGET_SCALE)

    def relative_distances(self, candidates: FloatArray) -> FloatArray:
        """Relative distances from the targets, array (candidate, measure)."""
        values = values_of_measures(self.measures, self.parameter_names, candidates)
        if values.shape[1] != len(self.measures):
            raise InputError(
                "measures",
                must="each be one number",
                got=f"{values.shape[1]} numbers of {len(self.measures)} measures",
                why="Each has one target.",
                fix="Give each an `of` that makes it one number.",
            )
        return np.asarray((values - self.targets) / self.target_scales)

    def tried_distances(self, candidates: FloatArray) -> FloatArray:
        """Relative distances, NaN for candidates at which a measure has no number.

        What is odd about a candidate is nobody's input: warnings are kept for the solution.
        """
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", InputWarning)
                return self.relative_distances(candidates)
        except InputError:
            if len(candidates) == 1:
                return np.full((1, len(self.measures)), np.nan)
            return np.concatenate([self.tried_distances(row[None]) for row in candidates])

    def missed_measures(self, reached: FloatArray, errors: FloatArray) -> list[str]:
        """Measures that are farther from their targets than their errors explain."""
        allowed = np.nan_to_num(errors) + _REACHED_TOLERANCE * self.target_scales
        missed = ~(np.abs(reached - self.targets) <= allowed)
        return [
            repr(one) for one, is_missed in zip(self.measures, missed, strict=True) if is_missed
        ]

    def distance_derivatives(self, x: FloatArray) -> FloatArray:
        """Derivatives of the distances at one point, array (measure, field)."""
        slopes = difference_jacobian(
            self.tried_distances, x, self.parameter_box, self.relative_step
        )
        # A field that a measure cannot be followed along is left where it is.
        return np.where(np.isfinite(slopes), slopes, 0.0)

    def solve(self, guess: FloatArray) -> FloatArray:
        """The point nearest to all targets, array (field,)."""
        begin = self.relative_distances(guess[None])
        if not np.isfinite(begin).all():
            raise InputError(
                "parameters",
                must="start where each measure is one known number",
                got=dict(zip(self.parameter_names, guess.tolist(), strict=True)),
                why="The search starts there.",
                fix="Pass other guesses, or an `of` that makes it one number.",
            )

        def residual(x: FloatArray) -> FloatArray:
            return np.asarray(self.tried_distances(x[None])[0])

        with np.errstate(all="ignore"):  # of a measure that stops changing
            optimum = least_squares(
                residual,
                guess,
                jac=self.distance_derivatives,
                bounds=(self.parameter_box.lower_bounds, self.parameter_box.upper_bounds),
                x_scale=self.parameter_box.scales,
                xtol=1e-12,
                ftol=1e-15,
                gtol=None,
                max_nfev=_MAX_SEARCH_EVALUATIONS,
            )
        return np.asarray(optimum.x)

    def estimate_parameter_errors(
        self, solution: FloatArray, reached: FloatArray, errors: FloatArray
    ) -> FloatArray:
        """What errors and distances of the measures make of the fields, array (field,).

        NaN where the fields can be exchanged for one another: the measures then leave a
        direction among them undetermined.
        """
        slopes = self.distance_derivatives(solution) * self.parameter_box.scales
        if np.linalg.matrix_rank(slopes, rtol=_RELATIVE_RANK_TOLERANCE) < len(self.parameter_names):
            return np.full(len(self.parameter_names), np.nan)
        distance = (errors + np.abs(reached - self.targets)) / self.target_scales
        return np.asarray(self.parameter_box.scales * (np.abs(np.linalg.pinv(slopes)) @ distance))


def _require_targets(targets: float | Sequence[float], measures: Sequence[Measure]) -> FloatArray:
    values = np.atleast_1d(
        as_float_array(
            "targets",
            targets,
            what="target values",
            why="Each measure has one.",
            fix="Pass one number per measure.",
            least=1,
            finite=True,
        )
    )
    if values.shape != (len(measures),):
        raise InputError(
            "targets",
            must=f"be a row of {len(measures)} values",
            got=shortened_repr(targets),
            why="Each measure has one.",
            fix="Pass one target per measure.",
        )
    return values


def _parameter_guesses(
    measures: Sequence[Measure], parameters: Mapping[str, float] | Sequence[str] | str
) -> dict[str, float]:
    guess = as_parameter_values(parameters, measures[0].nominal_values())
    for measure in measures:
        measure.require_parameters("parameters", list(guess))
    return guess


def _require_measures(measures: Measure | Sequence[Measure]) -> list[Measure]:
    listed = [measures] if isinstance(measures, Measure) else measures
    if (
        not isinstance(listed, Sequence)
        or not listed
        or not all(isinstance(measure, Measure) for measure in listed)
    ):
        raise InputError(
            "measures",
            must="be an rm.Measure, or several of them",
            got=shortened_repr(measures),
            why="They say what is computed from the fields.",
            fix="Pass for example rm.Measure(rm.shape_commands, actuator, 1.5, of='switch_time').",
        )
    return list(listed)


def _parameter_box(guess: Mapping[str, float], parameter_ranges: object) -> ParameterBox:
    """Scales and ranges of the fields, inside which the guesses lie."""
    ranges = require_intervals(
        "parameter_ranges", parameter_ranges, guess, "`parameters`", "The search stays inside."
    )
    values = np.array(list(guess.values()))
    ends = np.array([ranges.get(name, (-np.inf, np.inf)) for name in guess], dtype=float)
    lower, upper = ends.T
    if not ((lower < upper) & (lower <= values) & (values <= upper)).all():
        raise InputError(
            "parameter_ranges",
            must="lie around the guesses",
            got=dict(ranges),
            why="The search starts there.",
            fix="Pass other guesses or wider ranges.",
        )
    return ParameterBox(np.where(values == 0.0, 1.0, np.abs(values)), lower, upper)

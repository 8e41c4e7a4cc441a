"""Parameters from measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._checks import Rule, not_negative, require_known, require_real
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis import fitting
from remanent.analysis.fitting import Box, Data
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.results.read_measurements import Table, read_measurements
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import durations
from remanent.studies.ensemble.observables import observe
from remanent.studies.ensemble.physical_scales import PHYSICAL, RULE, Physical, physical
from remanent.studies.inference.measure import chosen, listed
from remanent.studies.response.frequency_response import WINDOW

_CONFIDENCE = Rule(
    "lie between 0 and 1",
    lambda x: np.asarray((x > 0) & (x < 1)),
    "It is the share of repeated experiments whose interval holds the truth.",
    "Pass 0.95.",
)
_DISCARD = not_negative("It is the time before the window.", "Pass 0 to start at once.")
#: Of a response, what is compared.
_EXTREMES = ("amplitude", "maximum", "minimum")


def fit(
    system: Actuator,
    drive: Drive,
    data: Table,
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
    system, drive
        What was measured, with guesses for what is not known.
    data
        What :func:`remanent.read_measurements` returns or reads: along ``time`` any of the
        variables of :func:`remanent.simulate`, or along ``omega`` an ``amplitude``,
        ``maximum`` or ``minimum`` as of :func:`remanent.frequency_response`;
        ``thickness_stretch_error`` and the like are standard deviations.  Without them all
        values of all variables have the same, and the scatter says how large it is.
    parameters
        Numeric fields of actuator and drive, ``initial.stretch`` and the like, and
        ``shear_modulus``, ``density``, ``remanence`` over their nominal values; with first
        guesses, or just names, from the values there are.
    parameter_ranges
        Of parameters; by default those that the fields themselves have.
    initial
        As for :func:`remanent.simulate`.
    duration, periods, discard
        Of a response, as for :func:`remanent.frequency_response`.
    confidence
        Of the intervals.
    profile
        Whether to find ``profile_interval`` too, which takes some dozen further fits.
    tolerance
        Asked of the computed motion.

    Returns
    -------
    xarray.Dataset
        Along ``parameter``: ``estimate``, its standard error ``estimate_error``, its
        ``interval`` by Student's t and, where asked, ``profile_interval``;
        ``correlation``; ``chi_square`` over the given deviations, ``degrees`` of freedom,
        ``noise``, the deviation of the data over the given one (or over 1); along
        ``observation`` what was ``observed`` and ``predicted``, of which ``quantity`` and
        when or at which ω.

    Raises
    ------
    InputError
        A bad argument; a guess whose motion cannot be computed up to the last datum; data that
        do not tell the parameters apart.

    Notes
    -----
    Minimises the sum of [(predicted − observed)/deviation]² (SciPy's trust-region reflective
    method); all differences of a step are one ensemble.  Covariance s²(JᵀWJ)⁻¹.  The minimum
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
    """
    require_tolerance(tolerance)
    confidence = require_real("confidence", confidence, _CONFIDENCE)
    discard = require_real("discard", discard, _DISCARD)
    guess = _guesses(system, drive, parameters, initial)
    table = read_measurements(data, system)
    if "omega" in table.dims and duration is None and periods is None:
        duration = WINDOW
    model = _Model(
        system, drive, tuple(guess), initial, table, duration, periods, discard, tolerance
    )
    found_data, box = model.data(), _box(system, drive, guess, parameter_ranges)
    start = np.array(list(guess.values()))
    found = fitting.fit(model, found_data, start, box)
    half = found.quantile(confidence) * found.deviation
    variables: dict[str, Labelled] = {
        "estimate": (("parameter",), found.estimate),
        "estimate_error": (("parameter",), found.deviation),
        "interval": (("parameter", "bound"), found.estimate[:, None] + half[:, None] * [-1.0, 1.0]),
        "correlation": (
            ("parameter", "other_parameter"),
            found.covariance / np.outer(found.deviation, found.deviation),
        ),
        "chi_square": ((), np.array(found.chi_square)),
        "degrees": ((), np.array(found.degrees)),
        "noise": ((), np.sqrt(found.chi_square / found.degrees)),
        "observed": (("observation",), found_data.values),
        "predicted": (("observation",), found.predicted),
    }
    if profile:
        ends = [
            fitting.profile(model, found_data, found, box, k, confidence) for k in range(len(guess))
        ]
        variables["profile_interval"] = (("parameter", "bound"), np.array(ends))
    names = np.array(list(guess))
    coords: dict[str, Labelled] = {
        "parameter": (("parameter",), names),
        "other_parameter": (("other_parameter",), names),
        "bound": (("bound",), np.array(["lower", "upper"])),
        **model.labels(),
    }
    attributes = provenance.attributes(
        system, drive, tolerance, over=guess, confidence=confidence, duration=duration,
        periods=periods, scaled=False,
    )  # fmt: skip
    return build.dataset(variables, coords, attributes)


@dataclass(frozen=True)
class _Model:
    """Predictions of the measured values, for many candidates at once."""

    actuator: Actuator
    drive: Drive
    names: tuple[str, ...]
    initial: ArrayLike | None
    table: xr.Dataset
    duration: float | None
    periods: int | None
    discard: float
    tolerance: float

    @property
    def along(self) -> str:
        return "omega" if "omega" in self.table.dims else "time"

    @property
    def measured(self) -> list[str]:
        """Names of the variables that are compared."""
        names = [str(n) for n in self.table.data_vars if self.table[n].dims == (self.along,)]
        evidence = {"crossings", "balance", "status", "horizon", "error"}
        return [n for n in names if not n.endswith("_error") and n not in evidence]

    def data(self) -> Data:
        """The measured values, one variable after the other."""
        if self.along not in self.table.dims or not self.measured:
            raise InputError(
                "data", "hold variables along `time` or `omega`", list(self.table.sizes),
                "They are compared with a history or a response.", "Use rm.read_measurements(...).",
            )  # fmt: skip
        values = np.concatenate([self.table[name].values for name in self.measured])
        given = [f"{name}_error" in self.table for name in self.measured]
        deviation = np.ones(values.size)
        if all(given):
            deviation = np.concatenate(
                [np.broadcast_to(self.table[f"{n}_error"], self._size) for n in self.measured]
            )
        if not (np.isfinite(values).all() and (deviation > 0.0).all()):
            raise InputError(
                "data", "be finite, with deviations above 0", "others",
                "Each value counts by its deviation.", "Leave such rows out.",
            )  # fmt: skip
        return Data(values, deviation, all(given))

    def labels(self) -> dict[str, Labelled]:
        """What each datum is, and where."""
        where = np.tile(self.table[self.along].values, len(self.measured))
        quantity = np.repeat(self.measured, self._size)
        return {"quantity": (("observation",), quantity), self.along: (("observation",), where)}

    @property
    def _size(self) -> int:
        return int(self.table.sizes[self.along])

    def __call__(self, candidates: FloatArray) -> FloatArray:
        """Predictions (candidate, datum); NaN where the bound is not met."""
        over = {
            name: xr.DataArray(column, dims="candidate")
            for name, column in zip(self.names, candidates.T, strict=True)
        }
        found = self._history(over) if self.along == "time" else self._response(over)
        return np.concatenate([found[name] for name in self.measured], axis=1)

    def _history(self, over: Mapping[str, xr.DataArray]) -> dict[str, FloatArray]:
        many = physical(self.actuator, self.drive, over, self.initial)
        times = self.table["time"].values
        end = max(float(times[-1]), np.finfo(float).tiny)
        asked = many.problem(np.full(many.ensemble.count, end))
        own = times * many.time[:, None]
        outcome = integrate(asked, Request(times=own), tolerance=self.tolerance)
        states = outcome.states
        assert states is not None
        states[own > outcome.horizon[:, None] * (1 + 1e-12)] = np.nan
        return {
            name: _column(asked, name, own, states) / many.factor(name)[:, None]
            for name in self.measured
        }

    def _response(self, over: Mapping[str, xr.DataArray]) -> dict[str, FloatArray]:
        omega = xr.DataArray(self.table["omega"].values, dims="frequency")
        many = physical(self.actuator, self.drive, {**over, "omega": omega}, self.initial)
        outcome = self._extremes(many)
        low, high = (many.ensemble.shaped(v) for v in (outcome.minimum, outcome.maximum))
        return {"maximum": high, "minimum": low, "amplitude": 0.5 * (high - low)}

    def _extremes(self, many: Physical) -> Outcome:
        ens = many.ensemble
        if self.periods is not None:
            asked = many.problem(durations(ens, None, self.periods) / many.time)
        else:
            asked = many.problem(durations(ens, self.duration, None))
        request = Request(extremes=True, begin=self.discard * many.time)
        return integrate(asked, request, tolerance=self.tolerance)


def _column(asked: Problem, name: str, times: FloatArray, states: FloatArray) -> FloatArray:
    """A state variable or an observable, array (trajectory, time)."""
    if name in asked.field.state:
        return states[:, :, asked.field.state.index(name)]
    if name not in asked.field.observables:
        known = [*asked.field.state, *asked.field.observables]
        raise InputError(
            "data", f"hold variables among {', '.join(known)}", name,
            "They are what a history has.",
            "Name the columns so, by rm.read_measurements(names=...).",
        )  # fmt: skip
    return observe(asked, name, times, states)


def _guesses(
    actuator: Actuator,
    drive: Drive,
    parameters: Sequence[str] | Mapping[str, float],
    initial: ArrayLike | None,
) -> dict[str, float]:
    ens = physical(actuator, drive, None, initial).ensemble
    start = {f"initial.{n}": float(v) for n, v in zip(ens.field.state, ens.initial[0], strict=True)}
    own = {**actuator.parameters(), **drive.parameters(), **start, **dict.fromkeys(PHYSICAL, 1.0)}
    require_known(listed(parameters), own, "the actuator or the drive, or a physical size")
    guess = chosen(parameters, own)
    if not guess:
        raise InputError(
            "parameters", "name at least one field", parameters,
            "There is nothing to find.", f"Pass some of {', '.join(own)}.",
        )  # fmt: skip
    return guess


def _box(
    actuator: Actuator,
    drive: Drive,
    guess: Mapping[str, float],
    bounds: Mapping[str, tuple[float, float]] | None,
) -> Box:
    """Scales, and bounds inside which the rules of the fields hold."""
    require_known(bounds or {}, guess, "`parameters`")
    rules = {**actuator.parameter_rules(), **drive.numeric_rules(), **dict.fromkeys(PHYSICAL, RULE)}
    value = np.array(list(guess.values()))
    scale = np.maximum(np.abs(value), 0.1)
    lower, upper = np.full_like(value, -np.inf), np.full_like(value, np.inf)
    for k, name in enumerate(guess):
        rule = rules.get(name)
        if rule is not None and not rule.satisfied(-1.0):
            lower[k] = 0.0 if rule.satisfied(0.0) else 1e-6 * scale[k]
        if rule is not None and not rule.satisfied(1e6):
            upper[k] = 1.0
        lower[k], upper[k] = (bounds or {}).get(name, (lower[k], upper[k]))
        if not lower[k] < upper[k] or not lower[k] <= value[k] <= upper[k]:
            raise InputError(
                "bounds", f"lie around the guess of {name}, {value[k]}", (lower[k], upper[k]),
                "The search starts there.", "Pass a guess between the bounds.",
            )  # fmt: skip
    return Box(scale, lower, upper)

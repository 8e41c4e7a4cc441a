"""Damping from a ring-down."""

from __future__ import annotations

import math
from collections.abc import Hashable

import numpy as np
import xarray as xr

from remanent._checks import Rule, as_float_array, require_real, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.inference.ringdown import DecayFit, fit_exponential_decay
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.results.checks import require_dataset

_SMALLEST_SWING_RULE = Rule(
    "lie between 0 and 1",
    lambda x: np.asarray((x >= 0) & (x < 1)),
    "Smaller swings, lost in noise, are left out.",
    "Pass 0.05 for a noisy record, 0 for a computed one.",
)
#: Why a motion has no decrement.
_FEW_SWINGS_REASON = (
    "fewer than three swings stand out: pass a longer or finer record, or a smaller `smallest`"
)
#: Variables of the result.
_RESULT_VARIABLE_NAMES = (
    "decrement",
    "decrement_error",
    "frequency",
    "frequency_error",
    "damping_ratio",
    "damping_ratio_error",
)


def logarithmic_decrement(
    history: xr.Dataset, variable: str = "thickness_stretch", *, smallest: float = 0.02
) -> xr.Dataset:
    """Measure how free oscillations decay.

    Parameters
    ----------
    history : xarray.Dataset
        Of a ring-down: `variable` along ``time``, or along ``cycle`` with times of its own,
        as from :func:`remanent.simulate` or :func:`remanent.read_measurements`.
    variable : str
        What oscillates.
    smallest : float
        Swings below this share of the largest, and what follows them, do not count.

    Returns
    -------
    xarray.Dataset
        For every motion: ``decrement`` δ, the fall of the logarithm of the amplitude per cycle;
        ``frequency``; ``damping_ratio`` ζ = δ/√(4π² + δ²); each with its standard error, by the
        noise of the record or, where it has none, about a straight line, which is all there is
        to say where the decay is exponential.  NaN with fewer than three swings, as ``reason``
        says.

    Raises
    ------
    InputError
        No such variable, or no time.

    See Also
    --------
    remanent.fit : Parameters of the model from the whole record.

    Notes
    -----
    A swing is the distance of successive turning points of a cubic spline through the record;
    the logarithms of swings fall by δ/2 each.  A record with noise is smoothed first, by a
    spline with eight knots in each cycle, and the heights of its turning points are fitted by
    c + (−1)ᵏ a exp(−kδ/2) with the errors that the noise gives them.  Where oscillations are
    large or the damping is not viscous they do not fall on a line: fit the model instead.

    Examples
    --------
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    >>> run = rm.simulate(damped, rm.Constant(0.0), duration=20, initial=(1.001, 0))
    >>> float(rm.logarithmic_decrement(run).decrement.round(4))
    0.1283
    """
    smallest = require_real("smallest", smallest, _SMALLEST_SWING_RULE)
    require_dataset("history", history)
    if "scales_applied" in history.attrs:
        raise InputError(
            "history",
            must="be dimensionless",
            got="a Dataset in SI",
            why="Its times would give frequencies in another unit.",
            fix="Call rm.to_si on the result instead.",
        )
    axis = _time_dimension(history, variable)
    values, time = xr.broadcast(
        _of_numbers(history, variable, gaps=True), _of_numbers(history, "time", gaps=False)
    )
    motion_dims = [d for d in values.dims if d != axis]
    values, time = (array.transpose(*motion_dims, axis) for array in (values, time))
    rows = [
        _decay_statistics(fit_exponential_decay(*_known_in_order(t, x), prominence=smallest))
        for t, x in zip(_flatten_to_rows(time), _flatten_to_rows(values), strict=True)
    ]
    shape = tuple(values.sizes[d] for d in motion_dims)
    dims = tuple(map(str, motion_dims))
    columns = np.reshape(rows, (len(rows), len(_RESULT_VARIABLE_NAMES))).T
    reasons = np.where(np.isnan(columns[0]), _FEW_SWINGS_REASON, "")
    variables: dict[str, Labelled] = {
        name: (dims, np.reshape(column, shape))
        for name, column in zip(
            (*_RESULT_VARIABLE_NAMES, "reason"), (*columns, reasons), strict=True
        )
    }
    coords: dict[str, Labelled] = {
        str(d): ((str(d),), history[d].values) for d in motion_dims if d in history.coords
    }
    kept = {*provenance.ORIGIN_ATTRIBUTE_NAMES, "scales"}
    attributes = {k: v for k, v in history.attrs.items() if k in kept}
    return build.dataset(variables, coords, attributes)


def _time_dimension(history: xr.Dataset, variable: str) -> Hashable:
    """``time``, or ``cycle`` where every motion has times of its own."""
    dims = [d for d in ("time", "cycle") if d in history.dims]
    if dims and (not isinstance(variable, str) or variable not in history):
        raise InputError(
            "variable",
            must="be a variable of `history`",
            got=shortened_repr(variable),
            why="Its decay is measured.",
            fix=f"Pass one of {', '.join(map(str, history.data_vars)) or 'those it has'}.",
        )
    if (
        not isinstance(variable, str)
        or variable not in history
        or "time" not in history.variables
        or not dims
    ):
        raise InputError(
            "history",
            must=f"have {variable} along `time`",
            got=list(history.variables),
            why="A decay is seen in time.",
            fix="Pass the result of rm.simulate.",
        )
    return dims[0]


def _of_numbers(history: xr.Dataset, name: str, *, gaps: bool) -> xr.DataArray:
    """A variable of the history, as floats."""
    array = history[name]
    numbers = as_float_array(
        f"history[{name!r}]", array, what="values in time", why="A decay is seen in numbers.",
        fix="Pass the result of rm.simulate, or of rm.read_measurements.", gaps=gaps,
    )  # fmt: skip
    return array.copy(data=numbers)


def _flatten_to_rows(array: xr.DataArray) -> FloatArray:
    return np.reshape(array.values, (math.prod(array.shape[:-1]), array.shape[-1]))


def _known_in_order(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Known values of one motion with their times, which increase."""
    known = np.flatnonzero(np.isfinite(values))
    known = known[np.argsort(time[known], kind="stable")]
    if not (np.diff(time[known]) > 0.0).all():
        raise InputError(
            "history['time']",
            must="hold every instant of a motion once",
            got="some that are equal or unknown",
            why="A decay is seen in values one after another.",
            fix="Drop the others first: history.drop_duplicates('time').",
        )
    return time[known], values[known]


def _decay_statistics(ring_down: DecayFit | None) -> list[float]:
    """The variables of one motion, in the order of their names; NaN where it has no decay."""
    if ring_down is None:
        return [np.nan] * len(_RESULT_VARIABLE_NAMES)
    delta, delta_error = ring_down.logarithmic_decrement, ring_down.logarithmic_decrement_error
    size = np.hypot(2.0 * np.pi, delta)
    slope = 4.0 * np.pi**2 / size**3  # of delta/sqrt(4 pi^2 + delta^2)
    return [
        delta,
        delta_error,
        ring_down.angular_frequency,
        ring_down.angular_frequency_error,
        delta / size,
        slope * delta_error,
    ]

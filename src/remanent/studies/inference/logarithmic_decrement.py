"""Damping from a ring-down."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
import xarray as xr

from remanent._checks import Rule, require_real
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.ringdown import Decay, decay
from remanent.results import build, provenance

_SHARE = Rule(
    "lie between 0 and 1",
    lambda x: np.asarray((x >= 0) & (x < 1)),
    "Smaller swings, lost in noise, are left out.",
    "Pass 0.05 for a noisy record, 0 for a computed one.",
)
_NAMES = ("decrement", "decrement_error", "frequency", "frequency_error", "damping_ratio",
          "damping_ratio_error")  # fmt: skip


def logarithmic_decrement(
    history: xr.Dataset, variable: str = "thickness_stretch", *, smallest: float = 0.02
) -> xr.Dataset:
    """Measure how free oscillations decay.

    Parameters
    ----------
    history
        Of a ring-down: `variable` along ``time``, or along ``cycle`` with times of its own,
        as from :func:`remanent.simulate` or :func:`remanent.read_measurements`.
    variable
        What oscillates.
    smallest
        Swings below this share of the largest, and what follows them, do not count.

    Returns
    -------
    xarray.Dataset
        For every motion: ``decrement`` δ, the fall of the logarithm of the amplitude per cycle;
        ``frequency``; ``damping_ratio`` ζ = δ/√(4π² + δ²); each with its standard error about
        a straight line, which is all there is to say where the decay is exponential.  NaN
        with fewer than three swings.

    Raises
    ------
    InputError
        No such variable, or no time.

    Notes
    -----
    Swings, distances of successive turning points of a cubic spline, through the
    record; their logarithms fall by δ/2 each.  Where oscillations are large or the damping is
    not viscous they do not fall on a line: fit the model instead.

    Examples
    --------
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    >>> run = rm.simulate(damped, rm.Constant(0.0), duration=20, initial=(1.001, 0))
    >>> float(rm.logarithmic_decrement(run).decrement.round(4))
    0.1283
    """
    smallest = require_real("smallest", smallest, _SHARE)
    along = [d for d in ("time", "cycle") if d in history.dims]
    if variable not in history or "time" not in history.variables or not along:
        raise InputError(
            "history", f"have {variable} along `time`", list(history.variables),
            "A decay is seen in time.", "Pass the result of rm.simulate.",
        )  # fmt: skip
    values, time = xr.broadcast(history[variable], history["time"])
    axis: Hashable = along[0]
    others = [d for d in values.dims if d != axis]
    values, time = (array.transpose(*others, axis) for array in (values, time))
    rows = [
        _numbers(decay(t[np.isfinite(x)], x[np.isfinite(x)], prominence=smallest))
        for t, x in zip(_rows(time), _rows(values), strict=True)
    ]
    shape = tuple(values.sizes[d] for d in others)
    dims = tuple(map(str, others))
    found = {
        n: (dims, np.reshape(v, shape)) for n, v in zip(_NAMES, np.transpose(rows), strict=True)
    }
    coords = {str(d): ((str(d),), history[d].values) for d in others if d in history.coords}
    keep = {k: v for k, v in history.attrs.items() if k in provenance.ORIGIN}
    return build.dataset(found, coords, keep)


def _rows(array: xr.DataArray) -> FloatArray:
    return np.reshape(array.values, (-1, array.shape[-1]))


def _numbers(found: Decay | None) -> list[float]:
    if found is None:
        return [np.nan] * len(_NAMES)
    delta, size = found.decrement, np.hypot(2.0 * np.pi, found.decrement)
    slope = 4.0 * np.pi**2 / size**3  # of delta/sqrt(4 pi^2 + delta^2)
    ratio = [delta / size, slope * found.decrement_error]
    return [delta, found.decrement_error, found.frequency, found.frequency_error, *ratio]

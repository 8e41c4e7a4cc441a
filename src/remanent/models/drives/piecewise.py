"""Loads given by tables: steps, ramps, sampled signals.  All are piecewise cubic."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np

from remanent import _checks
from remanent._errors import InputError, warn_of_input
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.models.drives.base import Drive, as_times, empty_waveforms

#: What a table may be given as; it is kept as a tuple of floats.
Numbers: TypeAlias = Sequence[float] | FloatArray


#: Share of the last time of a table by which a run may be longer: rounding in a sum of steps.
_RELATIVE_END_ROUNDING = 1e-9
#: A spline that leaves the range of its samples by more than this many times it swings.
_LARGEST_OVERSHOOT = 1.0
#: Places between two samples at which a spline is looked at.
_PLACES_BETWEEN_SAMPLES = np.array([0.25, 0.5, 0.75])


@dataclass(frozen=True)
class PiecewiseDrive(Drive):
    """A load that is a cubic polynomial between consecutive times.

    Parameters
    ----------
    times
        Instants in tau, the first of them 0, each greater than the one before.
    loads
        Magnetic loads, one for each instant.
    """

    times: Numbers
    loads: Numbers

    piece_parameter_names: ClassVar[tuple[str, ...]] = tuple(f"piece.{i}" for i in range(4))
    #: Least number of entries.
    min_entries: ClassVar[int] = 1
    #: Whether the last load is held for ever; otherwise runs must end with the table.
    holds_last_load: ClassVar[bool] = True

    def checked_fields(self) -> Mapping[str, Any]:
        """Both tables as tuples of floats, if they fit together."""
        times = _checks.require_increasing(
            "times", self.times, what="instants", why="They say from when each load acts."
        )
        loads = _checks.require_numbers(
            "loads", self.loads, what="magnetic loads", why="There is one for each instant."
        )
        if times[0] != 0.0:
            raise InputError(
                "times",
                must="start at 0",
                got=float(times[0]),
                why="Motion starts at tau = 0.",
                fix="Shift the times.",
            )
        if len(times) < self.min_entries:
            raise InputError(
                "times",
                must=f"have at least {self.min_entries} entries",
                got=len(times),
                why="A signal is interpolated between samples.",
                fix="Add entries; a load that does not change is rm.Constant.",
            )
        if len(loads) != len(times):
            raise InputError(
                "loads",
                must=f"have as many entries as `times`, {len(times)}",
                got=len(loads),
                why="Each instant has one load.",
                fix="Pass one load per instant.",
            )
        return {"times": tuple(times.tolist()), "loads": tuple(loads.tolist())}

    def __post_init__(self) -> None:
        super().__post_init__()
        with np.errstate(all="ignore"):
            try:
                coefficients = self.piece_coefficients()
            except ValueError:  # from the interpolation of samples
                coefficients = np.full((4, 1), np.nan)
        if not np.isfinite(coefficients).all():
            raise InputError(
                "loads",
                must="change at rates that floating point holds",
                got=_checks.shortened_repr(self),
                why="Between two instants the load is a polynomial in time.",
                fix="Use loads and times of ordinary size.",
            )
        self._warn_if_implausible(coefficients)

    def _warn_if_implausible(self, coefficients: FloatArray) -> None:
        """Warn of a table that looks like a mistake, by its :meth:`piece_coefficients`."""

    @property
    def last_change(self) -> float:
        """The last instant, or that before it where the last load is not held."""
        return float(self.times[-1 if self.holds_last_load else -2])

    @property
    def known_until(self) -> float:
        """The last instant where the last load is not held."""
        return np.inf if self.holds_last_load else float(self.times[-1])

    @abstractmethod
    def piece_coefficients(self) -> FloatArray:
        """Ascending coefficients in tau - times[i], an array (4, piece).

        The last piece starts at the last time and lasts for ever.
        """

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """The load at times `tau`."""
        time = self._require_covered("tau", as_times(tau))
        piece = np.maximum(np.searchsorted(self.times, time, side="right") - 1, 0)
        a0, a1, a2, a3 = self.piece_coefficients()[:, piece]
        s = time - np.asarray(self.times)[piece]
        return np.asarray(a0 + s * (a1 + s * (a2 + s * a3)))

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """a0 + s (a1 + s (a2 + s a3)), s the fraction of the piece."""
        a0, a1, a2, a3 = (p[name] for name in self.piece_parameter_names)
        return a0 + phase * (a1 + phase * (a2 + phase * a3))

    def piece_parameters_in_time(self, p: Mapping[str, Any], tau: Any) -> Mapping[str, Any]:
        """The coefficients of the first piece, which begins at 0."""
        first = self.piece_coefficients()[:, 0]
        return {
            name: coefficient * tau**k
            for k, (name, coefficient) in enumerate(
                zip(self.piece_parameter_names, first, strict=True)
            )
        }

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One piece from each time to the next; the last ends with the trajectory."""
        ends = self._require_covered(
            "duration", np.atleast_1d(np.asarray(duration, dtype=np.float64))
        )
        starts = np.asarray(self.times)[:, np.newaxis]
        following = np.append(self.times[1:], np.inf)[:, np.newaxis]
        lengths = np.maximum(np.minimum(following, ends) - starts, 0.0)
        begun = np.any(lengths > 0.0, axis=1)
        begun[0] = True  # a run of no length still has a piece
        lengths = lengths[begun]
        scaled = {
            name: row[begun, np.newaxis] * lengths**k
            for k, (name, row) in enumerate(
                zip(self.piece_parameter_names, self.piece_coefficients(), strict=True)
            )
        }
        return LoadSchedule(
            lengths, periodic=False, piece_parameters=scaled, waveforms_at_phase=empty_waveforms
        )

    def _require_covered(self, name: str, times: FloatArray) -> FloatArray:
        """`times` themselves, if the table defines the load at all of them."""
        if np.any(times < 0.0):
            raise InputError(
                name,
                must="not lie before 0",
                got=float(np.min(times)),
                why="The table begins at 0, as motion does.",
                fix="Pass times from 0 on.",
            )
        # Times that were summed up may end a little before their last multiple.
        last = self.times[-1] * (1.0 + _RELATIVE_END_ROUNDING)
        if not self.holds_last_load and np.any(times > last):
            raise InputError(
                name,
                must=f"not go beyond the last entry of `times`, {self.times[-1]}",
                got=float(np.max(times)),
                why="The load is unknown after it.",
                fix="Shorten the run or add entries.",
            )
        return times


@dataclass(frozen=True)
class Steps(PiecewiseDrive):
    """A load that jumps from one value to the next.

    Each load holds from its time until the next; the last is held for ever.

    Parameters
    ----------
    times : sequence of float (time,)
        When each load begins, in units of tau, increasing, the first 0.
    loads : sequence of float (time,)
        The load from each time on, dimensionless.

    Raises
    ------
    InputError
        Times that do not increase or do not begin at 0, or numbers that are not finite.

    See Also
    --------
    Ramp : The same, joined by straight lines.
    shape_command : Steps that leave no vibration.

    Examples
    --------
    >>> Steps([0.0, 2.0], [0.16, 0.3])([1.0, 2.0]).tolist()
    [0.16, 0.3]
    """

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls([0.0, 1.5, 4.0], [0.1, -0.2, 0.3])

    def piece_coefficients(self) -> FloatArray:
        """The load itself, in each piece."""
        return np.vstack([self.loads, np.zeros((3, len(self.loads)))])


@dataclass(frozen=True)
class Ramp(PiecewiseDrive):
    """A load that goes straight from one value to the next.

    The last load is held for ever.  For jumps use :class:`Steps`.

    Parameters
    ----------
    times : sequence of float (time,)
        Times of the corners, in units of tau, increasing, the first 0.
    loads : sequence of float (time,)
        The load at each time, dimensionless.

    Raises
    ------
    InputError
        Times that do not increase or do not begin at 0, or numbers that are not finite.

    See Also
    --------
    Steps : The same with jumps.
    Sampled : The same, joined by a smooth curve.

    Examples
    --------
    >>> Ramp([0.0, 2.0], [0.0, 0.3])([1.0, 5.0]).tolist()
    [0.15, 0.3]
    """

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls([0.0, 2.0, 3.0], [0.1, 0.4, -0.3])

    def piece_coefficients(self) -> FloatArray:
        """The load at the start of each piece and its slope."""
        slopes = np.append(np.diff(self.loads) / np.diff(self.times), 0.0)
        return np.vstack([self.loads, slopes, np.zeros((2, len(self.loads)))])


@dataclass(frozen=True)
class Sampled(PiecewiseDrive):
    """A sampled signal, interpolated by the cubic spline with not-a-knot ends.

    Runs that go on beyond the last sample are refused.  The load has kinks of third
    order at the samples only.  A spline swings where samples jump between times that are much
    closer than others: if it leaves their range by more than that range, there is a warning.

    Parameters
    ----------
    times : sequence of float (time,)
        Times of the samples, at least four, in units of tau, increasing, the first 0.
    loads : sequence of float (time,)
        The load at each time, dimensionless.

    Raises
    ------
    InputError
        Times that do not increase or do not begin at 0, or numbers that are not finite.

    See Also
    --------
    Ramp : The same, joined by straight lines.
    read_measurements : Reads a measured signal.

    Examples
    --------
    >>> round(float(Sampled([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 8.0, 27.0])(1.5)), 12)
    3.375
    """

    min_entries: ClassVar[int] = 2
    holds_last_load: ClassVar[bool] = False

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(np.linspace(0.0, 10.0, 9), np.sin(np.arange(9.0)))

    def _warn_if_implausible(self, coefficients: FloatArray) -> None:
        """Warn where the spline goes far beyond the samples."""
        times, loads = np.asarray(self.times), np.asarray(self.loads)
        with np.errstate(all="ignore"):
            s = _PLACES_BETWEEN_SAMPLES[:, None] * np.diff(times)
            a0, a1, a2, a3 = coefficients[:, :-1]
            between = a0 + s * (a1 + s * (a2 + s * a3))
            span = float(np.ptp(loads))
            beyond = max(float(loads.min() - between.min()), float(between.max() - loads.max()))
        if span > 0.0 and beyond > _LARGEST_OVERSHOOT * span:
            warn_of_input(
                f"The spline through `loads` goes {beyond:.3g} beyond them, between samples that "
                "jump within a time that is much shorter than others. Use Ramp or Steps for "
                "jumps, or sample evenly."
            )

    def piece_coefficients(self) -> FloatArray:
        """Coefficients of the spline; the last piece, for rounding at the end, is constant."""
        # In units of a power of 2, which is exact: three samples are solved for by equations that
        # mix times with 1.
        _, exponent = np.frexp(self.times[-1])
        times = np.ldexp(self.times, -exponent)
        spline = import_module("scipy.interpolate").CubicSpline(times, self.loads)
        with np.errstate(over="ignore", under="ignore"):
            coefficients = np.ldexp(spline.c[::-1], -exponent * np.arange(4)[:, np.newaxis])
        last = np.array([[self.loads[-1]], [0.0], [0.0], [0.0]])
        return np.hstack([coefficients, last])

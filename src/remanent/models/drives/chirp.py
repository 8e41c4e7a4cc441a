"""A load whose frequency is swept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np

from remanent import _checks
from remanent._checks import Rule
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.models.drives.base import Drive, as_times, empty_waveforms
from remanent.models.drives.waves import LOAD_RULE, PHASE_RULE

#: The rule of the frequencies at both ends of the sweep.
_SWEEP_FREQUENCY_RULE = _checks.not_negative_rule(
    "It is an angular frequency at one end of the sweep.", "Pass 0 or more."
)


@dataclass(frozen=True)
class Chirp(Drive):
    """A sine whose angular frequency goes linearly from start to stop.

    Equation: m(tau) = mean + m sin(angle), angle = phase + start tau +
    (stop - start) tau^2/(2 duration) up to tau = duration; from then on the frequency
    stays at stop.  The load has no period.

    Parameters
    ----------
    m : float
        Amplitude of the load.
    start, stop : float
        Angular frequencies at tau = 0 and from tau = duration.
    duration : float
        Length of the sweep in tau.
    mean : float
        Mean load.
    phase : float
        Angle at tau = 0, in radians.

    Raises
    ------
    InputError
        A value that breaks the rule of its field, such as a frequency that is not positive.

    See Also
    --------
    Sine : A load of one frequency.
    frequency_response : One run for each frequency instead.

    Examples
    --------
    >>> chirp = Chirp(0.16, 0.5, 2.0, duration=100.0)
    >>> float(chirp(0.0)), chirp.period is None
    (0.0, True)
    """

    m: float
    start: float
    stop: float
    duration: float
    mean: float = 0.0
    phase: float = 0.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "m": LOAD_RULE,
            "start": _SWEEP_FREQUENCY_RULE,
            "stop": _SWEEP_FREQUENCY_RULE,
            "duration": _checks.positive_rule(
                "It is how long the sweep takes.",
                "Pass a time above 0; a load of one frequency is rm.Sine.",
            ),
            "mean": LOAD_RULE,
            "phase": PHASE_RULE,
        }
    )
    piece_parameter_names: ClassVar[tuple[str, ...]] = ("piece.0", "piece.1", "piece.2")

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.2, 1.0, 3.0, 5.0, mean=0.1, phase=0.4)

    @property
    def last_change(self) -> float:
        """The end of the sweep."""
        return self.duration

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """m(tau) = mean + m sin(angle(tau))."""
        time = as_times(tau)
        swept = np.minimum(time, self.duration)
        curvature = (self.stop - self.start) / (2.0 * self.duration)
        angle = self.phase + self.start * swept + curvature * swept**2
        angle = angle + self.stop * (time - swept)
        return np.asarray(self.mean + self.m * np.sin(angle))

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """mean + m sin(a0 + s (a1 + s a2)), s the fraction of the piece."""
        angle = p["piece.0"] + phase * (p["piece.1"] + phase * p["piece.2"])
        return p["mean"] + p["m"] * fn.sin(angle)

    def piece_parameters_in_time(self, p: Mapping[str, Any], tau: Any) -> Mapping[str, Any]:
        """Coefficients of the angle while the frequency changes."""
        curvature = (p["stop"] - p["start"]) / (2 * p["duration"])
        return {"piece.0": p["phase"], "piece.1": p["start"] * tau, "piece.2": curvature * tau**2}

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """Two pieces, the sweep and what follows it; the second only if it is reached."""
        p = {
            name: self.given_or_own_values(values, name)
            for name in ("start", "stop", "duration", "phase")
        }
        start, stop, sweep, phase = p.values()
        swept = np.minimum(sweep, np.atleast_1d(np.asarray(duration, dtype=np.float64)))
        held = np.maximum(duration - sweep, 0.0)
        first = self.piece_parameters_in_time(p, swept)
        turned = np.mod(phase + 0.5 * (start + stop) * sweep, 2.0 * np.pi)
        zero = np.zeros_like(swept)
        second = {"piece.0": turned, "piece.1": stop * held, "piece.2": zero}
        rows = {name: (first[name] + zero, second[name] + zero) for name in first}
        pieces = 2 if np.any(held > 0) else 1
        return LoadSchedule(
            np.stack([swept, held + zero][:pieces]),
            periodic=False,
            piece_parameters={name: np.stack(pair[:pieces]) for name, pair in rows.items()},
            waveforms_at_phase=empty_waveforms,
        )

"""Loads given by a formula: constant, sine, sine squared."""

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
from remanent.models.drives.base import (
    Drive,
    Waveform,
    as_times,
    empty_waveforms,
    periodic_load_schedule,
)

#: The rule of a magnetic load.
LOAD_RULE = _checks.finite_rule("It is a magnetic load, B_r B/(mu mu0).")
#: The rule of an angle.
PHASE_RULE = _checks.finite_rule("It is an angle in radians.")
#: The rule of an angular frequency.
OMEGA_RULE = _checks.positive_rule(
    "It is an angular frequency per unit of tau.",
    "Pass a number above 0; for a load that does not change use Constant.",
)


@dataclass(frozen=True)
class Constant(Drive):
    r"""A load that does not change.

    :math:`m(\tau) = m`.

    Parameters
    ----------
    m : float
        Magnetic load.

    Raises
    ------
    InputError
        A load that is no finite number.

    See Also
    --------
    Steps : A load that jumps.
    Actuator.load : The load of a flux density.

    Examples
    --------
    >>> float(Constant(0.16)(3.0))
    0.16
    """

    m: float

    has_load_rate: ClassVar[bool] = True
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({"m": LOAD_RULE})

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.16)

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """m(tau) = m."""
        return np.full_like(as_times(tau), self.m)

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """m(tau) = m."""
        return p["m"]

    def load_rate(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """Nothing changes."""
        return 0

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One piece that lasts as long as the trajectory."""
        lengths = np.array(duration, dtype=np.float64, ndmin=1)[np.newaxis]
        return LoadSchedule(
            lengths, periodic=False, piece_parameters={}, waveforms_at_phase=empty_waveforms
        )


@dataclass(frozen=True)
class SineSquared(Drive):
    r"""A load that is the square of a sinusoidal flux.

    :math:`m(\tau) = [b \sin(\omega \tau + \varphi)]^2`, written :math:`b^2` in [Thermal, eq. 15],
    with the phase :math:`\varphi`.  With b = 0.4 it gives the published resonances; the article
    does not state the law of its load.

    Parameters
    ----------
    b : float
        Square root of the largest load.
    omega : float
        Angular frequency of the flux.  The load repeats every :math:`\pi/\omega`.
    phase : float
        Angle of the flux at tau = 0, in radians.

    Raises
    ------
    InputError
        A value that breaks the rule of its field, such as a frequency that is not positive.

    See Also
    --------
    Sine : A sinusoidal load.
    Actuator.frequency : The angular frequency of a frequency in hertz.

    Examples
    --------
    >>> round(SineSquared(0.4, 1.25).period, 6)
    2.513274
    """

    b: float
    omega: float
    phase: float = 0.0

    has_load_rate: ClassVar[bool] = True
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "b": _checks.finite_rule("Its square is the largest magnetic load."),
            "omega": OMEGA_RULE,
            "phase": PHASE_RULE,
        }
    )
    waveform_names: ClassVar[tuple[str, ...]] = ("sin_pi_phase", "cos_pi_phase")
    waveforms: ClassVar[tuple[Waveform, ...]] = tuple(Waveform(f, np.pi) for f in ("sin", "cos"))

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.4, 1.25, phase=0.3)

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """m(tau) = [b sin(omega tau + phase)]^2."""
        angle = self.omega * as_times(tau) + self.phase
        return np.asarray((self.b * np.sin(angle)) ** 2)

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """m = [b (sin(pi s) cos(phase) + cos(pi s) sin(phase))]^2, s the drive's phase."""
        sine = u["sin_pi_phase"] * fn.cos(p["phase"]) + u["cos_pi_phase"] * fn.sin(p["phase"])
        return p["b"] ** 2 * sine**2

    def load_rate(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """m' = 2 omega b^2 sin(angle) cos(angle), angle = pi s + phase."""
        sine = u["sin_pi_phase"] * fn.cos(p["phase"]) + u["cos_pi_phase"] * fn.sin(p["phase"])
        cosine = u["cos_pi_phase"] * fn.cos(p["phase"]) - u["sin_pi_phase"] * fn.sin(p["phase"])
        return 2 * p["omega"] * p["b"] ** 2 * sine * cosine

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray:
        """pi/omega."""
        return np.asarray(np.pi / self.given_or_own_values(values, "omega"))

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One piece, the period of the load, repeated."""
        return periodic_load_schedule(self.periods(values), duration, _half_turn_waveforms)


@dataclass(frozen=True)
class Sine(Drive):
    r"""A sinusoidal load with a mean.

    :math:`m(\tau) = \bar m + m \sin(\omega \tau + \varphi)`, with the mean :math:`\bar m` and the
    phase :math:`\varphi`.

    Parameters
    ----------
    m : float
        Amplitude of the load.
    omega : float
        Angular frequency.  The load repeats every :math:`2 \pi/\omega`.
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
    SineSquared : The square of a sinusoidal flux.
    Sines : A sum of sines.

    Examples
    --------
    >>> round(Sine(0.16, 2.5).period, 6)
    2.513274
    """

    m: float
    omega: float
    mean: float = 0.0
    phase: float = 0.0

    has_load_rate: ClassVar[bool] = True
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"m": LOAD_RULE, "omega": OMEGA_RULE, "mean": LOAD_RULE, "phase": PHASE_RULE}
    )
    waveform_names: ClassVar[tuple[str, ...]] = ("sin_2pi_phase", "cos_2pi_phase")
    waveforms: ClassVar[tuple[Waveform, ...]] = tuple(
        Waveform(f, 2.0 * np.pi) for f in ("sin", "cos")
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.2, 0.7, mean=-0.1, phase=2.0)

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """m(tau) = mean + m sin(omega tau + phase)."""
        angle = self.omega * as_times(tau) + self.phase
        return np.asarray(self.mean + self.m * np.sin(angle))

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """mean + m (sin(2 pi s) cos(phase) + cos(2 pi s) sin(phase)), s the drive's phase."""
        sine = u["sin_2pi_phase"] * fn.cos(p["phase"]) + u["cos_2pi_phase"] * fn.sin(p["phase"])
        return p["mean"] + p["m"] * sine

    def load_rate(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """m' = omega m cos(2 pi s + phase)."""
        cosine = u["cos_2pi_phase"] * fn.cos(p["phase"]) - u["sin_2pi_phase"] * fn.sin(p["phase"])
        return p["omega"] * p["m"] * cosine

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray:
        """2 pi/omega."""
        return np.asarray(2.0 * np.pi / self.given_or_own_values(values, "omega"))

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One piece, the period of the load, repeated."""
        return periodic_load_schedule(self.periods(values), duration, _full_turn_waveforms)


def _half_turn_waveforms(phase: FloatArray) -> FloatArray:
    angle = np.pi * np.asarray(phase, dtype=np.float64)
    return np.stack([np.sin(angle), np.cos(angle)])


def _full_turn_waveforms(phase: FloatArray) -> FloatArray:
    angle = 2.0 * np.pi * np.asarray(phase, dtype=np.float64)
    return np.stack([np.sin(angle), np.cos(angle)])

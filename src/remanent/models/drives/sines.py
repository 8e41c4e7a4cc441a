"""A load that is a sum of sines."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np

from remanent import _checks
from remanent._checks import Rule
from remanent._errors import InputError
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.models.drives.base import (
    Drive,
    Waveform,
    as_times,
    empty_waveforms,
    periodic_load_schedule,
)
from remanent.models.drives.piecewise import Numbers
from remanent.models.drives.waves import LOAD_RULE, OMEGA_RULE, PHASE_RULE

#: Name of the angle omega tau at the end of the run, a parameter of the piece.
_FINAL_ANGLE_PARAMETER = "piece.turns"
#: Multiples that are fractions of whole numbers up to this have a common divisor.
_LARGEST_DENOMINATOR = 1000


@dataclass(frozen=True)
class Sines(Drive):
    """A sum of sines whose angular frequencies are multiples of one.

    Equation: m(tau) = mean + sum_k loads[k] sin(multiples[k] omega tau + phases[k]).

    Where all multiples are fractions of whole numbers, such as 2 or 1.5, the load has a period;
    for other ratios, such as 1 and the square root of 2, it has none, whatever the loads are.
    Loads and phases may be varied one by one: ``loads.0``, ``phases.1`` ...

    Parameters
    ----------
    loads : sequence of float (term,)
        Amplitude of each term.
    multiples : sequence of float (term,)
        Its angular frequency over omega; positive, each different.
    omega : float
        Angular frequency per unit of tau that they multiply.
    phases : sequence of float (term,), optional
        Angle of each term at tau = 0, in radians; 0 by default.
    mean : float
        Mean load.

    Raises
    ------
    InputError
        Sequences of different lengths, multiples that repeat, or a value that breaks its rule.

    See Also
    --------
    Sine : One sine.
    Loads : Drives of several loads.

    Examples
    --------
    >>> round(Sines([0.1, 0.05], [1, 3], 2.5).period, 6)
    2.513274
    >>> Sines([0.1, 0.05], [1, 2**0.5], 2.5).period is None
    True
    """

    loads: Numbers
    multiples: Numbers
    omega: float
    phases: Numbers | None = None
    mean: float = 0.0

    has_load_rate: ClassVar[bool] = True
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({"omega": OMEGA_RULE, "mean": LOAD_RULE})
    table_rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"loads": LOAD_RULE, "phases": PHASE_RULE}
    )
    structural_fields: ClassVar[tuple[str, ...]] = ("multiples",)

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls([0.2, -0.1], [1, 2], 0.7, phases=[0.3, 1.0], mean=0.05)

    def __post_init__(self) -> None:
        if self.phases is None:
            object.__setattr__(self, "phases", (0.0,) * np.size(self.multiples))
        super().__post_init__()

    def checked_fields(self) -> Mapping[str, Any]:
        """The multiples as a tuple of floats, if they fit the loads and phases."""
        multiples = _checks.require_numbers(
            "multiples", self.multiples, what="multiples of omega", why="Each term has one."
        ).tolist()
        if min(multiples) <= 0.0 or len(set(multiples)) < len(multiples):
            raise InputError(
                "multiples",
                must="be positive and different from each other",
                got=multiples,
                why="Each is the frequency of one term, over omega.",
                fix="Join terms of one frequency; put a constant into `mean`.",
            )
        for name in self.table_rules:
            if len(getattr(self, name)) != len(multiples):
                raise InputError(
                    name,
                    must=f"have as many entries as `multiples`, {len(multiples)}",
                    got=len(getattr(self, name)),
                    why="Each term has one.",
                    fix="Pass one entry per term.",
                )
        return {"multiples": tuple(multiples)}

    def _checked_multiples(self) -> tuple[float, ...]:
        assert isinstance(self.multiples, tuple)  # since it was checked
        return self.multiples

    def _common_divisor(self, counted: Sequence[bool] | None = None) -> Fraction | None:
        """The largest number of which multiples are whole multiples, if they are rational.

        Parameters
        ----------
        counted : sequence of bool, optional
            Which of the multiples; all by default.
        """
        multiples = self._checked_multiples()
        ratios = [Fraction(k).limit_denominator(_LARGEST_DENOMINATOR) for k in multiples]
        if any(float(ratio) != k for ratio, k in zip(ratios, multiples, strict=True)):
            return None
        if counted is not None and any(counted):
            ratios = [
                ratio for ratio, is_counted in zip(ratios, counted, strict=True) if is_counted
            ]
        return Fraction(
            math.gcd(*(ratio.numerator for ratio in ratios)),
            math.lcm(*(ratio.denominator for ratio in ratios)),
        )

    def with_varied(self, names: Collection[str]) -> Self:
        """The drive in which every term whose load varies counts for the period."""
        loads = [
            self.parameter_values()[f"loads.{i}"] for i in range(len(self._checked_multiples()))
        ]
        counted = [
            1.0 if f"loads.{i}" in names and load == 0.0 else load for i, load in enumerate(loads)
        ]
        return self if counted == loads else self.replace(loads=counted)

    def _acting_terms(self, values: Mapping[str, FloatArray]) -> list[bool]:
        """Which terms have a load, of the drive itself or anywhere in a batch of `values`."""
        own = self.parameter_values()
        names = [f"loads.{i}" for i in range(len(self._checked_multiples()))]
        return [own[name] != 0.0 or bool(np.any(values.get(name, 0.0))) for name in names]

    @property
    def waveform_names(self) -> tuple[str, ...]:
        """Sine and cosine of each term, where there is a period."""
        if self._common_divisor() is None:
            return ()
        count = range(len(self._checked_multiples()))
        return tuple(f"{name}.{i}" for i in count for name in ("sin", "cos"))

    @property
    def waveforms(self) -> tuple[Waveform, ...]:
        """Sine and cosine of each term, as often as it repeats in the period."""
        base = self._common_divisor(self._acting_terms({}))
        if base is None:
            return ()
        return tuple(
            Waveform(name, 2.0 * np.pi, float(Fraction(k) / base))
            for k in self._checked_multiples()
            for name in ("sin", "cos")
        )

    @property
    def piece_parameter_names(self) -> tuple[str, ...]:
        """The angle omega tau at the end of the run, where there is no period."""
        return () if self._common_divisor() is not None else (_FINAL_ANGLE_PARAMETER,)

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """m(tau) = mean + sum loads sin(multiples omega tau + phases)."""
        angle = self.omega * as_times(tau)
        p = self.parameter_values()
        terms = (
            p[f"loads.{i}"] * np.sin(k * angle + p[f"phases.{i}"])
            for i, k in enumerate(self._checked_multiples())
        )
        return np.asarray(self.mean + sum(terms))

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """The same sum, by waveforms of the drive's phase or by the angle itself."""
        total = p["mean"]
        for i, k in enumerate(self._checked_multiples()):
            shift = p[f"phases.{i}"]
            if self._common_divisor() is None:
                sine = fn.sin(k * p[_FINAL_ANGLE_PARAMETER] * phase + shift)
            else:
                sine = u[f"sin.{i}"] * fn.cos(shift) + u[f"cos.{i}"] * fn.sin(shift)
            total = total + p[f"loads.{i}"] * sine
        return total

    def piece_parameters_in_time(self, p: Mapping[str, Any], tau: Any) -> Mapping[str, Any]:
        """The angle omega tau, where there is no period."""
        return dict.fromkeys(self.piece_parameter_names, p["omega"] * tau)

    def load_rate(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """m' = sum loads multiples omega cos(multiples omega tau + phases)."""
        total = 0
        for i, k in enumerate(self._checked_multiples()):
            shift = p[f"phases.{i}"]
            if self._common_divisor() is None:
                cosine = fn.cos(k * p[_FINAL_ANGLE_PARAMETER] * phase + shift)
            else:
                cosine = u[f"cos.{i}"] * fn.cos(shift) - u[f"sin.{i}"] * fn.sin(shift)
            total = total + p[f"loads.{i}"] * k * p["omega"] * cosine
        return total

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray | None:
        """2 pi/(g omega), with g the greatest common divisor of the multiples, or None.

        Terms without a load do not count, unless one of the values in the batch is another:
        all of a batch have their period in common.
        """
        if self._common_divisor() is None:
            return None
        base = self._common_divisor(self._acting_terms(values))
        assert base is not None
        omega = self.given_or_own_values(values, "omega")
        return np.asarray(2.0 * np.pi / (float(base) * omega))

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One period, repeated, or one piece as long as the trajectory."""
        period = self.periods(values)
        base = self._common_divisor(self._acting_terms(values))
        if period is not None and base is not None:
            turns = tuple(float(Fraction(k) / base) for k in self._checked_multiples())
            return periodic_load_schedule(period, duration, partial(_sines_and_cosines, turns))
        lengths = np.array(duration, dtype=np.float64, ndmin=1)[np.newaxis]
        omega = {"omega": self.given_or_own_values(values, "omega")}
        return LoadSchedule(
            lengths,
            periodic=False,
            piece_parameters=dict(self.piece_parameters_in_time(omega, lengths)),
            waveforms_at_phase=empty_waveforms,
        )


def _sines_and_cosines(turns: tuple[float, ...], phase: FloatArray) -> FloatArray:
    """Sine and cosine of each term at a phase of the period."""
    angles = [2.0 * np.pi * np.mod(k * np.asarray(phase, dtype=np.float64), 1.0) for k in turns]
    return np.stack([f(angle) for angle in angles for f in (np.sin, np.cos)])

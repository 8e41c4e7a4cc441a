"""What every drive is: a magnetic load m(tau) and how it runs in time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from remanent._checks import as_float_array
from remanent._errors import InputError, shortened_repr
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.models.parts import Part

#: Latest time at which a load is asked for, in tau.
_LATEST_TIME = 1e100


@dataclass(frozen=True)
class Waveform:
    """A waveform of a load as data: sin or cos of an angle that the drive's phase runs through.

    Equation: function(span frac(repeats s)), s the phase in [0, 1), frac the fractional part.

    Attributes
    ----------
    function
        ``"sin"`` or ``"cos"``.
    span
        Angle that one repeat runs through, pi or 2 pi.
    repeats
        Repeats in one period of the drive.
    """

    function: str
    span: float
    repeats: float = 1.0


@dataclass(frozen=True)
class Drive(Part, ABC):
    """A magnetic load m(tau) = B_r B(tau)/(mu mu0), tau >= 0.

    The load is written twice: as a plain function of time, :meth:`__call__`, and as
    the law that enters the equations of motion, :meth:`load`, in terms of numeric
    fields, of waveforms all trajectories share, and of the phase in the current piece
    of the :meth:`load_schedule`.  A contract test holds the two together.
    """

    #: The field to which the period is inversely proportional, where there is a period.
    frequency_field_name: ClassVar[str] = "omega"
    #: Whether :meth:`load_rate` is written.
    has_load_rate: ClassVar[bool] = False

    @property
    def load_names(self) -> tuple[str, ...]:
        """Names of the loads that the drive gives, in the order of the system's ``load_names``."""
        return ("load",)

    @property
    def waveform_names(self) -> tuple[str, ...]:
        """Names of the waveforms that :meth:`load` uses."""
        return ()

    @property
    def piece_parameter_names(self) -> tuple[str, ...]:
        """Names of further parameters whose values come with each piece of the load schedule."""
        return ()

    @property
    def waveforms(self) -> tuple[Waveform, ...]:
        """What each of the waveforms is, in the order of :attr:`waveform_names`."""
        return ()

    @property
    def period_field_name(self) -> str | None:
        """The numeric field to which the period is inversely proportional; None without one."""
        name = self.frequency_field_name
        return name if self.period is not None and name in self.parameter_values() else None

    @property
    def last_change(self) -> float:
        """The time at which the last piece of a load without a period begins."""
        return 0.0

    @property
    def known_until(self) -> float:
        """The time after which the load is not known; infinite for most drives."""
        return math.inf

    @abstractmethod
    def __call__(self, tau: ArrayLike) -> FloatArray:
        """The load at times `tau`, an array of the same shape."""

    @abstractmethod
    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """The load in the equations of motion.

        Parameters
        ----------
        p
            Values of the numeric fields and of the piece parameters, by name.
        u
            Values of the waveforms, by name.
        phase
            Phase of the drive, or fraction of the current piece, in [0, 1).
        fn
            Where ``sin`` and other functions are found: the module sympy or numpy.
        """

    def piece_parameters_in_time(self, p: Mapping[str, Any], tau: Any) -> Mapping[str, Any]:
        """Piece parameters of the first piece, where that ends at `tau`, its phase being 1.

        With them :meth:`load` is the load as a function of time.

        Parameters
        ----------
        p
            Values of the numeric fields, by name: numbers, arrays or symbols.
        tau
            The time.
        """
        return {}

    def loads_by_name(
        self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any
    ) -> dict[str, Any]:
        """Every load by its name, for systems with one load or several.

        Parameters
        ----------
        p, u, phase, fn
            Numeric fields, waveforms, phase and functions, as :meth:`load` takes them.
        """
        return {name: self.load(p, u, phase, fn) for name in self.load_names}

    def load_rates_by_name(
        self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any
    ) -> dict[str, Any]:
        """The rate of every load by its name; None where it jumps or has no closed form.

        Parameters
        ----------
        p, u, phase, fn
            Numeric fields, waveforms, phase and functions, as :meth:`load` takes them.
        """
        return {name: self.load_rate(p, u, phase, fn) for name in self.load_names}

    def load_rate(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """Rate of the load, dm/dtau; None where it jumps or has no closed form.

        It enters the equations where a remanence that depends on temperature takes part in
        a heat balance.

        Parameters
        ----------
        p, u, phase, fn
            Numeric fields, waveforms, phase and functions, as :meth:`load` takes them.
        """
        return None

    @abstractmethod
    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """How the load runs in time, for a batch of trajectories.

        Parameters
        ----------
        values : mapping of name to array (trajectory,)
            Values of numeric fields; those not named have the drive's own value.
        duration : array (trajectory,)
            How long each trajectory lasts.  A periodic load does not depend on it.
        """

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray | None:
        """Smallest period of the load for each of a batch of `values`, or None."""
        return None

    @property
    def period(self) -> float | None:
        """Smallest period of m(tau), or None where m has no (smallest) period."""
        periods = self.periods({})
        return None if periods is None else float(periods)

    def with_varied(self, names: Collection[str]) -> Self:
        """The drive where fields of these names take values of their own; itself, usually.

        Parameters
        ----------
        names : collection of str
            Numeric fields whose values are given with every run.

        Returns
        -------
        Drive
            Its period does not depend on whether one of the values happens to be 0.
        """
        return self

    def given_or_own_values(self, values: Mapping[str, FloatArray], name: str) -> FloatArray:
        """The field `name` of a batch: from `values`, else the drive's own."""
        numbers = values[name] if name in values else self.parameter_values()[name]
        return np.asarray(numbers, dtype=np.float64)


def as_times(tau: ArrayLike) -> FloatArray:
    """Times at which a load is asked for: NaN where there is none, and never infinite."""
    times = as_float_array(
        "tau",
        tau,
        what="times in tau",
        why="The load is a function of time.",
        fix="Pass a time, or an array of them.",
    )
    if (np.abs(times) > _LATEST_TIME).any():
        raise InputError(
            "tau",
            must=f"be at most {_LATEST_TIME:g} in size",
            got=shortened_repr(tau),
            why="No run lasts longer, and products of such times overflow.",
            fix="Pass a time within a run.",
        )
    return times


def periodic_load_schedule(
    period: FloatArray, duration: FloatArray, waveform: Callable[[FloatArray], FloatArray]
) -> LoadSchedule:
    """The load schedule of a load that repeats itself: one piece, the period."""
    lengths = np.broadcast_to(period, np.shape(np.atleast_1d(duration)))[np.newaxis].copy()
    return LoadSchedule(lengths, periodic=True, piece_parameters={}, waveforms_at_phase=waveform)


def empty_waveforms(phase: FloatArray) -> FloatArray:
    """The waveforms of a load that has none, an array (0, *phase.shape)."""
    return np.empty((0, *np.shape(phase)))

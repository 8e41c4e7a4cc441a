"""A load that does not change, looked at in intervals of equal length."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np

from remanent._checks import Rule
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.models.drives.base import Drive, as_times, empty_waveforms, periodic_load_schedule
from remanent.models.drives.waves import LOAD_RULE


@dataclass(frozen=True)
class StrobedConstant(Drive):
    """A constant load m, whose intervals count as its periods.

    Averages over long runs are taken from period to period; of a load without a period they are
    taken from interval to interval.

    Parameters
    ----------
    m
        The load.
    length
        Of the intervals, in tau.
    """

    m: float
    length: float = 1.0

    has_load_rate: ClassVar[bool] = True
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({"m": LOAD_RULE})

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.16, 2.0)

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """m(tau) = m."""
        return np.full_like(as_times(tau), self.m)

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """m(tau) = m."""
        return p["m"]

    def load_rate(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """Nothing changes."""
        return 0

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray:
        """The length of an interval, the same for all."""
        return np.full(np.shape(self.given_or_own_values(values, "m")), self.length)

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One piece, an interval, repeated."""
        return periodic_load_schedule(self.periods(values), duration, empty_waveforms)

"""Forced oscillators of the textbooks as maps over one drive period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import sympy as sp
from tests.unit.integrate.handmade import COSINE, Oscillator, Q, V, turning

from remanent._typing import FloatArray
from remanent.analysis.orbits.maps import MapImage
from remanent.integrate.maps.period_map import PeriodMap
from remanent.integrate.variations import LOG_PERIOD_PARAMETER_NAME

NAMES = ("omega", "d", "g", "a", "e", "k", "F")


def acceleration() -> sp.Expr:
    """x'' = F cos wt - (d + g x^2) x' - (a + e cos wt) x - k x^3."""
    _, d, g, a, e, k, force = sp.symbols(NAMES)
    return force * COSINE - (d + g * Q**2) * V - (a + e * COSINE) * Q - k * Q**3


@dataclass(frozen=True)
class ForcedOscillator:
    """The oscillator with one of its parameters free, as a map."""

    parameters: Mapping[str, float]
    free: str
    tolerance: float = 1e-11
    dimension: int = field(default=2, init=False)

    @cached_property
    def _flow(self) -> PeriodMap:
        own: Sequence[str] = () if self.free == "omega" else (self.free,)
        oscillator = Oscillator(acceleration(), dict.fromkeys(NAMES, 0.0))
        return PeriodMap(
            oscillator.field(), turning, directions=2, parameters=(*own, LOG_PERIOD_PARAMETER_NAME)
        )

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        count = len(states)
        columns = np.tile([self.parameters.get(name, 0.0) for name in NAMES], (count, 1))
        columns[:, NAMES.index(self.free)] = parameters[:, 0]
        omega = columns[:, 0]
        image = self._flow(
            states, columns, 2.0 * np.pi / omega, tolerance=self.tolerance, cycles=iterate
        )
        by_free = image.tangents[:, 2]
        if self.free == "omega":
            by_free = image.tangents[:, -1] / -omega[:, None]
        jacobian = np.moveaxis(image.tangents[:, :2], 1, 2)
        return MapImage(
            image.state, jacobian, by_free[:, :, None], image.largest_period_error * iterate
        )

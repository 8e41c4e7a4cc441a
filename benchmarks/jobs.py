"""The work that every tool is given: frequency responses of [Thermal, eq. 16]."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from remanent._typing import FloatArray

#: Temperature of the reference configuration, kelvin.
REFERENCE_TEMPERATURE = 293.0


@dataclass(frozen=True)
class Job:
    """Motions from rest over `window` under the load (b sin ωτ)², one for each frequency.

    Attributes
    ----------
    low, high, count
        Drive frequencies, evenly spaced.
    temperature, prestress, b, c
        As the fields of an actuator and its drive are called.
    checked
        How many of the frequencies have a reference solution.
    """

    name: str
    low: float
    high: float
    b: float
    c: float
    prestress: float
    temperature: float = 350.0
    window: float = 100.0
    count: int = 12_288
    checked: int = 768

    @property
    def omegas(self) -> FloatArray:
        return np.linspace(self.low, self.high, self.count)

    @property
    def subset(self) -> slice:
        """The frequencies that have a reference solution."""
        return slice(0, None, self.count // self.checked)

    @property
    def theta(self) -> float:
        return self.temperature / REFERENCE_TEMPERATURE

    def small(self) -> Job:
        """The same on fewer frequencies."""
        return replace(self, count=self.count // 8, checked=self.checked // 4)

    def acceleration(self, m: Any, x: Any, v: Any) -> Any:
        """[Thermal, eq. 16] with its numbers written in, brought to one division.

        With the stretch x, its rate v and the magnetic load m,

            x'' = (6 c v² − 3 (θ (x⁸ − x²) + m x⁴ − S x⁷)) / (x⁷ + 2 c x).

        This is the equation multiplied by x⁷, the fewest operations of the forms tried.  It
        takes numbers of any kind: floats, arrays, and expressions of other tools.
        """
        x2 = x * x
        x3, x4 = x2 * x, x2 * x2
        force = self.theta * (x4 * x4 - x2) + m * x4
        x7 = x3 * x4
        if self.prestress:
            force = force - self.prestress * x7
        return ((6.0 * self.c) * (v * v) - 3.0 * force) / (x7 + (2.0 * self.c) * x)


#: A cube, as in [Thermal].
RESPONSE = Job("response", 0.5, 2.0, b=0.4, c=1.0, prestress=0.0)
#: A film: fast stretches of the motion, and steps that should differ a hundredfold.
FILM = Job("film", 0.5, 4.0, b=0.9, c=0.01, prestress=1.0)
#: All jobs by name.
JOBS = {job.name: job for job in (RESPONSE, FILM)}


def thickness_stretch(x: Any) -> Any:
    """λ₃ of the in-plane stretch: what errors are measured in."""
    return 1.0 / (x * x)

"""Orbits under constant loads, by quadrature of the energy: exact at every instant."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
import pytest

import remanent as rm
from remanent._typing import FloatArray

DIGITS = 40


@dataclass(frozen=True)
class Orbit:
    """The motion from rest at stretch 1 under a constant load.

    With x = a + (b - a) sin(u)**2 between the turning points a and b, time is the integral
    of 2 sqrt(M/(2 g)) du, where E - V = (x - a)(b - x) g.
    """

    c: float
    theta: float
    prestress: float
    m: float

    def surplus(self, x: Any) -> Any:
        """E - V."""

        def potential(x: Any) -> Any:
            elastic = self.theta * (x**2 / 2 + x**-4 / 4)
            return 3 * (elastic - self.prestress * x - self.m * x**-2 / 2)

        return potential(mpmath.mpf(1)) - potential(x)

    @cached_property
    def other(self) -> Any:
        """The turning point that is not 1."""
        way = 1 if self.prestress > self.m else -1
        shift = mpmath.mpf("1e-12")
        while self.surplus(mpmath.exp(way * 1.5 * shift)) > 0:
            shift *= 1.5
        ends = [mpmath.exp(way * k * shift) for k in (1, 1.5)]
        return mpmath.findroot(self.surplus, ends, solver="anderson")

    def speed(self, u: Any) -> Any:
        """d tau/d u."""
        x = self.place(u)
        g = self.surplus(x) / (abs(x - 1) * abs(self.other - x))
        return 2 * mpmath.sqrt((1 + 2 * self.c * x**-6) / (2 * g))

    def place(self, u: Any) -> Any:
        """Stretch; u = 0 is the start."""
        return 1 + (self.other - 1) * mpmath.sin(u) ** 2

    def until(self, u: Any) -> Any:
        """tau from the start; the ends, where g is 0/0, are not nodes of the quadrature."""
        return mpmath.quad(self.speed, mpmath.linspace(0, u, 5), method="gauss-legendre")

    def states(self, count: int, cycles: int) -> tuple[FloatArray, FloatArray]:
        """Times, and the exact states then, going out and coming back, in some periods."""
        angles = [mpmath.pi / 2 * k / count for k in range(1, count)]
        half = self.until(mpmath.pi / 2)
        rows = [(mpmath.mpf(0), mpmath.mpf(1), mpmath.mpf(0)), (half, self.other, mpmath.mpf(0))]
        for u in angles:
            x, t = self.place(u), self.until(u)
            v = mpmath.sqrt(2 * self.surplus(x) / (1 + 2 * self.c * x**-6))
            v = v if self.other > 1 else -v
            rows += [(t, x, v), (2 * half - t, x, -v)]
        shifted = [
            [float(t + 2 * half * k), float(x), float(v)] for k in range(cycles) for t, x, v in rows
        ]
        found = np.array(sorted(shifted))
        return found[:, 0], found[:, 1:]


ORBITS = [
    Orbit(1.0, 1.0, 0.0, 0.16),
    Orbit(0.01, 1.2, 1.0, 0.16),
    Orbit(0.001, 0.8, 0.0, -0.5),
    Orbit(0.3, 1.6, 2.5, -2.0),
    Orbit(1.0, 0.5, -1.0, 3.0),
]


@pytest.mark.parametrize("orbit", ORBITS)
def test_orbits_under_constant_loads_are_those_of_the_quadrature(orbit: Orbit) -> None:
    """Orbits under constant loads are those of the quadrature, within error and tolerance.

    At any time of ten periods, the true error <= the reported one <= the tolerance.

    Law: Exact solutions.
    """
    with mpmath.workdps(DIGITS):
        times, exact = orbit.states(4, 10)
    body = rm.Actuator(
        c=orbit.c,
        temperature=300.0 * orbit.theta,
        reference_temperature=300.0,
        prestress=orbit.prestress,
    )
    for tolerance in (1e-5, 1e-8, 1e-10):
        ds = rm.simulate(body, rm.Constant(orbit.m), times=times, tolerance=tolerance)
        assert int(ds.status) == 1
        ours = np.column_stack([ds.stretch.values, ds.stretch_rate.values])
        assert np.abs(ours - exact).max() <= float(ds.error) <= tolerance


def test_the_quadrature_knows_small_oscillations() -> None:
    """Exact solutions: small oscillations have the period 2 pi sqrt((1 + 2 c)/(18 theta))."""
    with mpmath.workdps(DIGITS):
        orbit = Orbit(0.2, 1.3, 1e-6, 0.0)
        period = float(2 * orbit.until(mpmath.pi / 2))
    assert period == pytest.approx(2.0 * np.pi * np.sqrt(1.4 / (18.0 * 1.3)), rel=1e-6)


def test_a_narrow_window_of_instability_is_found_on_a_wide_diagram() -> None:
    """Two doublings 7e-6 apart are seen by a branch that is followed over 0.8 in frequency."""
    ds = rm.response_diagram(
        rm.Actuator(temperature=400.0, prestress=1.0), rm.SineSquared(0.4, 1.0), (0.7, 1.5)
    )
    doublings = ds.special_omega.values[ds.special_kind.values == "period doubling"]
    np.testing.assert_allclose(doublings, [0.857294, 0.857301], atol=2e-6)

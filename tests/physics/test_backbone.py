"""The frequency of the nonlinear mode: by quadrature of the energy, and in both limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import remanent as rm
from benchmarks.errors.rows import backbone as rows


@dataclass(frozen=True)
class Free:
    """Free oscillations of equation (16) under a constant load."""

    c: float
    theta: float
    prestress: float
    m: float

    def potential(self, x: float) -> float:
        elastic = self.theta * (x**2 / 2 + x**-4 / 4)
        return float(3 * (elastic - self.prestress * x - self.m * x**-2 / 2))

    def force(self, x: float) -> float:
        return float(self.theta * (x - x**-5) - self.prestress + self.m * x**-3)

    def other(self, start: float) -> float:
        """The turning point on the other side of the equilibrium."""
        rest = brentq(self.force, 0.3, 3.0, xtol=1e-15)
        reach = rest**2 / start
        while self.potential(reach) < self.potential(start):
            reach *= rest / start
        return float(brentq(lambda x: self.potential(x) - self.potential(start), rest, reach,
                            xtol=1e-15, rtol=1e-15))  # fmt: skip

    def frequency(self, start: float) -> float:
        """π over half a period, ∫ dx/√(2(E − V)/M) with x = a + (b − a) sin² u."""
        a, b = start, self.other(start)

        def slowness(u: float) -> float:
            x = a + (b - a) * np.sin(u) ** 2
            surplus = self.potential(start) - self.potential(x)
            g = surplus / (abs(x - a) * abs(b - x))
            return float(2.0 * np.sqrt((1.0 + 2.0 * self.c * x**-6) / (2.0 * g)))

        return float(np.pi / quad(slowness, 1e-9, np.pi / 2 - 1e-9, epsabs=1e-12, limit=200)[0])

    @property
    def actuator(self) -> rm.Actuator:
        return rm.Actuator(
            c=self.c, temperature=300.0 * self.theta, reference_temperature=300.0,
            prestress=self.prestress,
        )  # fmt: skip


@pytest.mark.parametrize(
    "free", [Free(1.0, 1.0, 0.0, 0.16), Free(0.1, 1.2, 0.5, 0.08), Free(1.0, 0.9, 1.0, -0.5)]
)
def test_frequencies_are_those_of_the_quadrature(free: Free) -> None:
    """Exact solutions: free oscillations have the frequency of the quadrature, within the error.

    They agree to nine digits less two of the quadrature, too.
    """
    starts = np.array([1.6, 2.0, 2.8])
    ds = rm.backbone(free.actuator, starts, m=free.m)
    exact = np.array([free.frequency(float(x)) for x in starts])
    np.testing.assert_allclose(ds.frequency, exact, rtol=1e-7)
    np.testing.assert_allclose(ds.maximum, [free.other(float(x)) ** -2 for x in starts], atol=1e-8)
    np.testing.assert_allclose(ds.minimum, starts**-2, atol=1e-8)


def test_small_oscillations_have_the_natural_frequency() -> None:
    """ω_n² = 18 θ/(1 + 2c) without load; the next term is quadratic in the amplitude."""
    free = Free(0.3, 1.1, 0.0, 0.0)
    ds = rm.backbone(free.actuator, [1.0005, 1.001])
    natural = np.sqrt(18.0 * 1.1 / 1.6)
    away = np.abs(ds.frequency.values / natural - 1.0)
    assert away.max() < 1e-5
    assert away[1] / away[0] == pytest.approx(4.0, rel=0.02)


def test_oscillations_without_bound_have_the_limit_frequency() -> None:
    """2 √(3θ)/(1 + √c), approached as the amplitude grows; forced branches run off at half."""
    free = Free(1.0, 1.0, 0.0, 0.0)
    limit = 2.0 * np.sqrt(3.0) / 2.0
    ds = rm.backbone(free.actuator, [3.0, 6.0, 12.0], tolerance=1e-6)
    away = ds.frequency.values - limit
    assert (np.diff(np.abs(away)) < 0.0).all()
    assert abs(away[-1]) < 0.05 * limit


def test_no_oscillation_is_told_of_an_equilibrium() -> None:
    """A failure is a status: from a stretch at rest nothing moves."""
    ds = rm.backbone(rm.Actuator(), [1.0, 1.5])
    assert ds.status.values.tolist() == [rm.Status.SINGULAR, rm.Status.OK]
    assert np.isnan(ds.frequency.values).tolist() == [True, False]
    assert "equilibrium" in str(ds.reason.values[0])


def test_a_start_too_near_to_rest_to_be_told_from_it_is_still() -> None:
    """A system watched by x^2 moves less than the error of the run: no oscillation is asserted."""
    watched = rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2",
        potential="x**2/2 + x**4/4 - load*x",
        observable="x**2",
    )
    ds = rm.backbone(watched, [0.0, 1e-12, 0.5])
    assert ds.status.values.tolist() == [rm.Status.SINGULAR, rm.Status.SINGULAR, rm.Status.OK]


def test_frequencies_and_amplitudes_are_right_to_their_errors() -> None:
    """Coverage of errors: against the return to rest in extended precision."""
    judged = [one for seed in range(3) for one in rows._oscillations(np.random.default_rng(seed))]
    assert len(judged) > 100
    assert all(one.covered for _, one in judged)

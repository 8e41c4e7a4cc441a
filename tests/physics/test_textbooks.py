"""Known answers of textbooks, through systems that users write."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk, mathieu_a, mathieu_b

import remanent as rm

PENDULUM = rm.LagrangianSystem(
    coordinates="theta", kinetic="theta_rate**2/2", potential="-cos(theta) - load*theta"
)
UEDA = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="x**4/4 - load*x",
    dissipation="k*x_rate**2/2",
    parameters={"k": 0.05},
)
LORENZ = rm.FirstOrderSystem(
    rates={"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"},
    parameters={"sigma": 10.0, "rho": 28.0, "beta": 8.0 / 3.0},
    observable="z",
    rest={"x": 1.0, "y": 1.0, "z": 27.0},
)
ROESSLER = rm.FirstOrderSystem(
    rates={"x": "-y - z", "y": "x + a*y", "z": "q + z*(x - r)"},
    parameters={"a": 0.2, "q": 0.2, "r": 5.7},
    rest={"x": 1.0},
)
HENON_HEILES = rm.LagrangianSystem(
    coordinates=("x", "y"),
    kinetic="(x_rate**2 + y_rate**2)/2",
    potential="(x**2 + y**2)/2 + x**2*y - y**3/3",
)


def test_the_backbone_of_the_pendulum() -> None:
    """A pendulum swings at omega = pi/(2 K(sin(theta_0/2))), K the complete elliptic integral."""
    start = np.array([0.1, 1.0, 2.0, 3.0, 3.1])
    found = rm.backbone(PENDULUM, start)
    exact = np.pi / 2.0 / ellipk(np.sin(start / 2.0) ** 2)
    assert (np.abs(found.frequency - exact) <= found.frequency_error).all()
    assert float(found.frequency_error.max()) < 1e-9


@pytest.mark.parametrize(
    ("characteristic", "order", "trace"),
    [(mathieu_a, 0, 2.0), (mathieu_b, 1, -2.0), (mathieu_a, 1, -2.0), (mathieu_b, 2, 2.0)],
)
def test_the_tongues_of_mathieu(characteristic: object, order: int, trace: float) -> None:
    """Mathieu's x'' + (a - 2 q cos 2t) x = 0 has the trace 2 or -2 at a_n(q) and b_n(q).

    Inside a tongue the trace is beyond it, outside within: both sides are looked at.
    """
    q = 1.3
    edge = float(characteristic(order, q))  # type: ignore[operator]
    drive = rm.Sine(2.0 * q, 2.0, phase=np.pi / 2.0)
    traces = []
    for a in (edge - 1e-3, edge, edge + 1e-3):
        system = rm.LagrangianSystem(
            coordinates="x",
            kinetic="x_rate**2/2",
            potential="(a - load)*x**2/2",
            parameters={"a": a},
        )
        image = rm.period_map(system, drive)([[0.0, 0.0]])
        traces.append(float(np.trace(image.jacobians[0])))
        error = float(image.jacobians_error.sum())
    assert abs(traces[1] - trace) <= error + 1e-12
    assert (abs(traces[0]) - 2.0) * (abs(traces[2]) - 2.0) < 0.0


@pytest.mark.slow
def test_the_exponents_of_lorenz_and_roessler() -> None:
    """Lorenz's equations have exponents 0.9056, 0, -14.572; Roessler's 0.0714, 0, -5.3943.

    These are J. C. Sprott's, Chaos and Time-Series Analysis.  The sums are the divergence of
    Lorenz, -41/3, and lie within the sums of errors.
    """
    for system, duration, known in (
        (LORENZ, 2000.0, (0.9056, 0.0, -14.572)),
        (ROESSLER, 5000.0, (0.0714, 0.0, -5.3943)),
    ):
        found = rm.lyapunov(system, rm.Constant(0.0), duration=duration, count=3)
        assert (np.abs(found.exponent - known) <= 3.0 * found.exponent_error + 2e-4).all()
    lorenz = rm.lyapunov(LORENZ, rm.Constant(0.0), duration=200.0, count=3)
    assert float(lorenz.exponent.sum()) == pytest.approx(-41.0 / 3.0, abs=1e-6)


def test_the_attractor_of_ueda() -> None:
    """Ueda's x'' + 0.05 x' + x^3 = 7.5 cos t has the exponents 0.1034 and -0.1534.

    These are Sprott's; the sum is -k.
    """
    found = rm.lyapunov(
        UEDA, rm.Sine(7.5, 1.0, phase=np.pi / 2.0), periods=1000, count=2, initial=(2.5, 0.0)
    )
    assert (np.abs(found.exponent - [0.1034, -0.1534]) <= 3.0 * found.exponent_error).all()
    assert float(found.exponent_error.max()) < 0.02
    assert float(found.exponent.sum()) == pytest.approx(-0.05, abs=1e-9)


@pytest.mark.slow
def test_islands_and_sea_of_henon_and_heiles() -> None:
    """Islands of Henon and Heiles at E = 1/8 have no growth, the sea has 0.04 to 0.07.

    The energy is kept, and points of the section x = 0 have x' > 0.
    """
    growth = {}
    for name, y in (("island", 0.3), ("sea", -0.15)):
        rate = np.sqrt(0.25 - y**2 + 2.0 * y**3 / 3.0)
        start = (0.0, rate, y, 0.0)
        found = rm.lyapunov(HENON_HEILES, rm.Constant(0.0), duration=2000.0, initial=start)
        growth[name] = float(found.exponent)
        section = rm.poincare_section(
            HENON_HEILES, rm.Constant(0.0), where="x", duration=60.0, initial=start
        )
        energy = 0.5 * (section.x_rate**2 + section.y_rate**2 + section.y**2) - section.y**3 / 3.0
        np.testing.assert_allclose(energy, 0.125, atol=1e-8)
        assert (section.x_rate > 0.0).all()
        assert section.sizes["crossing"] > 5
    assert abs(growth["island"]) < 5e-3
    assert 0.03 < growth["sea"] < 0.08


def test_equilibria_of_lorenz() -> None:
    """Lorenz's equations rest at 0 and (+-sqrt(beta (rho - 1)), same, rho - 1).

    All are unstable at rho = 28.
    """
    box = {"x": (-20.0, 20.0), "y": (-20.0, 20.0), "z": (-1.0, 50.0)}
    found = rm.equilibria(LORENZ, state_box=box)
    place = np.sqrt(8.0 / 3.0 * 27.0)
    exact = np.array([(-place, -place, 27.0), (0.0, 0.0, 0.0), (place, place, 27.0)])
    for k, name in enumerate("xyz"):
        error = found[f"{name}_error"].values
        assert (np.abs(found[name].values - exact[:, k]) <= error).all()
    assert found.stability.values.tolist() == ["unstable"] * 3
    assert int(found.status) == int(rm.Status.OK)


@pytest.mark.parametrize("rho", [0.5, 13.0])
def test_stable_equilibria_of_lorenz(rho: float) -> None:
    """Of Lorenz's equilibria the origin is stable below rho = 1, the others from 1 to 24.74."""
    box = {"x": (-20.0, 20.0), "y": (-20.0, 20.0), "z": (-5.0, 50.0)}
    found = rm.equilibria(LORENZ.replace(parameters={"rho": rho}), state_box=box)
    expected = ["stable"] if rho < 1.0 else ["stable", "unstable", "stable"]
    assert found.stability.values.tolist() == expected


def test_the_balloon_has_its_largest_pressure_where_it_is_known() -> None:
    """The pressure in a balloon, 2/l - 2/l^7, is largest at l = 7^(1/6), where it is 1.2395.

    Beyond it nothing holds.  The frequency of small oscillations is 2 + 10/l^6 - 2 P l -
    6 V^2 l^2, squared.
    """
    balloon = rm.LagrangianSystem(
        coordinates="stretch",
        kinetic="stretch_rate**2/2",
        potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - load*stretch**4/2",
        parameters={"pressure": 0.5},
        rest={"stretch": 1.0},
    )
    largest = 2.0 * 7.0 ** (-1.0 / 6.0) - 2.0 * 7.0 ** (-7.0 / 6.0)
    below, above = largest - 1e-6, largest + 1e-6
    box = {"stretch": (0.5, 3.0)}
    found = rm.equilibria(balloon, 0.0, state_box=box, over={"pressure": [1.0, below, above]})
    counts = np.isfinite(found.stretch).sum("equilibrium").values
    assert counts.tolist() == [2, 2, 0]
    near = found.stretch[1].values
    assert near[0] < 7.0 ** (1.0 / 6.0) < near[1]
    loaded = rm.equilibria(balloon, 0.05, state_box=box)
    stretch, frequency = float(loaded.stretch[0]), float(loaded.natural_frequency[0])
    squared = 2.0 + 10.0 / stretch**6 - stretch - 6.0 * 0.05 * stretch**2
    assert abs(frequency**2 - squared) < 1e-12

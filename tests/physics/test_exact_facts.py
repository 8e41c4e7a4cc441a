"""What is known exactly of equation 16 must come out of the public verbs."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import brentq

import remanent as rm
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive

COLD = {"temperature": 300.0, "reference_temperature": 300.0}


def actuator(theta: float = 1.0, **fields: float) -> rm.Actuator:
    return rm.Actuator(temperature=300.0 * theta, reference_temperature=300.0, **fields)  # type: ignore[arg-type]


def potential(x: float, theta: float, S: float, m: float) -> float:
    """V of the Lagrangian M x'**2/2 - V."""
    return 3.0 * (theta * (x * x / 2.0 + x**-4 / 4.0) - S * x - m * x**-2 / 2.0)


# energy -------------------------------------------------------------------------------


@pytest.mark.parametrize("c", [1.0, 0.01])
@pytest.mark.parametrize(("m", "S"), [(0.16, 0.0), (-1.0, 1.0), (2.0, 2.0)])
def test_energy_is_conserved_under_constant_load(c: float, m: float, S: float) -> None:
    """Energy moves by no more than the reported error of the state can explain."""
    ds = rm.simulate(actuator(c=c, prestress=S), rm.Constant(m), duration=60.0)
    assert int(ds.status) == 1
    x, v = ds.stretch.values, ds.stretch_rate.values
    # dE = |E_x| dx + |E_v| dv, of E = M v**2/3 + 2 V/3.
    slope_x = np.abs(-4.0 * c * x**-7 * v * v + 2.0 * (x - x**-5 - S + m * x**-3))
    slope_v = np.abs(2.0 / 3.0 * (1.0 + 2.0 * c * x**-6) * v)
    allowed = (slope_x + slope_v) * float(ds.error) + 1e-14
    moved = np.abs(ds.energy.values - ds.energy.values[0])
    assert (moved <= allowed).all()


@pytest.mark.parametrize(
    "periods", [1000, pytest.param(10_000, marks=pytest.mark.slow)], ids=["1e3", "1e4"]
)
def test_energy_over_many_periods(periods: int) -> None:
    """Undamped, a drive of amplitude zero: energy returns after 10**4 periods.

    Law: Energy and work.
    """
    body = actuator(c=0.3)
    ds = rm.poincare_section(
        body, rm.Sine(0.0, 2.0, 0.16), periods=periods, every=periods // 100, tolerance=1e-8
    )
    assert int(ds.status) == 1
    x, v = ds.stretch.values, ds.stretch_rate.values
    energy = 0.5 * (1.0 + 0.6 * x**-6) * v * v + potential(x, 1.0, 0.0, 0.16)
    steepest = np.abs(3.0 * (x - x**-5 + 0.16 * x**-3) - 1.8 * x**-7 * v * v).max()
    allowed = (steepest + ((1.0 + 0.6 * x**-6) * np.abs(v)).max()) * float(ds.error)
    assert np.abs(energy - energy[0]).max() <= min(allowed, 1e-8)


KNOTS = [0.0, 3.1, 7.4, 12.6, 20.0]
WORKING: dict[str, Drive] = {
    "sine": rm.Sine(0.4, 1.3, 0.2),
    "sine squared": rm.SineSquared(0.7, 0.9, 0.3),
    "chirp": rm.Chirp(0.4, 0.3, 2.0, 15.0, 0.1, 0.2),
    "steps": rm.Steps(KNOTS[:-1], [0.3, -0.4, 0.6, 0.1]),
    "ramp": rm.Ramp(KNOTS, [0.3, -0.4, 0.6, 0.1, 0.2]),
    "sampled": rm.Sampled(KNOTS, [0.3, -0.4, 0.6, 0.1, 0.2]),
}


@pytest.mark.parametrize("eta", [0.0, 0.15])
@pytest.mark.parametrize("name", WORKING)
def test_work_of_the_drive_and_loss_to_the_dashpot_balance(name: str, eta: float) -> None:
    """E + m x, x the thickness stretch, gains int (m x' - 2 eta lambda'**2) dtau, to 1e-8.

    Law: Energy and work.

    The work of the drive, - int x m' dtau, is integrated by parts, so that loads may jump.
    """
    drive = WORKING[name]
    body = rm.Actuator(c=0.5, dissipation=rm.Rayleigh(eta) if eta else ())
    nodes, weights = np.polynomial.legendre.leggauss(10)
    corners = np.concatenate([np.linspace(0.0, 20.0, 101), KNOTS])
    pieces = np.unique(corners.round(9))
    half = np.diff(pieces) / 2.0
    grid = (pieces[:-1, None] + half[:, None] * (1.0 + nodes)).ravel()
    ds = rm.simulate(body, drive, times=np.concatenate([[0.0], grid, [20.0]]), tolerance=1e-11)
    inner, load = ds.isel(time=slice(1, -1)), drive(grid)
    moved = load * inner.thickness_stretch_rate.values
    power = moved - 2.0 * eta * inner.stretch_rate.values**2
    gain = ((power.reshape(-1, nodes.size) * weights).sum(axis=1) * half).sum()
    ends = ds.isel(time=[0, -1])
    without_load = ends.energy.values + drive([0.0, 20.0]) * ends.thickness_stretch.values
    assert without_load[1] - without_load[0] == pytest.approx(gain, abs=1e-8)
    assert abs(gain) > 1e-3


# constant loads -----------------------------------------------------------------------


def period_by_quadrature(c: float, theta: float, S: float, m: float) -> float:
    """2 int dx sqrt(M/(2 (E - V))) between the turning points, x = a + (b - a) sin**2 u."""

    def surplus(x: float) -> float:
        return potential(1.0, theta, S, m) - potential(x, theta, S, m)

    force = 3.0 * (S - m)  # at rest in x = 1
    if force > 0:
        a, b = 1.0, brentq(surplus, 1.0 + 1e-6, 50.0, xtol=1e-15, rtol=8.9e-16)
    else:
        a, b = brentq(surplus, 0.05, 1.0 - 1e-6, xtol=1e-15, rtol=8.9e-16), 1.0

    def integrand(u: float) -> float:
        x = a + (b - a) * math.sin(u) ** 2
        # E - V has the factor (x - a)(b - x), which cancels that of dx**2.
        ratio = surplus(x) / ((x - a) * (b - x))
        return math.sqrt((1.0 + 2.0 * c * x**-6) / (2.0 * ratio)) * 2.0

    inner = quad(integrand, 1e-3, math.pi / 2 - 1e-3, epsabs=1e-13, epsrel=1e-13)[0]
    # At the ends the ratio is 0/0 in floating point; the integrand is flat there.
    ends = 1e-3 * (integrand(1e-3) + integrand(math.pi / 2 - 1e-3))
    return 2.0 * (inner + ends)


@pytest.mark.parametrize(
    ("c", "theta", "S", "m"),
    [(1.0, 1.0, 0.0, 0.16), (0.01, 1.2, 1.0, 0.16), (0.3, 0.8, 0.0, -0.5), (1.0, 1.0, 0.5, 1.5)],
)
def test_orbit_under_constant_load_closes_after_the_quadratures_period(
    c: float, theta: float, S: float, m: float
) -> None:
    """From rest under a constant load the state returns after the period of the quadrature.

    The stretch at rest is 1 (law: Exact solutions).
    """
    period = period_by_quadrature(c, theta, S, m)
    times = np.array([0.0, 0.5 * period, period, 10.0 * period])
    ds = rm.simulate(
        actuator(theta, c=c, prestress=S), rm.Constant(m), times=times, tolerance=1e-11
    )
    # The quadrature's ends are good to 1e-8 of the period; the state at rest moves by
    # the square of that, the rate by itself.
    assert ds.stretch.values[2:] == pytest.approx(1.0, abs=1e-9)
    assert ds.stretch_rate.values[1:] == pytest.approx(0.0, abs=2e-5)


@pytest.mark.parametrize("beta", [-2.0, -0.3, 0.16, 0.5, 1.0, 3.0])
def test_equilibrium_without_prestress(beta: float) -> None:
    """x**3 - beta x**2 - 1 = 0 has one positive root, the thickness stretch at rest."""
    theta = 1.3
    found = rm.equilibria(actuator(theta, c=0.1), beta * theta)
    roots = np.roots([1.0, -beta, 0.0, -1.0])
    (exact,) = roots[(abs(roots.imag) < 1e-12) & (roots.real > 0)].real
    assert found.equilibrium_stretch.values == pytest.approx([exact], rel=1e-12)
    assert found.stability.values.tolist() == ["stable"]


@pytest.mark.parametrize("beta", [-1.0, 0.16, 0.45, 1.5])
def test_turning_point_from_rest(beta: float) -> None:
    """x**2 + (1 - 2 beta) x - 2 = 0 gives the extreme of the thickness stretch."""
    exact = 0.5 * (2.0 * beta - 1.0 + math.sqrt((1.0 - 2.0 * beta) ** 2 + 8.0))
    ds = rm.frequency_response(
        actuator(c=0.2), rm.Sine(0.0, 1.0, beta), [1.0], duration=20.0, tolerance=1e-11
    ).squeeze()
    extreme = ds.maximum if beta > 0 else ds.minimum
    assert float(extreme) == pytest.approx(exact, abs=float(ds.amplitude_error) + 1e-13)
    other = ds.minimum if beta > 0 else ds.maximum
    assert float(other) == pytest.approx(1.0, abs=float(ds.amplitude_error) + 1e-13)


@pytest.mark.parametrize(("theta", "S", "m"), [(1.0, 0.0, 0.0), (1.4, 0.7, 0.16), (0.6, 1.0, -1.0)])
def test_natural_frequency(theta: float, S: float, m: float) -> None:
    """w**2 = 3 [theta (1 + 5 x**-6) - 3 m x**-4] / (1 + 2 c x**-6) at the equilibrium."""
    c = 0.07
    found = rm.equilibria(actuator(theta, c=c, prestress=S), m)
    x = found.stretch.values[0]
    squared = 3.0 * (theta * (1.0 + 5.0 * x**-6) - 3.0 * m * x**-4) / (1.0 + 2.0 * c * x**-6)
    assert float(found.natural_frequency[0]) == pytest.approx(math.sqrt(squared), rel=1e-12)


def test_small_oscillations_have_the_natural_frequency() -> None:
    """A small orbit around the equilibrium repeats after 2 pi/w."""
    body, m = actuator(1.2, c=0.05), 0.3
    at = rm.equilibria(body, m)
    x, w = float(at.stretch[0]), float(at.natural_frequency[0])
    start = (x + 1e-4, 0.0)
    ds = rm.simulate(body, rm.Constant(m), times=[0.0, 2 * math.pi / w], initial=start)
    assert float(ds.stretch_rate[-1]) == pytest.approx(0.0, abs=1e-6 * w)
    assert float(ds.stretch[-1]) == pytest.approx(start[0], abs=1e-8)


def test_cusp_of_equilibria() -> None:
    """beyond m/theta = (25/4)**(1/3), around S/theta = 1.8640, there are three."""
    beta, S = (25.0 / 4.0) ** (1.0 / 3.0), 1.8640
    counts = {}
    for factor in (0.99, 1.02):
        found = rm.equilibria(
            actuator(1.1),
            over={
                "m": [factor * beta * 1.1],
                "prestress": 1.1 * np.linspace(0.9 * S, 1.2 * S, 301),
            },
        )
        number = np.isfinite(found.stretch.values).sum(axis=-1).ravel()
        counts[factor] = set(number.tolist())
        three = found.isel(prestress=number == 3).stability.values.reshape(-1, number.max())
        if factor > 1:
            assert (three == ["stable", "unstable", "stable"]).all()
    assert counts == {0.99: {1}, 1.02: {1, 3}}


def test_cusp_is_where_three_equilibria_meet() -> None:
    """At the cusp itself force, slope and curvature vanish: lambda = 1.1650."""
    beta = (25.0 / 4.0) ** (1.0 / 3.0)
    x = (2.5 / beta) ** 0.5
    prestress = x - x**-5 + beta * x**-3
    assert (x, prestress) == pytest.approx((1.1650, 1.8640), abs=1e-4)
    at = rm.equilibria(actuator(), beta, over={"prestress": [prestress]})
    assert at.stretch.values[:, 0] == pytest.approx(x, abs=1e-4)
    assert float(np.nan_to_num(at.natural_frequency).max()) < 1e-2


def test_without_prestress_there_is_one_equilibrium() -> None:
    """At S = 0, whatever the load."""
    found = rm.equilibria(actuator(), over={"m": np.linspace(-5.0, 8.0, 131)})
    assert (np.isfinite(found.stretch.values).sum(axis=-1) == 1).all()


# symmetries ---------------------------------------------------------------------------


def test_temperature_scales_out() -> None:
    """(theta; m, S, w, tau) and (1; m/theta, S/theta, w/sqrt theta, tau sqrt theta)."""
    theta, times = 1.37, np.linspace(0.0, 100.0, 201)
    root = math.sqrt(theta)
    warm = rm.simulate(actuator(theta, c=0.4, prestress=0.5), rm.SineSquared(0.3, 1.1), times=times)
    cold = rm.simulate(
        actuator(1.0, c=0.4, prestress=0.5 / theta),
        rm.SineSquared(0.3 / root, 1.1 / root),
        times=times * root,
    )
    both = float(warm.error + cold.error)
    assert np.abs(warm.stretch.values - cold.stretch.values).max() <= both
    rates = warm.stretch_rate.values / root - cold.stretch_rate.values
    assert np.abs(rates).max() <= both
    energies = warm.energy.values / theta - cold.energy.values
    assert np.abs(energies).max() <= 20.0 * both


def test_temperature_scales_out_with_damping() -> None:
    """The same with a dashpot, eta -> eta/sqrt theta."""
    theta, times = 0.7, np.linspace(0.0, 60.0, 121)
    root = math.sqrt(theta)
    pairs = []
    for scale, eta, drive, grid in (
        (theta, 0.2, rm.Sine(0.5, 1.4), times),
        (1.0, 0.2 / root, rm.Sine(0.5 / theta, 1.4 / root), times * root),
    ):
        body = rm.Actuator(
            temperature=300.0 * scale,
            reference_temperature=300.0,
            dissipation=rm.Rayleigh(eta),
        )
        pairs.append(rm.simulate(body, drive, times=grid))
    both = float(pairs[0].error + pairs[1].error)
    assert np.abs(pairs[0].stretch.values - pairs[1].stretch.values).max() <= both


def test_dimensional_and_dimensionless_are_one_motion() -> None:
    """from_si and the numbers of docs/model.md by hand (law: Reversal and scaling)."""
    film = rm.Actuator.from_si(
        shear_modulus="100 kPa",
        density="2000 kg/m^3",
        half_length="5 mm",
        half_thickness="0.5 mm",
        remanence="143 mT",
        temperature="350 K",
    )
    unit = 5e-3 * math.sqrt(2000.0 / 1e5)
    m = 0.143 * 0.140 / (1e5 * 1.25663706127e-6)
    times = np.linspace(0.0, 100.0, 101)
    si = rm.simulate(film, rm.Constant(float(film.load("140 mT"))), times=times)
    plain = rm.simulate(rm.Actuator(c=0.01, temperature=350.0), rm.Constant(m), times=times)
    assert float(film.time("1 s")) == pytest.approx(1.0 / unit, rel=1e-14)
    assert np.abs(si.stretch.values - plain.stretch.values).max() <= float(si.error + plain.error)


def mapped(
    body: rm.Actuator, drive: rm.SineSquared, x: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The drive-period map at some states."""
    over = {
        "initial.stretch": xr.DataArray(x, dims="point"),
        "initial.stretch_rate": xr.DataArray(v, dims="point"),
    }
    ds = rm.poincare_section(body, drive, periods=1, over=over, tolerance=1e-12)
    assert (ds.status == 1).all()
    return ds.stretch.values[:, 1], ds.stretch_rate.values[:, 1]


def jacobian(
    body: rm.Actuator, drive: rm.SineSquared, x: float, v: float
) -> tuple[float, FloatArray]:
    """Stretch after a period, and the Jacobian by central differences of order 4."""
    h, weights = 2e-3, np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
    shifts = h * np.array([-2.0, -1.0, 1.0, 2.0])
    zero = np.zeros(4)
    columns = []
    for dx, dv in ((shifts, zero), (zero, shifts)):
        columns.append([weights @ end / h for end in mapped(body, drive, x + dx, v + dv)])
    end = mapped(body, drive, np.array([x]), np.array([v]))[0]
    return float(end[0]), np.array(columns).T


@pytest.mark.parametrize(("x", "v"), [(1.0, 0.0), (0.9, 0.3), (1.2, -0.4)])
def test_period_map_preserves_area(x: float, v: float) -> None:
    """det = M(start)/M(end) in (lambda, lambda'), without damping (law: Liouville's formula)."""
    c = 0.6
    end, matrix = jacobian(actuator(c=c), rm.SineSquared(0.4, 1.25), x, v)
    exact = (1.0 + 2.0 * c * x**-6) / (1.0 + 2.0 * c * end**-6)
    assert np.linalg.det(matrix) == pytest.approx(exact, rel=1e-7)


@pytest.mark.parametrize("eta", [0.05, 0.3])
def test_period_map_contracts_area_by_the_trace(eta: float) -> None:
    """det = M(start)/M(end) exp(-3 eta int dtau/M) with a dashpot (law: Liouville's formula)."""
    c, drive = 0.6, rm.SineSquared(0.4, 1.25)
    body = actuator(c=c).replace(dissipation=rm.Rayleigh(eta))
    end, matrix = jacobian(body, drive, 0.9, 0.3)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    times = 0.5 * drive.period * (nodes + 1.0)  # type: ignore[operator]
    path = rm.simulate(body, drive, times=times, initial=(0.9, 0.3), tolerance=1e-11)
    lost = (
        0.5
        * float(drive.period or 0.0)
        * (weights @ (1.0 / (1.0 + 2.0 * c * path.stretch.values**-6)))
    )
    exact = (1.0 + 2.0 * c * 0.9**-6) / (1.0 + 2.0 * c * end**-6) * math.exp(-3.0 * eta * lost)
    assert np.linalg.det(matrix) == pytest.approx(exact, rel=1e-6)


def test_damping_takes_energy() -> None:
    """Under a constant load energy never grows, and falls."""
    body = rm.Actuator(c=0.2, dissipation=rm.Rayleigh(0.1))
    ds = rm.simulate(body, rm.Constant(0.5), duration=40.0)
    energy = ds.energy.values
    assert (np.diff(energy) <= 1e-8).all()
    assert energy[-1] < energy[0] - 1e-3
    rest = rm.equilibria(body, 0.5)
    assert float(ds.stretch[-1]) == pytest.approx(float(rest.stretch[0]), abs=0.05)


def test_motion_under_an_even_load_runs_back() -> None:
    """(0.4 sin w tau)**2 is even around whole and half periods: forward, then back."""
    drive = rm.SineSquared(0.4, 1.25)
    body = actuator(c=0.5, prestress=0.3)
    there = rm.poincare_section(body, drive, periods=12, tolerance=1e-10)
    turned = (float(there.stretch[-1]), -float(there.stretch_rate[-1]))
    back = rm.poincare_section(body, drive, periods=12, initial=turned, tolerance=1e-10)
    assert int(there.status) == int(back.status) == 1
    assert back.stretch.values == pytest.approx(there.stretch.values[::-1], abs=1e-8)
    assert back.stretch_rate.values == pytest.approx(-there.stretch_rate.values[::-1], abs=1e-8)


def test_error_follows_the_tolerance() -> None:
    """Error follows tolerance: median error against tolerance 1e-3 ... 1e-12, slope 0.8 to 1.2."""
    rng = np.random.default_rng(8)
    values = {
        "c": 10.0 ** rng.uniform(-2, 0, 24),
        "temperature": 300.0 * rng.uniform(0.5, 2.0, 24),
        "prestress": rng.uniform(-0.5, 1.0, 24),
        "m": rng.uniform(-0.5, 0.5, 24),
    }
    over = {name: xr.DataArray(v, dims="case") for name, v in values.items()}
    body, times = actuator(), np.linspace(0.0, 12.0, 25)
    drive = rm.Sine(0.3, 1.7)
    exact = rm.simulate(body, drive, times=times, over=over, tolerance=1e-13)
    tolerances = 10.0 ** -np.arange(3.0, 13.0)
    medians = []
    for tolerance in tolerances:
        ds = rm.simulate(body, drive, times=times, over=over, tolerance=tolerance)
        difference = np.abs(ds.stretch - exact.stretch).max("time")
        medians.append(float(difference.where(ds.status == 1).median()))
    slope = np.polyfit(np.log10(tolerances[:-1]), np.log10(medians[:-1]), 1)[0]
    assert 0.8 <= slope <= 1.2
    assert (np.array(medians) <= tolerances).all()

"""Heat: the exact adiabat, the isothermal limit, balances of energy and entropy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

import remanent as rm
from remanent.derivation import block, lagrange
from remanent.derivation.symbols import LOAD, loads_in_symbols, parameter_symbol
from remanent.models import heat

DRIVE = rm.SineSquared(0.4, 1.25)


def strain_energy(ds: Any) -> np.ndarray:
    one, two = (ds["stretch" if "stretch" in ds else f"stretch_{i}"].values for i in (1, 2))
    return np.asarray((one**2 + two**2 + (one * two) ** -2 - 3.0) / 2.0)


@pytest.mark.parametrize("load", [0.3, (0.3, -0.2)])
def test_adiabat_without_dissipation(load: Any) -> None:
    """T = T_i exp[(W - W_i)/(rho c_p T0)], at any coupling."""
    k, first = 0.02, 350.0
    body = rm.Actuator(temperature=first, prestress=load, heat=rm.Heat(k))
    ds = rm.simulate(body, DRIVE, duration=30.0, tolerance=1e-9)
    energy = strain_energy(ds)
    exact = first * np.exp(k * (energy - energy[0]))
    assert np.ptp(exact) > 0.1
    error = float(ds.error)
    assert np.abs(ds.body_temperature.values - exact).max() <= error * (1.0 + first * k * 10.0)


def test_isothermal_limit() -> None:
    """Fast exchange, or little coupling, holds the temperature: the motion is the plain one."""
    times = np.linspace(0.0, 20.0, 41)
    plain = rm.simulate(rm.Actuator(temperature=320.0), DRIVE, times=times)
    for exchanging, most in ((rm.Heat(1e-2, 200.0), 2e-3), (rm.Heat(1e-9), 1e-6)):
        ds = rm.simulate(rm.Actuator(temperature=320.0, heat=exchanging), DRIVE, times=times)
        assert float(abs(ds.body_temperature - 320.0).max()) < 320.0 * most
        assert float(abs(ds.stretch - plain.stretch).max()) < most


def test_a_warm_body_cools_as_newton_says() -> None:
    """At rest without load: theta - theta_env decays with the rate of exchange."""
    body = rm.Actuator(temperature=300.0, heat=rm.Heat(2e-4, 0.3))
    times = np.linspace(0.0, 10.0, 21)
    ds = rm.simulate(body, rm.Constant(0.0), times=times, initial=(1.0, 0.0, 340.0))
    exact = 300.0 + 40.0 * np.exp(-0.3 * times)
    assert np.abs(ds.body_temperature.values - exact).max() <= float(ds.error) + 1e-10


FULL: dict[str, Any] = {
    "heat": rm.Heat(5e-3, 0.2),
    "magnet": rm.Magnet(-1e-3),
    "dissipation": (rm.Zener(0.5, 0.8), rm.KelvinVoigt(0.05)),
}


@pytest.mark.parametrize("load", [0.3, (0.3, -0.2)])
@pytest.mark.parametrize("exchange", [0.0, 0.2])
def test_energy_and_entropy_balance(load: Any, exchange: float) -> None:
    """Energy and work: both balances close within the error; entropy is never destroyed."""
    body = rm.Actuator(temperature=320.0, prestress=load, **FULL).replace(
        heat=rm.Heat(5e-3, exchange)
    )
    ds = rm.energy_balance(body, DRIVE, duration=20.0)
    slack = float(ds.error) * 10.0
    assert float(abs(ds.balance).max()) <= slack
    assert float(abs(ds.entropy_balance).max()) <= slack
    assert (np.diff(ds.entropy_produced.values) >= -1e-12).all()
    assert float(ds.entropy_produced[-1]) > 1e-3
    if exchange == 0.0:
        assert float(abs(ds.heat_given_off).max()) == 0.0


def test_the_rate_of_temperature_is_the_one_written_out() -> None:
    """rho c_p T' = (T/T0) d(f Psi_s + psi_v)/dt + D - h (T - T_env) - T alpha d(m x)/dt."""
    actuator = rm.Actuator(heat=rm.Heat(), dissipation=rm.Zener(0.5, 0.8), magnet=rm.Magnet(-1e-3))
    motion = block.build_motion(actuator, rm.Sine(0.3, 1.0))
    system = lagrange.build_first_order_form(motion)
    rates = dict(zip(system.state_symbols, system.rates, strict=True))
    symbols = {s.name: s for s in system.state_symbols}
    x, v = symbols["stretch"], symbols["stretch_rate"]
    xi, T = symbols["dissipation.0.viscous_stretch"], symbols["body_temperature"]
    p = {name: parameter_symbol(name) for name in actuator.parameter_values()}
    mu, tr = p["dissipation.0.modulus"], p["dissipation.0.relaxation_time"]
    T0, outside = p["reference_temperature"], p["temperature"]
    flow = T / T0 / (6 * tr) * (x**2 / xi**2 - xi**4 / x**4)
    spring = mu / 2 * (2 * x**2 / xi**2 + xi**4 / x**4 - 3)
    stored = p["material.entropic_fraction"] * (2 * x**2 + x**-4 - 3) / 2 + spring
    drive = rm.Sine(0.3, 1.0)
    m, m_rate = (
        loads_in_symbols(laws, drive)[LOAD]
        for laws in (drive.loads_by_name, drive.load_rates_by_name)
    )
    field = m_rate * x**-2 - 2 * m * x**-3 * v
    warmed = sp.diff(stored, x) * v + sp.diff(stored, xi) * xi * flow
    right = T / T0 * warmed + 12 * mu * tr * flow**2
    right -= T * p["magnet.temperature_coefficient"] * field
    k, h = p["heat.coupling"], p["heat.exchange"]
    expected = k * T0 * right - h * (T - outside)
    found = rates[T]
    for symbol, meaning in reversed(list(system.definitions.items())):
        found = found.subs(symbol, meaning)
    assert sp.simplify(found - expected) == 0


def test_entropy_is_minus_the_slope_of_the_free_energy() -> None:
    """At rest and without field s = ln(theta)/k, that of a constant heat capacity."""
    theta, k = sp.symbols("theta k", positive=True)
    assert sp.simplify(-sp.diff(heat.caloric_free_energy(theta, k, sp), theta)) == sp.log(theta) / k


def test_energetic_rubber_does_not_warm() -> None:
    """f = 0: nothing of the strain energy is entropic."""
    body = rm.Actuator(material=rm.NeoHookean(0.0), heat=rm.Heat(0.02))
    ds = rm.simulate(body, DRIVE, duration=10.0)
    assert float(abs(ds.body_temperature - 293.0).max()) <= 1e-9


@pytest.mark.slow
def test_damped_bodies_grow_warm_and_find_a_periodic_state() -> None:
    """Dissipation and exchange of heat balance on a stable orbit that is warmer than the
    surroundings."""
    body = rm.Actuator(heat=rm.Heat(1e-2, 0.05), dissipation=rm.KelvinVoigt(0.1))
    orbit = rm.periodic_orbits(body, DRIVE)
    assert orbit.stability.values.tolist() == ["stable"]
    assert float(orbit.initial.values[0, 2]) > 293.0


def test_adiabatic_bodies_have_no_orbit_of_their_own() -> None:
    """Without exchange of heat a damped body warms for ever: periodic orbits are refused."""
    body = rm.Actuator(heat=rm.Heat(1e-2), dissipation=rm.KelvinVoigt(0.1))
    with pytest.raises(rm.InputError, match="exchange heat"):
        rm.periodic_orbits(body, DRIVE)


def test_loads_that_jump_are_refused_where_they_would_warm() -> None:
    """Where heat depends on the rate of the load, a load that jumps is refused."""
    warm = rm.Actuator(heat=rm.Heat(), magnet=rm.Magnet(-1e-3))
    steps = rm.Steps([0.0, 1.0], [0.1, 0.2])
    with pytest.raises(rm.InputError, match="rate of its load in closed form"):
        rm.simulate(warm, steps, duration=2.0)
    rm.simulate(warm.replace(magnet=rm.Magnet()), steps, duration=2.0)

"""The equations of motion that the energies lead to, against [Thermal] and identities."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp

from remanent.derivation import block, lagrange
from remanent.derivation.derive import derive
from remanent.derivation.readable import equations, second_order_equations
from remanent.derivation.symbols import parameter_symbol, time_derivative
from remanent.models import heat
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Dissipation, KelvinVoigt, Rayleigh, Zener
from remanent.models.drives.waves import Constant, SineSquared
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.strain_energy import StrainEnergy
from remanent.models.temperature_shift import WLF
from tests.repetitions import fast_and_slow

STRETCH, RATE = sp.Symbol("stretch", positive=True), sp.Symbol("stretch_rate", real=True)
C, T, T0 = (parameter_symbol(n) for n in ("c", "temperature", "reference_temperature"))
S, M, ETA, F = (
    parameter_symbol(n)
    for n in ("prestress", "m", "dissipation.0.eta", "material.entropic_fraction")
)
ALPHA = parameter_symbol("magnet.temperature_coefficient")
PLAIN = {F: 1, ALPHA: 0}


def written_out(expression: Any, system: Any) -> Any:
    """The expression in numeric fields and state only."""
    for symbol, meaning in reversed(list(system.definitions.items())):
        expression = expression.subs(symbol, meaning)
    return expression


def inertia(stretch: Any) -> Any:
    """M of equation 16."""
    return 1 + 2 * C * stretch**-6


def equation_16(stretch: Any, rate: Any, acceleration: Any, theta: Any, load: Any) -> Any:
    """Left side of [Thermal, eq. 16]."""
    force = theta * (stretch - stretch**-5) - S + load * stretch**-3
    return inertia(stretch) * acceleration - 6 * C * stretch**-7 * rate**2 + sp.Integer(3) * force


def test_acceleration_is_equation_16() -> None:
    """The derived acceleration solves [Thermal, eq. 16] identically."""
    system = derive(Actuator(), Constant(0.1))
    acceleration = written_out(system.rates[1], system).subs(PLAIN)
    assert sp.simplify(equation_16(STRETCH, RATE, acceleration, T / T0, M)) == 0
    assert system.rates[0] == RATE
    assert system.state_symbols == (STRETCH, RATE)


def test_readable_equation_is_equation_16() -> None:
    """The equation that is shown to readers is [Thermal, eq. 16] too."""
    row = equations(Actuator()).second_order[0]
    theta, load, stiffness = (sp.Symbol(n, positive=True) for n in ("theta", "load", "stiffness"))
    left = row.lhs.subs({sp.Symbol("effective_load", real=True): load, stiffness: theta})
    acceleration = sp.Symbol("stretch_rate'", real=True)
    assert sp.simplify(left - equation_16(STRETCH, RATE, acceleration, theta, load)) == 0


def test_readable_equations_are_typeset() -> None:
    """The equations are LaTeX, with the symbols of the field in place of our names."""
    shown = equations(Actuator(dissipation=Rayleigh(0.1)))
    assert shown._repr_latex_().startswith("$\\displaystyle \\begin{gathered}")
    assert r"\lambda''" in shown.latex
    assert r"\eta_{0}" in shown.latex
    assert "prestress" not in shown.latex


def test_readable_equations_of_branches_and_heat() -> None:
    """Internal variables and temperature have equations and symbols of their own."""
    body = blocks(2).replace(dissipation=Zener(0.5, 2.0), heat=Heat())
    shown = equations(body)
    assert [str(e.lhs) for e in shown.first_order][-1] == "body_temperature'"
    assert len(shown.second_order) == 2
    for letter in (r"\xi_1", r"\mu_v", "t_r", r"T_\infty", r"\lambda_3"):
        assert letter in shown.latex
    assert "viscous" not in shown.latex


def test_long_formulas_are_shown_as_they_are_written() -> None:
    """The magnet's own field and a user's energy stand in the equation unexpanded."""
    solid = StrainEnergy("a*(I1 - 3) + I1**8", {"a": 1.0})
    for actuator in (Actuator(magnet=Magnet(demagnetisation=0.1)), Actuator(material=solid)):
        shown = equations(actuator)
        assert len(shown.latex) < 5000
        assert "Unexpanded" not in str(shown)


def test_kinetic_and_potential_energy_are_those_of_the_lagrangian() -> None:
    """L = M v^2/2 - V is 3/2 of the energies per 8 H L^2 mu, up to a constant."""
    motion = block.build_motion(Actuator(), Constant(0.1))
    potential = written_out(motion.potential_energy, motion).subs(PLAIN)
    kinetic = motion.eliminate_thickness(motion.kinetic_energy)
    bracket = T / T0 * (STRETCH**2 / 2 + STRETCH**-4 / 4) - S * STRETCH - M * STRETCH**-2 / 2
    difference = sp.Rational(3, 2) * potential - 3 * bracket
    assert sp.simplify(sp.diff(difference, STRETCH)) == 0
    assert sp.simplify(kinetic - inertia(STRETCH) * RATE**2 / 3) == 0


def test_energy_is_the_one_promised() -> None:
    """The observable `energy` is the sum that the documentation writes down."""
    system = derive(Actuator(), Constant(0.1))
    energy = written_out(system.observables["energy"], system).subs(PLAIN)
    theta = T / T0
    promised = (
        inertia(STRETCH) * RATE**2 / 3
        + theta * (2 * STRETCH**2 + STRETCH**-4 - 3) / 2
        - 2 * S * (STRETCH - 1)
        - M * STRETCH**-2
    )
    assert sp.simplify(energy - promised) == 0


def test_rayleigh_damping_joins_the_bracket() -> None:
    """eta l' stands inside 3 [...] of equation 16, and takes 2 D from the energy."""
    system = derive(Actuator(dissipation=Rayleigh(0.1)), Constant(0.1))
    acceleration = written_out(system.rates[1], system).subs(PLAIN)
    left = equation_16(STRETCH, RATE, acceleration, T / T0, M) + 3 * ETA * RATE
    assert sp.simplify(left) == 0
    assert sp.simplify(power(system) + 2 * ETA * RATE**2) == 0


def power(system: Any) -> Any:
    """Rate of the energy along the motion."""
    rates = dict(zip(system.state_symbols, system.rates, strict=True))
    energy = written_out(system.observables["energy"], system)
    return written_out(time_derivative(energy, rates), system)


def blocks(coordinates: int) -> Actuator:
    """An actuator of one coordinate or of two."""
    return Actuator() if coordinates == 1 else Actuator(prestress=(0.0, 0.0))


@pytest.mark.parametrize("coordinates", [1, 2])
def test_energy_is_conserved_without_dissipation(coordinates: int) -> None:
    """Under a constant load the rate of the energy vanishes identically."""
    system = derive(blocks(coordinates), Constant(0.1))
    assert sp.simplify(power(system)) == 0


def test_watched_are_time_derivatives_of_the_thickness_stretch() -> None:
    """Watched values are the thickness stretch and its first two time derivatives."""
    system = derive(Actuator(), Constant(0.1))
    watched = [written_out(e, system) for e in system.observable_and_rates]
    acceleration = written_out(system.rates[1], system)
    assert sp.simplify(watched[0] - STRETCH**-2) == 0
    assert sp.simplify(watched[1] + 2 * RATE * STRETCH**-3) == 0
    second = 6 * RATE**2 * STRETCH**-4 - 2 * STRETCH**-3 * acceleration
    assert sp.simplify(watched[2] - second) == 0


@pytest.mark.parametrize("coordinates", [1, 2])
def test_last_watched_quantity_has_the_sign_of_the_rate(coordinates: int) -> None:
    """It is the rate times a function that is positive for positive stretches."""
    system = derive(blocks(coordinates), Constant(0.1))
    rate, sign = (written_out(system.observable_and_rates[k], system) for k in (1, 3))
    assert sp.simplify(rate / sign).is_positive


def test_temperature_scales_out_exactly() -> None:
    """(T; m, S, eta, tau) and (T0; m/th, S/th, eta/sqrt th, tau sqrt th) move alike."""
    system = derive(Actuator(dissipation=Rayleigh(0.1)), Constant(0.1))
    warm = written_out(system.rates[1], system).subs(PLAIN)
    theta = T / T0
    scaled = {T: T0, M: M / theta, S: S / theta, ETA: ETA / sp.sqrt(theta)}
    cold = warm.subs({**scaled, RATE: RATE / sp.sqrt(theta)}, simultaneous=True)
    assert sp.simplify(warm - theta * cold) == 0


def test_small_oscillations() -> None:
    """omega^2 = 3 [th (1 + 5 l^-6) - 3 m l^-4]/(1 + 2 c l^-6) at an equilibrium."""
    system = derive(Actuator(), Constant(0.1))
    acceleration = written_out(system.rates[1], system).subs(PLAIN)
    theta = T / T0
    balance = theta * (STRETCH - STRETCH**-5) + M * STRETCH**-3
    stiffness = -sp.diff(acceleration, STRETCH).subs({S: balance, RATE: 0})
    expected = 3 * (theta * (1 + 5 * STRETCH**-6) - 3 * M * STRETCH**-4) / inertia(STRETCH)
    assert sp.simplify(stiffness - expected) == 0


def test_rotation_law_exerts_no_load() -> None:
    """A magnet that only rotates exerts no load in a uniform stretch."""
    system = derive(Actuator(magnet=Magnet(law="rotation")), SineSquared(0.4, 1.25))
    acceleration = written_out(system.rates[1], system)
    assert not {"b", "sin_pi_phase"} & {s.name for s in acceleration.free_symbols}


def test_magnet_weakens_with_temperature() -> None:
    """Temperature acts on the load by the factor 1 + alpha (T - T0), and by nothing else."""
    system = derive(Actuator(), Constant(0.1))
    acceleration = written_out(system.rates[1], system)
    weakened = acceleration.subs(ALPHA, 0).subs(M, M * (1 + ALPHA * (T - T0)))
    assert sp.simplify(acceleration - weakened) == 0


def test_energetic_elasticity_does_not_depend_on_temperature() -> None:
    """With f = 0 and alpha = 0 neither temperature occurs in the acceleration."""
    system = derive(Actuator(), Constant(0.1))
    acceleration = written_out(system.rates[1], system).subs({F: 0, ALPHA: 0})
    assert not {T, T0} & acceleration.free_symbols


def test_caloric_energy_is_that_of_a_constant_heat_capacity() -> None:
    """-T d2/dT2 of rho c_p [T - T0 - T ln(T/T0)] is rho c_p; at T0 it vanishes, and so
    does its slope."""
    theta, k = sp.symbols("theta k", positive=True)
    energy = heat.caloric_free_energy(theta, k, sp)
    assert sp.simplify(-theta * sp.diff(energy, theta, 2) - 1 / k) == 0
    assert energy.subs(theta, 1) == 0
    assert sp.diff(energy, theta).subs(theta, 1) == 0


# Two coordinates ----------------------------------------------------------------------


def test_two_equal_stretches_move_as_one() -> None:
    """With equal loads and stretches two coordinates have the equation of one."""
    one = derive(Actuator(), Constant(0.1))
    two = derive(blocks(2), Constant(0.1))
    (q1, v1, q2, v2), loads = (
        two.state_symbols,
        (parameter_symbol(f"prestress_{i}") for i in (1, 2)),
    )
    equal = {q1: STRETCH, q2: STRETCH, v1: RATE, v2: RATE, **dict.fromkeys(loads, S)}
    for rate in (two.rates[1], two.rates[3]):
        difference = written_out(rate, two).subs(equal) - written_out(one.rates[1], one)
        assert sp.simplify(difference) == 0
    assert "energy" in one.observables
    for name, observable in one.observables.items():
        both = written_out(two.observables[name], two).subs(equal)
        assert sp.simplify(both - written_out(observable, one)) == 0


def test_lagrange_equations_of_two_stretches() -> None:
    """M and f against the energies on the page of two directions, along a motion."""
    motion = block.build_motion(Actuator(edges=(1.0, 2.0)), Constant(0.1))
    kinetic, potential = (
        motion.eliminate_thickness(motion.kinetic_energy),
        motion.eliminate_thickness(motion.potential_energy),
    )
    tau = sp.Symbol("tau")
    path = [sp.Function(f"q{i}", positive=True)(tau) for i in (1, 2)]
    on_path = dict(zip(motion.coordinates, path, strict=True))
    on_path |= dict(zip(motion.rates, (sp.diff(q, tau) for q in path), strict=True))
    dotted = {sp.Symbol(f"{v.name}'", real=True): sp.diff(on_path[v], tau) for v in motion.rates}
    assert len(motion.coordinates) == 2
    for q, v, row in zip(
        motion.coordinates, motion.rates, second_order_equations(motion), strict=True
    ):
        momentum = sp.diff(kinetic, v).subs(on_path)
        force = sp.diff(kinetic - potential, q).subs(on_path)
        expected = 3 * (sp.diff(momentum, tau) - force)
        assert sp.simplify(row.lhs.subs(dotted).subs(on_path) - expected) == 0


def test_loss_of_symmetry() -> None:
    """omega_a^2 = 3 [th (1 + l^-6) - m l^-4] for stretches that part from each other."""
    system = derive(blocks(2), Constant(0.1))
    q1, v1, q2, v2 = system.state_symbols
    theta = T / T0
    balance = theta * (STRETCH - STRETCH**-5) + M * STRETCH**-3
    loads = {parameter_symbol(f"prestress_{i}"): balance for i in (1, 2)}
    rest = {q1: STRETCH, q2: STRETCH, v1: 0, v2: 0, **loads}
    acceleration = written_out(system.rates[1], system).subs(PLAIN)
    apart = sp.diff(acceleration, q1) - sp.diff(acceleration, q2)
    expected = 3 * (theta * (1 + STRETCH**-6) - M * STRETCH**-4)
    assert sp.simplify(apart.subs(rest) + expected) == 0


# Internal variables -------------------------------------------------------------------


ELEMENTS: dict[str, Dissipation] = {
    "dashpot": Rayleigh(0.1),
    "fluid": KelvinVoigt(0.1),
    "zener": Zener(0.5, 2.0),
    "shifted": Zener(0.5, 2.0, WLF(8.0, 200.0)),
}


@pytest.mark.parametrize("weighted", [pytest.param(False, marks=pytest.mark.slow), True])
@pytest.mark.parametrize("element", fast_and_slow(ELEMENTS, ("dashpot", "zener")))
def test_accelerations_solve_lagranges_equations(element: Dissipation, weighted: bool) -> None:
    """The short form that is computed is M^-1 f of the long one that is shown."""
    for actuator in (blocks(1), blocks(2).replace(edges=(1.0, 2.0) if weighted else None)):
        motion = block.build_motion(actuator.replace(dissipation=element), Constant(0.1))
        system = lagrange.build_first_order_form(motion)
        mass, force = lagrange.mass_matrix_and_force(motion)
        n = len(motion.coordinates)
        solved = sp.Matrix([written_out(system.rates[2 * i + 1], system) for i in range(n)])
        residual = (mass * solved - force).applyfunc(lambda e: written_out(e, system))  # noqa: B023
        assert sp.simplify(residual) == sp.zeros(n, 1)


@pytest.mark.parametrize("coordinates", [1, 2])
def test_internal_variables_take_from_the_energy_what_they_dissipate(coordinates: int) -> None:
    """dE/dtau = -2 eta (e1^2 + e2^2 + (e1 + e2)^2), e = x'/x: -12 eta e^2 if equal."""
    actuator = blocks(coordinates).replace(dissipation=Zener(0.5, 2.0))
    system = derive(actuator, Constant(0.1))
    rates = dict(zip(system.state_symbols, system.rates, strict=True))
    internal = system.state_symbols[2 * coordinates :]
    assert len(internal) == coordinates
    e1, e2 = (rates[x] / x for x in (internal[0], internal[-1]))
    eta = parameter_symbol("dissipation.0.modulus") * parameter_symbol(
        "dissipation.0.relaxation_time"
    )
    lost = 2 * eta * (e1**2 + e2**2 + (e1 + e2) ** 2)
    assert sp.simplify(power(system) + written_out(lost, system)) == 0


def test_internal_variable_of_equal_stretches() -> None:
    """x'/x = (th/6 t_r) (l^2 x^-2 - l^-4 x^4)."""
    system = derive(Actuator(dissipation=Zener(0.5, 2.0)), Constant(0.1))
    x = system.state_symbols[2]
    time = parameter_symbol("dissipation.0.relaxation_time")
    expected = T / T0 / (6 * time) * (STRETCH**2 / x**2 - x**4 / STRETCH**4)
    assert x.name == "dissipation.0.viscous_stretch"
    assert sp.simplify(written_out(system.rates[2], system) / x - expected) == 0

"""Equations of systems that users write, against other derivations of them."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy.calculus.euler import euler_equations

import remanent as rm
from remanent._instructions import program_cost
from remanent.codegen.field import vector_field_for
from remanent.codegen.formula_program import program_of_formula
from remanent.derivation.expansion import expanded_sizes
from remanent.derivation.linear_solve import nested_in_pair, solve_pair_expanded
from remanent.models.formula import parse_formula

#: A load that enters the rates at once.
DRIVE = rm.Sine(0.3, 1.3, mean=0.1, phase=0.4)
#: Kinetic energy, potential energy and dissipation of systems of two coordinates.
PAIRS = [
    ("u_rate**2 + v_rate**2/2 + u_rate*v_rate*cos(u - v)", "-2*cos(u) - cos(v) - load*sin(u)", "0"),
    ("(1 + u**2)*u_rate**2/2 + (2 + sin(v))*v_rate**2/2 + u*v_rate", "u**4 + v**2 + u*v*load",
     "0.1*(u_rate - v_rate)**2"),
    ("(u_rate**2 + v_rate**2)/2 + v*u_rate - u*v_rate", "u**2 + exp(v) - v*load", "v_rate**2"),
]  # fmt: skip


def rates_at(system: rm.LagrangianSystem, states: np.ndarray, load: float) -> np.ndarray:
    """Rates of the field under a constant load, array (point, state)."""
    field = vector_field_for(system, rm.Constant(load))
    values = system.parameter_values() | {"m": load}
    columns = [values[name] for name in field.parameter_names]
    rates = field.rates([0.0, *states.T, *columns], functions=np)
    return np.stack([np.broadcast_to(r, len(states)) for r in rates], axis=1)


@pytest.mark.parametrize(("kinetic", "potential", "dissipation"), PAIRS)
def test_accelerations_solve_the_euler_lagrange_equations(
    kinetic: str, potential: str, dissipation: str
) -> None:
    """SymPy's own Euler-Lagrange operator, with -dD/dq', vanishes at the accelerations."""
    system = rm.LagrangianSystem(
        coordinates=("u", "v"), kinetic=kinetic, potential=potential, dissipation=dissipation
    )
    states = np.random.default_rng(3).uniform(-0.9, 0.9, (20, 4))
    rates = rates_at(system, states, 0.25)
    t = sp.Symbol("t")
    q = [sp.Function(name)(t) for name in ("u", "v")]
    put = {"u": q[0], "v": q[1], "u_rate": q[0].diff(t), "v_rate": q[1].diff(t), "load": 0.25}
    lagrangian = sp.sympify(kinetic, put) - sp.sympify(potential, put)
    names = sp.symbols("u_rate v_rate")
    states_of_two = sp.symbols("u v u_rate v_rate")
    motion = (*q, q[0].diff(t), q[1].diff(t))
    resistance = [
        sp.diff(sp.sympify(dissipation), name).subs(dict(zip(states_of_two, motion, strict=True)))
        for name in names
    ]
    flat = sp.symbols("u v du dv ddu ddv")
    into = [(q[0].diff(t, 2), flat[4]), (q[1].diff(t, 2), flat[5]), (q[0].diff(t), flat[2]),
            (q[1].diff(t), flat[3]), (q[0], flat[0]), (q[1], flat[1])]  # fmt: skip
    equations = [
        (row.lhs - d).subs(into)
        for row, d in zip(euler_equations(lagrangian, q, t), resistance, strict=True)
    ]
    value = sp.lambdify(flat, equations)
    for state, rate in zip(states, rates, strict=True):
        left = value(state[0], state[2], state[1], state[3], rate[1], rate[3])
        np.testing.assert_allclose(left, 0.0, atol=1e-12)


@pytest.mark.slow
@settings(max_examples=15)
@given(st.integers(0, 10**6))
def test_four_coordinates_are_solved(seed: int) -> None:
    """A chain of four with a full mass matrix: M q'' = F by NumPy's solver."""
    rng = np.random.default_rng(seed)
    lower = np.tril(rng.uniform(-1.0, 1.0, (4, 4)))
    mass = np.round(lower @ lower.T + np.eye(4), 3)
    stiffness = np.round(rng.uniform(0.5, 2.0, 4), 3)
    names = [f"q_{k}" for k in range(4)]
    kinetic = " + ".join(
        f"({mass[i, j]})*{names[i]}_rate*{names[j]}_rate/2" for i in range(4) for j in range(4)
    )
    potential = " + ".join(f"{k}*{name}**2/2" for k, name in zip(stiffness, names, strict=True))
    system = rm.LagrangianSystem(
        coordinates=names, kinetic=kinetic, potential=f"{potential} - load*q_3"
    )
    states = rng.uniform(-1.0, 1.0, (3, 8))
    found = rates_at(system, states, 0.7)[:, 1::2]
    force = -stiffness * states[:, ::2] + 0.7 * np.eye(4)[3]
    expected = np.linalg.solve(mass, force.T).T
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-12)


def test_a_coordinate_without_kinetic_energy_is_of_first_order() -> None:
    """eta xi' = k (x - xi), and the spring pulls x by as much."""
    system = rm.LagrangianSystem(
        coordinates=("x", "xi"),
        kinetic="x_rate**2/2",
        potential="x**2/2 + k*(x - xi)**2/2 - load*x",
        dissipation="eta*xi_rate**2/2",
        parameters={"k": 0.5, "eta": 0.3},
    )
    x, v, xi = states = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 6))
    found = rates_at(system, states.T, 0.2)
    np.testing.assert_allclose(found[:, 1], -x - 0.5 * (x - xi) + 0.2, atol=1e-14)
    np.testing.assert_allclose(found[:, 2], 0.5 * (x - xi) / 0.3, atol=1e-14)
    np.testing.assert_array_equal(found[:, 0], v)


def test_a_dashpot_between_two_coordinates_of_first_order() -> None:
    """A damping matrix that is not diagonal: (D'' ) q' = -dV/dq by NumPy's solver."""
    system = rm.LagrangianSystem(
        coordinates=("u", "w"),
        kinetic="0",
        potential="u**2/2 + w**4/4 - load*w",
        dissipation="(u_rate - w_rate)**2/2 + w_rate**2",
    )
    u, w = states = np.random.default_rng(2).uniform(-1.0, 1.0, (2, 5))
    force = np.stack([-u, -(w**3) + 0.4])
    expected = np.linalg.solve(np.array([[1.0, -1.0], [-1.0, 3.0]]), force).T
    np.testing.assert_allclose(rates_at(system, states.T, 0.4), expected, atol=1e-14)


@pytest.mark.parametrize(("kinetic", "potential", "dissipation"), PAIRS)
def test_energy_changes_by_work_and_dissipation(
    kinetic: str, potential: str, dissipation: str
) -> None:
    """stored' = drive power - dissipated power along any motion."""
    system = rm.LagrangianSystem(
        coordinates=("u", "v"), kinetic=kinetic, potential=potential, dissipation=dissipation
    )
    run = rm.energy_balance(system, DRIVE, duration=8.0, initial=(0.2, 0.1, -0.3, 0.2))
    assert float(np.abs(run.balance).max()) <= float(run.balance_error)
    assert float(np.abs(run.drive_work).max()) > 1e-3


def test_a_formula_becomes_the_program_of_its_value() -> None:
    """A recorded formula has the values of the formula itself, also of what is observed."""
    field = vector_field_for(rm.Actuator(), DRIVE)
    text = "2*thickness_stretch**3 - sqrt(stretch)*exp(-c) + 1/(2 + cos(stretch_rate)) - 3**c"
    formula = parse_formula(text)
    program = program_of_formula(field, formula)
    rng = np.random.default_rng(0)
    inputs = rng.uniform(0.5, 1.5, len(field.input_names))
    by_name = dict(zip(field.input_names, inputs, strict=True))
    by_name["thickness_stretch"] = by_name["stretch"] ** -2
    (found,) = program(list(inputs), functions=np)
    np.testing.assert_allclose(found, formula(by_name, np), rtol=1e-14)


def test_a_high_power_of_a_sum_is_not_written_out() -> None:
    """(k y - load - x)^40 has 12 341 terms; its powers are multiplied instead.

    The value is that of the formula.
    """
    formula = "(k*y - (load + x))**40"
    first = rm.FirstOrderSystem(rates={"x": formula, "y": "load"}, parameters={"k": 0.2})
    second = rm.LagrangianSystem(
        coordinates=("x", "y"), kinetic="(x_rate**2 + y_rate**2)/2", potential=formula,
        parameters={"k": 0.2},
    )  # fmt: skip
    for system in (first, second):
        assert program_cost(vector_field_for(system, DRIVE).rates) < 60
    field = vector_field_for(first, rm.Constant(0.1))
    values = {"k": 0.2, "m": 0.1}
    (rate, _) = field.rates(
        [0.0, -1.1, 0.3, *(values[name] for name in field.parameter_names)], functions=np
    )
    assert rate == pytest.approx((0.2 * 0.3 - (0.1 - 1.1)) ** 40, rel=1e-13)


@given(power=st.integers(1, 4), other=st.integers(-3, 3))
@settings(max_examples=20)
def test_terms_are_counted_without_writing_them_out(power: int, other: int) -> None:
    """No more terms than were counted; as many of a power of a sum."""
    x, y, z = sp.symbols("x y z")
    alone = (x + y + z) ** power
    assert expanded_sizes(alone)[0] == len(sp.Add.make_args(sp.expand(alone)))
    mixed = alone * (x - 2) ** other + 1 / (1 + y)
    counted = expanded_sizes(mixed)
    for part, most in zip(sp.fraction(sp.cancel(mixed)), counted, strict=True):
        assert len(sp.Add.make_args(sp.expand(part))) <= most


def test_numbers_with_many_digits_are_rounded_and_too_large_ones_refused() -> None:
    """0.7^40 at rest is a quotient of integers beyond 1e308; 1e300^2 is no float at all."""
    system = rm.FirstOrderSystem(rates={"x": "cos(x**40)**0.5"}, rest={"x": 0.7})
    motion = rm.simulate(system, rm.Constant(0.0), duration=0.1)
    assert float(motion.x[-1]) == pytest.approx(0.8, abs=1e-8)
    large = rm.FirstOrderSystem(rates={"x": "exp(-(1e300)**2)*x"})
    with pytest.raises(rm.InputError, match="large numbers"):
        rm.simulate(large, rm.Constant(0.0), duration=0.1)


@pytest.mark.parametrize("power", ["(-1)**x", "(0.0 - x/x)**x", "(-sqrt(2))**(2*x)", "(-2)**k"])
def test_powers_of_negative_numbers_are_refused(power: str) -> None:
    """Their logarithm is complex, also in a rate that nothing differentiates."""
    system = rm.FirstOrderSystem(
        rates={"x": "-x", "y": f"{power} + k"}, parameters={"k": 1.0}, rest={"x": 1.0}
    )
    with pytest.raises(rm.InputError, match="powers, roots and logarithms of negative numbers"):
        rm.rates(system, rm.Constant(0.0))


def test_whole_powers_of_negative_numbers_are_numbers() -> None:
    """(-2)^3 x + (-2)^-1 is -8 x - 1/2."""
    system = rm.FirstOrderSystem(rates={"x": "(-2)**3*x + (-2)**(-1)"})
    assert float(rm.rates(system, rm.Constant(0.0))(0.0, [1.5])[0]) == -12.5


@given(
    st.lists(st.tuples(*[st.integers(-4, 4)] * 2, *[st.integers(0, 2)] * 3), min_size=1, max_size=6)
)
@settings(max_examples=40)
def test_common_factors_change_no_value(rows: list[tuple[int, ...]]) -> None:
    """A sum of powers of two coordinates, a rate, a function and a parameter, nested."""
    x, y, v, a = sp.symbols("x y v a")
    factors = (x, y, v, sp.cos(x), a)
    terms = [
        sp.Rational(n + 1, 3) * sp.Mul(*map(sp.Pow, factors, row)) for n, row in enumerate(rows)
    ]
    nested = nested_in_pair(sp.Add(*terms), (x, y, v))
    values = {
        x: sp.Rational(7, 5),
        y: sp.Rational(-3, 4),
        v: sp.Rational(5, 3),
        a: sp.Rational(2, 7),
    }
    product = values[x] * values[y]
    own = {sp.Symbol("pair.product", real=True): product}
    own |= {sp.Symbol("pair.inverse_product", real=True): 1 / product}
    left = nested.subs(own).subs(values) - sp.Add(*terms).subs(values)
    assert abs(sp.N(left, 30)) < 1e-25


def test_powers_are_counted_to_take_them_out_of_sums() -> None:
    """A power of a rate is a factor as often as its exponent says; of 1/x only 1/(x y) is left."""
    x, y, v = sp.symbols("x y v")
    inverse = sp.Symbol("pair.inverse_product", real=True)
    nested = nested_in_pair(v**3 + v**2 * y, (x, y, v))
    assert nested == sp.Mul(v**2, v + y, evaluate=False)
    nested = nested_in_pair(v / x**2 + v**2 / (x * y), (x, y, v))
    assert {power.base for power in nested.atoms(sp.Pow) if power.exp.is_negative} == set()
    assert nested.has(inverse)
    assert sp.expand(nested.subs(inverse, 1 / (x * y)) - v / x**2 - v**2 / (x * y)) == 0


def test_a_square_of_a_product_is_taken_once() -> None:
    """x^2 v^2 is the square of x v, one multiplication less than a product of two squares."""
    x, y, v = sp.symbols("x y v")
    assert nested_in_pair(x**2 * v**2, (x, y, v)) == sp.Pow(x * v, 2, evaluate=False)
    assert nested_in_pair(x * v, (x, y, v)) == x * v


def test_cramers_rule_solves_the_equations() -> None:
    """A x = b in whole numbers, for a matrix and right sides that vary with both coordinates."""
    x, y, v = moving = sp.symbols("x y v")
    matrix = sp.Matrix([[3 + x**2, x * y / 2], [x * y / 2, 2 + y**2]])
    right = [x * v**2 - y, 5 * y / 3 + v / x]
    definitions, solution = solve_pair_expanded(matrix, right, moving)
    values = {x: sp.Rational(7, 5), y: sp.Rational(-3, 4), v: sp.Rational(5, 3)}
    for symbol, meaning in definitions.items():
        values[symbol] = sp.nsimplify(meaning.subs(values))
    found = sp.Matrix([values[symbol] for symbol in solution])
    assert matrix.subs(values) * found == sp.Matrix(right).subs(values)


@pytest.mark.parametrize(("rest", "positive"), [(0.5, True), (-0.5, False), (-2.0, False)])
def test_a_variable_is_positive_where_it_is_so_at_rest(rest: float, positive: bool) -> None:
    """A rate 1/x keeps the sign of x, whichever it has at rest."""
    system = rm.FirstOrderSystem(rates={"x": "1/x - x + load"}, rest={"x": rest})
    (variable,) = vector_field_for(system, rm.Constant(0.0)).variables
    assert variable.positive == positive
    assert bool(system.where_admissible({}, rest))
    assert not bool(system.where_admissible({}, -rest))

"""Systems in formulas: what is refused, and what a copy keeps."""

from __future__ import annotations

import pickle
import re
from functools import reduce
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import remanent as rm
from remanent.models.drives.base import Drive
from remanent.models.own_systems.names import RESERVED_NAMES
from remanent.models.plain import from_plain_data, to_plain_data
from remanent.models.system import System
from remanent.results.schema import DESCRIPTIONS
from tests.unit.models.attacks import ATTACKS

#: A pendulum's formulas, from which one is replaced.
PENDULUM: dict[str, Any] = {
    "coordinates": "theta",
    "kinetic": "theta_rate**2/2",
    "potential": "-cos(theta) - load*theta",
    "dissipation": "delta*theta_rate**2/2",
    "parameters": {"delta": 0.1},
}
#: Changes that are refused: the argument that the message names, and words of it.
REFUSED = [
    ({"kinetic": "theta_rate**3"}, "kinetic", "quadratic"),
    ({"kinetic": "sqrt(1 + theta_rate**2)"}, "kinetic", "quadratic"),
    (
        {"coordinates": ("theta", "xi"), "dissipation": "delta*theta_rate**2 + xi_rate**4"},
        "dissipation",
        "quadratic",
    ),
    ({"kinetic": "load*theta_rate**2"}, "kinetic", "load"),
    ({"kinetic": "0", "dissipation": "0", "parameters": {}}, "kinetic", "singular"),
    ({"kinetic": "-theta_rate**2/2"}, "kinetic", "positive"),
    ({"potential": "theta_rate*theta"}, "potential", "theta_rate"),
    ({"potential": "gravity*theta"}, "potential", "gravity"),
    ({"potential": "1/theta"}, "potential", "finite at rest"),
    ({"potential": "__import__('os').system('true')"}, "potential", "never run"),
    ({"potential": "theta.real"}, "potential", "arithmetic"),
    ({"potential": "9**9**9"}, "potential", "powers"),
    ({"observable": "load"}, "observable", "load"),
    ({"coordinates": "omega"}, "coordinates", "omega"),
    ({"coordinates": "2x"}, "coordinates", "letters"),
    ({"coordinates": "cos"}, "coordinates", "function"),
    ({"coordinates": ("theta", "theta")}, "coordinates", "own"),
    ({"coordinates": ()}, "coordinates", "one to"),
    ({"parameters": {"delta": 0.1, "unused": 1.0}}, "parameters", "unused"),
    ({"parameters": {"delta": np.nan}}, "delta", "finite"),
    ({"parameters": 5}, "parameters", "mapping"),
    ({"rest": {"phi": 0.0}}, "rest", "phi"),
    ({"loads": ("theta",)}, "loads", "own"),
    ({"units": {"phi": "m"}}, "units", "phi"),
    ({"symbols": {"theta": 3}}, "symbols", "text"),
]


@pytest.mark.parametrize(("change", "argument", "words"), REFUSED)
def test_what_cannot_be_a_system_is_refused(
    change: dict[str, Any], argument: str, words: str
) -> None:
    """A formula or a name that has no meaning raises `InputError`, which names the argument."""
    with pytest.raises(rm.InputError, match=re.escape(words)) as caught:
        rm.LagrangianSystem(**{**PENDULUM, **change})
    assert caught.value.name == argument


@pytest.mark.parametrize("argument", ["kinetic", "potential", "dissipation", "observable"])
def test_nothing_but_arithmetic_is_a_formula(argument: str) -> None:
    """Attempts to run something or to take long are refused, in every formula of a system."""
    for attack in ATTACKS.values():
        text = attack.replace("I1", "theta").replace("l1", "theta")
        with pytest.raises(rm.InputError, match="A formula is read, never run") as caught:
            rm.LagrangianSystem(**{**PENDULUM, argument: text})
        assert caught.value.name == argument
    with pytest.raises(rm.InputError, match="never run"):
        rm.FirstOrderSystem(rates={"x": "__import__('os').system('true')"})


@pytest.mark.parametrize(
    "name",
    [
        "__class__", "x.real", "x + y", "lambda", "x y", "\u0445", "x\u200b", "2x", "", "os.system",
        "x" * 50, "x;y", "x\n", "sin", "pi", "None", "True",
    ],
)  # fmt: skip
def test_nothing_but_a_plain_word_is_a_name(name: str) -> None:
    """Names of coordinates, parameters, states and loads."""
    one: dict[str, Any] = {"coordinates": "x", "kinetic": "x_rate**2/2", "potential": "x**2/2"}
    for change in ({"coordinates": name}, {"parameters": {name: 1.0}}, {"loads": (name,)}):
        with pytest.raises(rm.InputError) as caught:
            rm.LagrangianSystem(**{**one, **change})
        assert caught.value.name in change
    with pytest.raises(rm.InputError) as caught:
        rm.FirstOrderSystem(rates={name: "0"})
    assert caught.value.name == "rates"


X, THETA = sp.symbols("x theta")
NESTED = reduce(lambda inner, _: sp.sin(inner, evaluate=False), range(2000), THETA)
BRANCHED = reduce(lambda inner, _: sp.sin(inner) * sp.cos(inner), range(60), THETA)
#: SymPy's objects that are no formula, or whose text would mean another one.
NO_FORMULAS = {
    "an unknown function": sp.Function("f")(THETA),
    "another function called sin": sp.Function("sin")(THETA),
    "a symbol like a sum": 2 * sp.Symbol("theta + 1"),
    "a symbol like the number": sp.Symbol("pi") * THETA,
    "a symbol like a keyword": sp.Symbol("lambda"),
    "a symbol with underscores": sp.Symbol("__class__"),
    "a dummy": sp.Dummy("theta"),
    "an imaginary number": sp.I * THETA,
    "infinity": sp.oo,
    "no number": sp.nan,
    "a huge integer": sp.Integer(10) ** 5000 * THETA,
    "a tiny quotient": THETA / sp.Integer(10) ** 400,
    "a derivative": sp.Derivative(sp.Function("f")(THETA), THETA),
    "an integral": sp.Integral(THETA, THETA),
    "an absolute value": abs(THETA),
    "cases": sp.Piecewise((THETA, THETA > 0), (0, True)),
    "a matrix": sp.Matrix([THETA]),
    "a comparison": THETA < 1,
    "deep nesting": NESTED,
    "a part that is in itself twice, sixty times": BRANCHED,
    "a function that is not called": sp.sin,
}


@pytest.mark.parametrize("name", NO_FORMULAS)
def test_other_objects_of_sympy_are_refused(name: str) -> None:
    """At once, and by the name of the argument."""
    with pytest.raises(rm.InputError) as caught:
        rm.LagrangianSystem(**{**PENDULUM, "potential": NO_FORMULAS[name]})
    assert caught.value.name == "potential"
    assert len(str(caught.value)) < 500


def test_the_base_of_the_exponential_is_a_number_of_sympy() -> None:
    """SymPy writes it E, which may be the name of a parameter."""
    energy = sp.E * THETA**2 + sp.Symbol("E") * THETA**2
    system = rm.LagrangianSystem(
        coordinates="theta", kinetic="theta_rate**2/2", potential=energy, parameters={"E": 2.0}
    )
    found = rm.equilibria(system, 0.0, state_box={"theta": (-1.0, 1.0)})
    exact = np.sqrt(2.0 * (np.exp(1.0) + 2.0))
    assert abs(float(found.natural_frequency[0]) - exact) <= float(found.natural_frequency_error[0])


def test_a_coupled_singular_mass_matrix_is_refused() -> None:
    """T = (x' + y')^2/2 gives no acceleration to x - y."""
    with pytest.raises(rm.InputError, match="positive eigenvalues"):
        rm.LagrangianSystem(
            coordinates=("x", "y"), kinetic="(x_rate + y_rate)**2/2", potential="x**2 + y**2"
        )


def test_the_rate_of_an_observable_keeps_its_name() -> None:
    """A state called x_rate that is not the rate of x is refused where x is observed."""
    with pytest.raises(rm.InputError, match="x_rate"):
        rm.FirstOrderSystem(rates={"x": "-x", "x_rate": "x"})
    assert rm.FirstOrderSystem(rates={"x": "x_rate", "x_rate": "-x"}).state_names == (
        "x",
        "x_rate",
    )


def test_every_name_of_drives_and_results_is_reserved() -> None:
    """Names of drives' fields and of results are refused, but those of an actuator's own."""
    drives = [getattr(rm, name) for name in rm.__all__ if name[0].isupper()]
    fields = {
        field
        for cls in drives
        if isinstance(cls, type) and issubclass(cls, Drive)
        for field in cls.example().parameter_values()
        if field.isidentifier()
    }
    assert fields <= RESERVED_NAMES
    actuator = {
        name
        for name in DESCRIPTIONS
        if name.startswith(("stretch", "thickness", "prestress", "edges"))
    }
    actuator |= {"c", "temperature", "reference_temperature", "body_temperature"}
    # Results that hold a damping ratio have no field of a system beside it.
    actuator |= {"shear_modulus", "density", "remanence", "damping_ratio"}
    words = {name for name in DESCRIPTIONS if name.isidentifier()} - actuator
    assert words <= RESERVED_NAMES


@pytest.mark.parametrize("cls", [rm.LagrangianSystem, rm.FirstOrderSystem])
def test_systems_survive_pickling_and_plain_data(cls: type) -> None:
    """A system is equal to what is read back from plain data, and to its pickled copy."""
    system = cls.example()  # type: ignore[attr-defined]
    assert isinstance(system, System)
    assert from_plain_data(to_plain_data(system)) == system
    assert pickle.loads(pickle.dumps(system)) == system  # noqa: S301
    assert hash(system) == hash(system.replace())


def test_replace_merges_parameters() -> None:
    """replace(parameters=...) changes those that are named and keeps the others."""
    system = rm.LagrangianSystem(
        coordinates="x",
        kinetic="mass*x_rate**2/2",
        potential="k*x**2/2",
        parameters={"mass": 2.0, "k": 3.0},
    )
    changed = system.replace(parameters={"k": 5.0})
    assert changed.parameter_values() == {"mass": 2.0, "k": 5.0}
    assert system.with_parameter("mass", 1.0).parameter_values() == {"mass": 1.0, "k": 3.0}
    with pytest.raises(rm.InputError, match="field"):
        system.with_parameter("gravity", 1.0)


def test_sympy_expressions_are_formulas() -> None:
    """A system in SymPy expressions equals the one in text."""
    x, v, load = sp.symbols("x x_rate load")
    one = rm.LagrangianSystem(
        coordinates="x", kinetic=v**2 / 2, potential=-(x**2) / 2 + x**4 / 4 - load * x
    )
    other = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="-x**2/2 + x**4/4 - load*x"
    )
    box = {"x": (-3.0, 3.0)}
    places = [rm.equilibria(s, 0.1, state_box=box).x.values for s in (one, other)]
    np.testing.assert_array_equal(*places)


@given(
    mass=st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6),
    linear=st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3),
)
def test_the_mass_matrix_of_a_quadratic_energy_is_exact(
    mass: list[float], linear: list[float]
) -> None:
    """T = v.(L L^T + 1) v/2 + a.v has the mass matrix L L^T + 1, whatever the linear terms."""
    lower = np.zeros((3, 3))
    lower[np.tril_indices(3)] = mass
    matrix = lower @ lower.T + np.eye(3)
    rates = ["u_rate", "v_rate", "w_rate"]
    terms = [
        f"({float(matrix[i, j])!r})*{rates[i]}*{rates[j]}/2" for i in range(3) for j in range(3)
    ]
    terms += [f"({a!r})*{rate}" for a, rate in zip(linear, rates, strict=True)]
    system = rm.LagrangianSystem(
        coordinates=("u", "v", "w"), kinetic=" + ".join(terms), potential="u**2 + v**2 + w**2"
    )
    np.testing.assert_allclose(system.mass_matrix_at_rest(), matrix, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_the_degree_of_an_energy_does_not_depend_on_its_unit(unit: float) -> None:
    """Quadratic in the rates is quadratic in any unit, and a small quartic part is none."""
    scaled = {
        name: f"({unit!r})*({PENDULUM[name]})" for name in ("kinetic", "potential", "dissipation")
    }
    rm.LagrangianSystem(**{**PENDULUM, **scaled})
    quartic = {"kinetic": f"({unit!r})*(theta_rate**2/2 + theta_rate**4/1000)"}
    with pytest.raises(rm.InputError, match="quadratic"):
        rm.LagrangianSystem(**{**PENDULUM, **scaled, **quartic})


@pytest.mark.parametrize(
    ("potential", "inside", "outside"),
    [("log(x)", 0.5, -0.5), ("1/(3 - x)", 2.9, 3.1), ("(2 + x)**1.5", -1.9, -2.1)],
)
def test_signs_at_rest_bound_the_states(potential: str, inside: float, outside: float) -> None:
    """Arguments of logarithms, denominators and bases of roots keep the sign of rest."""
    system = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential=potential, rest={"x": 1.0}
    )
    assert bool(system.where_admissible({}, inside))
    assert not bool(system.where_admissible({}, outside))


def test_results_carry_the_names_and_units_of_the_user() -> None:
    """Units and symbols of states, their rates, energy and time; rows speak of the observable."""
    system = rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2",
        potential="x**2/2 - load*x",
        units={"x": "mm", "time": "s", "energy": "mJ", "load": "mN"},
        symbols={"x": "u"},
    )
    run = rm.simulate(system, rm.Sine(0.1, 1.3), duration=2.0)
    assert {name: run[name].attrs["units"] for name in ("x", "x_rate", "time", "energy")} == {
        "x": "mm", "x_rate": "mm s-1", "time": "s", "energy": "mJ",
    }  # fmt: skip
    assert run.x_rate.attrs["symbol"] == r"\dot{u}"
    assert run.time.attrs["long_name"] == "time"
    response = rm.frequency_response(system, rm.Sine(0.1, 1.3), [0.5, 0.6], duration=20.0)
    assert response.amplitude.attrs["long_name"] == "x amplitude"
    assert response.amplitude.attrs["units"] == "mm"
    assert response.amplitude_error.attrs["units"] == "mm"
    assert response.omega.attrs["units"] == response.resonance.attrs["units"] == "rad s-1"


def test_loads_and_rates_of_growth_carry_units_of_the_user() -> None:
    """Those of the load, and one over those of time."""
    system = rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2",
        potential="-x**2/2 + x**4/4 - push*x",
        loads=("push",),
        units={"x": "mm", "time": "s", "push": "mN"},
        symbols={"push": "F"},
    )
    box = {"x": (-2.0, 2.0)}
    at_rest = rm.equilibria(system, {"push": 0.1}, state_box=box)
    units = {name: at_rest[name].attrs["units"] for name in ("natural_frequency", "eigenvalues")}
    assert units == {"natural_frequency": "rad s-1", "eigenvalues": "s-1"}
    snaps = rm.snap_through(system, "push.m", (-1.0, 1.0), state_box=box)
    for name in ("fold_push.m", "fold_push.m_error", "snap_push.m"):
        assert snaps[name].attrs["units"] == "mN"
    assert snaps.fold_x.attrs["units"] == snaps.fold_x_error.attrs["units"] == "mm"
    assert snaps["fold_push.m"].attrs["symbol"] == "m_{F}"


@pytest.mark.parametrize(
    "system",
    [
        rm.LagrangianSystem(
            coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 - log(2 + x*load)"
        ),
        rm.FirstOrderSystem(rates={"x": "(1 - x)/(2 + load*x)"}),
    ],
)
def test_loads_may_stand_in_what_keeps_its_sign(system: System) -> None:
    """Motion under a load in a logarithm or a denominator is that of the load's absence at 0."""
    still = rm.simulate(system, rm.Constant(0.0), duration=2.0)
    moved = rm.simulate(system, rm.Sine(0.3, 1.0), duration=2.0)
    assert int(still.status) == int(moved.status) == int(rm.Status.OK)
    assert float(abs(moved.x - still.x).max()) > 1e-3

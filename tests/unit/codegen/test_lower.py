"""Generated code: right to the last digits, and short."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

from remanent._field import Field, Program
from remanent.codegen.build import build_field
from remanent.codegen.lower import DependenceLevel, lower_to_program
from remanent.derivation.derive import derive
from remanent.derivation.motion import FirstOrderForm
from remanent.derivation.unexpanded import Unexpanded
from remanent.models.actuator import Actuator
from remanent.models.dissipation import KelvinVoigt, Rayleigh, Zener
from remanent.models.drives.base import Drive
from remanent.models.drives.chirp import Chirp
from remanent.models.drives.piecewise import Steps
from remanent.models.drives.waves import Constant, Sine, SineSquared
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.named import Ogden
from remanent.models.materials.strain_energy import StrainEnergy
from remanent.models.temperature_shift import WLF
from tests.repetitions import fast_and_slow

X, Y, A, U = sp.symbols("x y a u", positive=True)
LEVELS = {
    X: DependenceLevel.STATE,
    Y: DependenceLevel.STATE,
    A: DependenceLevel.PARAMETER,
    U: DependenceLevel.DRIVE,
}

ARTICLE = SineSquared(0.4, 1.25)
PAIR = (0.0, 1.0)
ZENER = Zener(0.5, 2.0)
MODELS = {
    "article": (Actuator(), ARTICLE),
    "damped": (Actuator(dissipation=Rayleigh(0.1)), Sine(0.1, 1.0)),
    "rotation": (Actuator(magnet=Magnet(law="rotation")), Constant(0.1)),
    "steps": (Actuator(), Steps([0.0], [0.1])),
    "chirp": (Actuator(), Chirp(0.1, 1.0, 2.0, 9.0)),
    "biaxial": (Actuator(prestress=PAIR, dissipation=Rayleigh(0.1)), ARTICLE),
    "unequal edges": (Actuator(edges=(1.0, 0.5)), ARTICLE),
    "fluid": (Actuator(dissipation=KelvinVoigt(0.1)), ARTICLE),
    "fluid in two directions": (Actuator(prestress=PAIR, dissipation=KelvinVoigt(0.1)), ARTICLE),
    "zener": (Actuator(dissipation=ZENER), ARTICLE),
    "shifted": (Actuator(dissipation=Zener(0.5, 2.0, WLF(8.0, 200.0))), ARTICLE),
    "prony": (Actuator(prestress=PAIR, dissipation=(ZENER, ZENER)), ARTICLE),
    "warm": (Actuator(heat=Heat(), dissipation=Rayleigh(0.1)), ARTICLE),
    "warm in two directions": (Actuator(prestress=PAIR, heat=Heat(), dissipation=ZENER), ARTICLE),
}
POLYNOMIAL = StrainEnergy("a*(I1 - 3) + b*log(I2/3)", {"a": 1.0, "b": 0.1})

#: Models with functions, and with parts that are computed as they are written.
OGDEN, OWN_FIELD = Ogden([1.0, 0.1], [2.0, 4.0]), Magnet(-0.001, demagnetisation=0.2)
UNEXPANDED: dict[str, tuple[Actuator, Drive]] = {
    "ogden": (Actuator(material=OGDEN), Constant(0.1)),
    "formula": (Actuator(material=POLYNOMIAL), Constant(0.1)),
    "ogden in two directions": (Actuator(prestress=PAIR, material=OGDEN), Constant(0.1)),
    "formula in two directions": (Actuator(prestress=PAIR, material=POLYNOMIAL), Constant(0.1)),
    "own field": (Actuator(magnet=OWN_FIELD), Constant(0.1)),
}


def program(*outputs: Any, **options: Any) -> Program:
    names = ["x", "y", "a", "u"]
    return lower_to_program(outputs, inputs=names, levels=LEVELS, definitions={}, **options)


def operations(code: Program) -> Counter[str]:
    return Counter(step[0] for step in code.instructions)


def dynamic(code: Program, varying: set[str]) -> Counter[str]:
    """Operations on what varies: what remains when the rest is computed in advance."""
    first = len(code.input_names) + len(code.constants)
    moving = {i for i, name in enumerate(code.input_names) if name in varying}
    counts: Counter[str] = Counter()
    for slot, (operation, *operands) in enumerate(code.instructions, start=first):
        if moving & set(operands):
            moving.add(slot)
            counts[operation] += 1
    return counts


# Law: Generated code ------------------------------------------------------------------


def random_inputs(field: Field, rng: np.random.Generator, count: int) -> np.ndarray:
    """Points over the whole range of use: slender and stout, cold and hot."""
    values = rng.normal(size=(count, len(field.input_names)))
    for i, name in enumerate(field.input_names):
        if name.endswith("temperature"):
            values[:, i] = rng.uniform(150.0, 600.0, count)
        elif name == "c":
            values[:, i] = 10.0 ** rng.uniform(-3.0, 0.0, count)
        elif name == "magnet.temperature_coefficient":
            values[:, i] *= 1e-3
        elif name in ("material.entropic_fraction", "drive_phase"):
            values[:, i] = rng.uniform(0.0, 1.0, count)
        elif ("stretch" in name and not name.endswith("rate")) or name.startswith("edges"):
            values[:, i] = np.exp(rng.normal(0.0, 0.5, count))
        elif name.startswith("material.exponents"):  # near 0 powers hardly differ from 1
            values[:, i] = rng.uniform(1.0, 5.0, count)
        elif name == "heat.coupling":
            values[:, i] = 10.0 ** rng.uniform(-4.0, -3.0, count)
        elif name.endswith(("modulus", "time", "eta", "exchange", "shift.c2")):
            values[:, i] = 10.0 ** rng.uniform(-1.0, 1.0, count)
    return values


class Exact:
    """Values and conditions of expressions at fifty digits."""

    def __init__(self, field: Field, system: FirstOrderForm, expressions: list[Any]) -> None:
        written = [written_out(e, system) for e in expressions]
        symbols = {s.name: s for e in written for s in e.free_symbols}
        self._used = [i for i, name in enumerate(field.input_names) if name in symbols]
        arguments = [symbols[field.input_names[i]] for i in self._used]
        self._function = sp.lambdify(arguments, written, modules="mpmath", cse=True)

    def __call__(self, point: np.ndarray) -> list[tuple[Any, Any]]:
        """For each expression f: f, and the sum of |x df/dx| over its arguments x."""
        step = mpmath.mpf(10) ** -25
        with mpmath.workdps(50):
            x = [mpmath.mpf(float(point[i])) for i in self._used]
            values = self._function(*x)
            varied = [
                self._function(*(v * (1 + step) if i == k else v for i, v in enumerate(x)))
                for k in range(len(x))
            ]
            return [
                (value, sum(abs(other[i] - value) for other in varied) / step)
                for i, value in enumerate(values)
            ]


def written_out(expression: Any, system: FirstOrderForm) -> Any:
    for symbol, meaning in reversed(list(system.definitions.items())):
        expression = sp.sympify(expression).subs(symbol, meaning)
    return sp.sympify(expression).replace(Unexpanded, lambda inside: inside)


@cache
def derived(name: str) -> tuple[Field, FirstOrderForm]:
    actuator, drive = (MODELS | UNEXPANDED)[name]
    return build_field(actuator, drive), derive(actuator, drive)


def check_against_sympy(name: str, count: int) -> None:
    """|computed - exact| <= 8 ulp times the condition number, for every output."""
    field, system = derived(name)
    programs = [field.rates, field.observable_and_rates, *field.observables.values()]
    expressions = [*system.rates, *system.observable_and_rates, *system.observables.values()]
    exact = Exact(field, system, expressions)
    for point in random_inputs(field, np.random.default_rng(1), count):
        computed = [v for code in programs for v in code(list(point), functions=np)]
        for value, (truth, variation) in zip(computed, exact(point), strict=True):
            allowed = 8 * np.finfo(float).eps * max(abs(truth), variation)
            assert abs(mpmath.mpf(float(value)) - truth) <= allowed


@pytest.mark.parametrize("name", fast_and_slow(list(MODELS | UNEXPANDED), slow=("prony",)))
def test_code_agrees_with_sympy(name: str) -> None:
    """The code of every model has the values of its symbolic expressions."""
    check_against_sympy(name, 50)


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_code_agrees_with_sympy_at_many_points(name: str) -> None:
    """The code of every model has the values of its symbolic expressions."""
    check_against_sympy(name, 10_000)


@pytest.mark.parametrize("name", MODELS | UNEXPANDED)
def test_rates_in_fifty_digits(name: str) -> None:
    """The program itself has no rounded constants: with mpmath numbers it is exact."""
    field, system = derived(name)
    energy = field.observables["energy"]
    exact = Exact(field, system, [*system.rates, system.observables["energy"]])
    point = random_inputs(field, np.random.default_rng(2), 1)[0]
    with mpmath.workdps(50):
        values = [mpmath.mpf(float(x)) for x in point]
        computed = [
            v
            for code in (field.rates, energy)
            for v in code(values, functions=mpmath, constant=mpmath.mpf)
        ]
        for value, (truth, variation) in zip(computed, exact(point), strict=True):
            assert abs(value - truth) <= mpmath.mpf(10) ** -47 * max(abs(truth), variation)


def test_jacobian_by_complex_steps() -> None:
    """d(rates)/d(state) by a complex step of 1e-40 against SymPy."""
    field, system = derived("article")
    point = random_inputs(field, np.random.default_rng(3), 1)[0]
    rate = written_out(system.rates[1], system)
    at = {s: float(point[field.input_names.index(s.name)]) for s in rate.free_symbols}
    for symbol in system.state_symbols:
        values = list(point.astype(complex))
        values[field.input_names.index(symbol.name)] += 1e-40j
        computed = field.rates(values, functions=np)[1].imag / 1e-40
        assert computed == pytest.approx(float(sp.diff(rate, symbol).subs(at)), rel=1e-12)


# Economy ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
def test_one_division_by_the_state(name: str) -> None:
    """In each step at most one division depends on the state."""
    field, _ = derived(name)
    for code in (field.rates, field.observable_and_rates):
        assert dynamic(code, {*field.state_names, *field.waveform_names, "drive_phase"})["div"] <= 1


def test_equation_16_is_short() -> None:
    """Sixteen additions and multiplications and a division, and five for the load."""
    field, _ = derived("article")
    counts = dynamic(field.rates, {*field.state_names, *field.waveform_names})
    assert counts["div"] == 1
    assert set(counts) <= {"add", "sub", "mul", "div"}
    assert counts.total() <= 22
    still = build_field(Actuator(), Constant(0.1))
    assert dynamic(still.rates, set(still.state_names)).total() <= 17


def test_powers_share_multiplications() -> None:
    """Powers of one base are built from each other."""
    assert operations(program(X**2 + X**3 + X**6))["mul"] <= 4
    assert operations(program(X**15))["mul"] <= 6


def test_equal_values_are_computed_once() -> None:
    """An expression that occurs several times is computed once."""
    counts = operations(program(A * sp.sin(A), A * sp.sin(A) + U, 1 + sp.sin(A)))
    assert counts == {"sin": 1, "mul": 1, "add": 2}


def test_signs_cost_nothing() -> None:
    """Signs are taken into sums and products; only a bare sign is an operation."""
    assert "neg" not in operations(program(-X - Y + A, -2 * X, X * (A - U) - Y))
    assert operations(program(-X)) == {"neg": 1}


def test_what_is_known_beforehand_is_combined_first() -> None:
    """In a product, constants and parameters are multiplied before the load and the state."""
    code = program(3 * A * U * X)
    assert dynamic(code, {"x", "u"})["mul"] == 2
    assert dynamic(code, {"x"})["mul"] == 1


def test_what_is_computed_as_written_shares_reciprocals() -> None:
    """Negative powers of one base share one division."""
    counts = operations(program(X**-2 + Y * X**-6 - A / X, as_written=True))
    assert counts["div"] == 1


def test_what_is_computed_as_written_does_not_cancel() -> None:
    """(1 - x)^2 near x = 1; expanded, it would keep no digit."""
    (value,) = program((1 - X) ** 2, as_written=True)([1.0 + 2.0**-40, 0, 0, 0], functions=np)
    assert value == 2.0**-80


def test_what_is_marked_is_not_expanded() -> None:
    """Expanded, (x - 1) (x + 1) is shorter, but x^2 is rounded; a marked power stays a power."""
    small = 2.0**-30
    factors = (Unexpanded(X - 1), X - 1)
    marked, free = (program(e * (X + 1))([1 + small, 0, 0, 0], functions=np)[0] for e in factors)
    assert (marked, free) == (2 * small + small**2, 2 * small)
    (slope,) = program(sp.diff(Unexpanded((X - 1) ** 8), X))([1 + 2.0**-10, 0, 0, 0], functions=np)
    assert slope == 8 * 2.0**-70


def test_a_logarithm_near_one_keeps_its_digits() -> None:
    """log(1 + y) to the last digit or two, for y from 1e-300 to 1e10."""
    code = program(sp.log(1 + X), as_written=True)
    for y in (1e-300, 1e-20, 3e-9, 0.1, 1.0, 1e10):
        assert code([y, 0, 0, 0], functions=np)[0] == pytest.approx(np.log1p(y), rel=5e-16)


def test_half_powers_are_roots() -> None:
    """Half powers use one square root, and neither exponential nor logarithm."""
    counts = operations(program(X ** sp.Rational(5, 2) + X ** sp.Rational(-3, 2), as_written=True))
    assert (counts["sqrt"], counts["exp"], counts["log"]) == (1, 0, 0)


def test_where_it_is_not_admissible_a_rate_does_not_exist() -> None:
    """NaN where a member is negative; inputs that are passed on stay, so do the values inside."""
    code = program(Y, X + Y, admissibility_conditions=(A - X, X))
    found = [code([x, 0.5, 1.0, 0.0], functions=np) for x in (0.5, 1.0)]
    assert found == [[0.5, 1.0], [0.5, 1.5]]
    with np.errstate(invalid="ignore"):
        for x in (1.5, -0.1):
            passed, rate = code([np.float64(x), 0.5, 1.0, 0.0], functions=np)
            assert passed == 0.5
            assert np.isnan(rate)


def test_no_power_is_left() -> None:
    """Non-integer powers are square roots, or exp(a log x); 2 a, -a and a share one."""
    assert operations(program(sp.sqrt(X)))["sqrt"] == 1
    assert operations(program(X ** sp.Rational(3, 2)))["sqrt"] == 1
    counts = operations(program(X**A + X ** (2 * A) + X ** (A - 1)))
    assert (counts["exp"], counts["log"], counts["div"]) == (1, 1, 1)


@pytest.mark.parametrize(
    "expression",
    [
        X ** sp.Rational(-3, 2) + sp.sqrt(Y),
        X**A - 1 / X ** (2 * A) + Y / (X + A),
        sp.log(1 + X**2 / A) * sp.exp(-Y) / (1 + U * sp.cos(A)),
        sp.atan(X / A) * sp.pi + sp.atan(-Y),
        (X - Y) / (X + Y) - A / (X * Y) + sp.Rational(2, 3) * X,
        X**3 / A**2 + U / A,
        -sp.sqrt(A) / U,
        sp.Integer(1),
    ],
)
def test_any_elementary_expression(expression: Any) -> None:
    """Every elementary function is lowered to its value, in both ways of writing."""
    point = {X: 1.3, Y: 0.7, A: 2.1, U: 0.4}
    exact = float(expression.evalf(30, subs=point))
    for as_written in (False, True):
        (value,) = program(expression, as_written=as_written)(list(point.values()), functions=np)
        assert value == pytest.approx(exact, rel=1e-14)


def test_the_order_of_instructions_is_always_the_same() -> None:
    """Whatever the seed of Python's hashes, which orders sets of symbols."""
    script = (
        "from remanent.codegen.build import build_field\n"
        "from remanent.models.actuator import Actuator\n"
        "from remanent.models.drives.waves import SineSquared\n"
        "print(build_field(Actuator(), SineSquared(0.4, 1.0)).fingerprint)"
    )
    prints = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(prints) == 1

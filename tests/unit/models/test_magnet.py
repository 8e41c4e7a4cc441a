"""The magnet's field in itself, and what the laws say of it."""

from __future__ import annotations

import math
from itertools import permutations
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import dblquad, solve_ivp

import remanent as rm
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.codegen import reference
from remanent.codegen.field import vector_field_for
from remanent.models.magnet import demagnetising_factor

EDGES = [(1.0, 1.0, 1.0), (1.0, 2.0, 3.0), (1.0, 1.0, 0.1), (1.0, 1.0, 8.0), (0.2, 1.0, 5.0)]


def along(a: float, b: float, c: float) -> float:
    return float(demagnetising_factor(a, b, c, math))


def test_a_cube_has_one_third() -> None:
    """By symmetry the three factors of a cube are equal."""
    one = sp.Integer(1)
    exact = demagnetising_factor(one, one, one, sp)
    assert abs(sp.N(exact - sp.Rational(1, 3), 40)) < 1e-38


@pytest.mark.parametrize("edges", EDGES)
def test_the_three_factors_add_up_to_one(edges: tuple[float, float, float]) -> None:
    """The trace of the demagnetising tensor is 1."""
    a, b, c = edges
    assert along(a, b, c) + along(b, c, a) + along(c, a, b) == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize("edges", EDGES)
def test_only_the_ratio_of_edges_matters_and_not_their_order(
    edges: tuple[float, float, float],
) -> None:
    """The factor depends on ratios of edges, and is symmetric in the two that lie across."""
    a, b, c = edges
    assert along(3.0 * a, 3.0 * b, 3.0 * c) == pytest.approx(along(b, a, c), abs=1e-11)


def test_plates_and_needles() -> None:
    """Thin across: towards 1, by c/a (3 - 2 ln(c/2a))/pi ...; long along: towards 0."""
    assert along(1.0, 1.0, 1e-4) == pytest.approx(1.0, abs=1e-3)
    assert along(1.0, 1.0, 1e3) == pytest.approx(0.0, abs=1e-3)
    assert along(1e4, 1.0, 1.0) == pytest.approx(0.5, abs=1e-3)  # a long bar across itself
    thin = [along(1.0, 1.0, c) for c in np.geomspace(1e-3, 1e3, 25)]
    assert (np.diff(thin) < 0.0).all()


@pytest.mark.parametrize("edges", EDGES[1:4])
def test_factor_is_the_energy_of_charged_faces(edges: tuple[float, float, float]) -> None:
    """N = int int (1/r - 1/sqrt(r^2 + c^2)) dA dA' / (2 pi V), by quadrature.

    The double integral over two faces depends on distances only:
    4 int (a - x)(b - y) (...) dx dy over one of them.
    """
    a, b, c = edges

    def polar(low: float, high: float, edge: float, turned: bool) -> float:
        def inner(r: float, angle: float) -> float:
            x, y = r * math.cos(angle), r * math.sin(angle)
            return (a - x) * (b - y) * (1.0 - r / math.hypot(r, c))

        def end(angle: float) -> float:
            return edge / (math.sin(angle) if turned else math.cos(angle))

        return float(dblquad(inner, low, high, 0.0, end, epsabs=1e-10, epsrel=1e-10)[0])

    corner = math.atan2(b, a)
    total = polar(0.0, corner, a, False) + polar(corner, math.pi / 2.0, b, True)
    assert 4.0 * total / (2.0 * math.pi * a * b * c) == pytest.approx(along(a, b, c), abs=1e-8)


def energy_in_own_field(stretch: complex, c: float, strength: float, law: str) -> complex:
    factor = demagnetising_factor(stretch, stretch, math.sqrt(c) * stretch**-2, np)
    return complex(strength * factor / 2.0 * (stretch**-4 if law != "rotation" else 1.0))


@pytest.mark.parametrize("law", ["deformation-gradient", "rotation"])
@pytest.mark.parametrize("c", [0.1, 1.0])
def test_motion_with_its_own_field_agrees_with_an_independent_engine(law: str, c: float) -> None:
    """DOP853 with the slope of N l^-4 B_r^2/(2 mu mu0) by complex steps."""
    strength, S, m, times = 0.4, 0.3, 0.5, np.linspace(0.0, 6.0, 13)
    magnet = rm.Magnet(law=law, demagnetisation=strength)
    actuator = rm.Actuator(c=c, prestress=S, magnet=magnet)
    ds = rm.simulate(actuator, rm.Constant(m), times=times)

    def rates(_t: float, y: FloatArray) -> list[float]:
        x, v = y
        own = energy_in_own_field(x + 1e-30j, c, strength, law).imag / 1e-30
        load = m * x**-3 if law != "rotation" else 0.0
        force = x - x**-5 - S + load + own / 2.0
        return [v, float((6.0 * c * x**-7 * v * v - 3.0 * force) / (1.0 + 2.0 * c * x**-6))]

    path = solve_ivp(rates, (0.0, 6.0), [1.0, 0.0], "DOP853", times, rtol=1e-13, atol=1e-14)
    ours = np.stack([ds.stretch.values, ds.stretch_rate.values])
    assert np.abs(ours - path.y).max() <= float(ds.error) + 1e-10
    energy = ds.energy.values
    assert np.ptp(energy) <= 1e-7


def test_forces_of_the_own_field_are_slopes_of_its_energy_in_two_directions() -> None:
    """(w + c g g^T) l'' = -3 dU/dl at zero rate, for a block with unequal edges."""
    c, strength, edges, S = 0.2, 0.4, np.array([1.0, 0.5]), np.array([0.3, -0.1])
    body = rm.Actuator(
        c=c, prestress=tuple(S), edges=tuple(edges), magnet=rm.Magnet(demagnetisation=strength)
    )
    field = vector_field_for(body, rm.Constant(0.0))
    row = np.array([*body.parameter_values().values(), 0.0])

    def potential(l1: complex, l2: complex) -> complex:
        x = 1.0 / (l1 * l2)
        factor = demagnetising_factor(edges[0] * l1, edges[1] * l2, math.sqrt(c) * x, np)
        return complex((l1**2 + l2**2 + x**2) / 2.0 + strength * factor * x**2 / 2.0)

    for stretches in np.random.default_rng(1).uniform(0.7, 1.6, (10, 2)):
        g = -1.0 / (stretches * stretches.prod())
        units = 1e-30j * np.eye(2)
        slope = np.array([potential(*(stretches + unit)).imag / 1e-30 for unit in units]) - S
        mass = np.diag(edges**2) + c * np.outer(g, g)
        state = np.array([[stretches[0], 0.0, stretches[1], 0.0]])
        found = reference.evaluate_rates(field, 0.0, state, row[None], np.empty(0))[0, 1::2]
        np.testing.assert_allclose(mass @ found, -3.0 * slope, rtol=1e-10, atol=1e-11)


@pytest.mark.slow
def test_equal_loads_keep_stretches_equal_in_the_own_field() -> None:
    """One coordinate and two are the same motion, also where the temperature moves."""
    magnet = rm.Magnet(-1e-3, demagnetisation=0.4)
    one, two = (
        rm.simulate(
            rm.Actuator(c=0.2, prestress=load, magnet=magnet, heat=rm.Heat(5e-3)),
            rm.SineSquared(0.4, 1.25), duration=5.0,
        )
        for load in (0.2, (0.2, 0.2))
    )  # fmt: skip
    slack = 10.0 * float(one.error + two.error)
    assert float(abs(one.stretch - two.stretch_1).max()) <= slack
    assert float(abs(one.body_temperature - two.body_temperature).max()) <= 293.0 * slack


@pytest.mark.slow
@pytest.mark.parametrize("load", [0.2, (0.2, -0.1)], ids=["one", "two"])
def test_balances_close_where_the_remanence_of_the_own_field_warms(load: Any) -> None:
    """Its entropy is -d/dT of N b^2 B_r(T)^2/(2 mu mu0): it takes part in both laws."""
    magnet = rm.Magnet(-3e-3, demagnetisation=0.8)
    body = rm.Actuator(
        prestress=load, magnet=magnet, dissipation=rm.Rayleigh(0.1), heat=rm.Heat(5e-3, 0.1)
    )
    ds = rm.energy_balance(body, rm.SineSquared(0.4, 1.25), duration=5.0)
    assert float(abs(ds.balance).max()) <= 20.0 * float(ds.error)
    assert float(abs(ds.entropy_balance).max()) <= 20.0 * float(ds.error)


def test_own_field_of_no_strength_changes_nothing() -> None:
    """With strength 0 the motion is that of a magnet without a field of its own."""
    drive = rm.SineSquared(0.4, 1.25)
    plain = rm.simulate(rm.Actuator(), drive, times=[5.0])
    none = rm.simulate(rm.Actuator(magnet=rm.Magnet(demagnetisation=0.0)), drive, times=[5.0])
    assert float(abs(none.stretch - plain.stretch)[0]) <= 2e-9


def test_own_field_weakens_with_the_remanence() -> None:
    """A magnet at half its remanence has a quarter of the energy in its own field."""
    half = {"temperature_coefficient": -0.005, "demagnetisation": 0.8}
    warm = rm.Actuator(temperature=350.0, reference_temperature=250.0, magnet=rm.Magnet(**half))  # type: ignore[arg-type]
    weak = rm.Actuator(
        temperature=350.0, reference_temperature=250.0, magnet=rm.Magnet(demagnetisation=0.2)
    )
    found = [rm.equilibria(a, m).stretch.values for a, m in ((warm, 0.6), (weak, 0.3))]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-13)


def test_a_block_without_load_is_flattened_or_not_by_its_own_field() -> None:
    """Where magnetisation follows F it avoids its own field by growing thinner."""
    found = rm.equilibria(rm.Actuator(magnet=rm.Magnet(demagnetisation=0.163)), 0.0)
    assert float(found.equilibrium_stretch[0]) < 1.0


def test_strength_comes_from_physical_units() -> None:
    """The strength is B_r^2/(mu mu0), where it is asked for and a remanence is given."""
    made = {
        "shear_modulus": "100 kPa", "density": "2000 kg/m^3", "half_length": "5 mm",
        "half_thickness": "0.5 mm",
    }  # fmt: skip
    own = rm.Actuator.from_si(**made, remanence="143 mT", own_field=True)
    assert own.magnet.demagnetisation == pytest.approx(0.143**2 / (1e5 * 1.25663706127e-6))
    assert rm.Actuator.from_si(**made, remanence="143 mT").magnet.demagnetisation is None  # type: ignore[arg-type]
    with pytest.raises(InputError, match="`remanence` must be given"):
        rm.Actuator.from_si(**made, own_field=True)


@pytest.mark.parametrize("bad", [-0.1, np.nan, "1", True])
def test_bad_strengths_are_refused(bad: object) -> None:
    """What is not a number of at least 0 is refused by name."""
    with pytest.raises(InputError, match="`demagnetisation` must be"):
        rm.Magnet(demagnetisation=bad)  # type: ignore[arg-type]


def test_strength_can_be_varied_where_it_is_there() -> None:
    """Equilibria move steadily with the strength; where there is none it cannot be varied."""
    own = rm.Actuator(magnet=rm.Magnet(demagnetisation=0.1))
    over = {"magnet.demagnetisation": [0.0, 0.1, 0.2]}
    found = rm.equilibria(own, 0.3, over=over).equilibrium_stretch.values[:, 0]
    assert len(set(permutations(found))) == 6
    assert (np.diff(found) < 0.0).all() or (np.diff(found) > 0.0).all()
    with pytest.raises(InputError, match="numeric field"):
        rm.equilibria(rm.Actuator(), 0.3, over=over)

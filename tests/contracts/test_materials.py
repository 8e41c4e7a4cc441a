"""What every material must satisfy; a new one joins by its example."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
import sympy as sp
import xarray as xr
from scipy.integrate import solve_ivp
from sympy.polys.ring_series import rs_series_reversion

import remanent as rm
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.codegen import reference
from remanent.codegen.field import vector_field_for
from remanent.models.materials.base import Material
from tests.contracts.public import examples
from tests.repetitions import fast_and_slow

J = sp.Symbol("I1") - 3
MATERIALS: dict[str, Material] = {
    **examples(Material),  # type: ignore[type-abstract]
    "ogden, one term": rm.Ogden([2.0], [1.0]),
    "formula of a stretch": rm.StrainEnergy("log(l1)**2 + log(l2)**2 + log(l3)**2"),
    "formula with a limit": rm.StrainEnergy("-j*log(1 - (I1 - 3)/j)", {"j": 12.0}),
    "formula of sympy": rm.StrainEnergy(sp.exp(sp.Symbol("k") * J), {"k": 0.05}),
}
#: Materials that are given as formulas lose digits near rest, as their formula does.
NAMED = {name: m for name, m in MATERIALS.items() if not isinstance(m, rm.StrainEnergy)}
every = pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS.keys())
#: Laws of motion compile much: the fast tests ask them of one solid of each way to write one.
FAST = ("NeoHookean", "Gent", "StrainEnergy")
of_motion = pytest.mark.parametrize("material", fast_and_slow(MATERIALS, FAST))
#: Stretches l1, l2 over the range of use, within the limits of all of the above.
PAIRS = np.random.default_rng(1).uniform(0.7, 1.6, (20, 2))


def energy(material: Material, l1: Any, l2: Any, **changed: Any) -> Any:
    """W for numbers of NumPy, real or complex."""
    p = {name: np.float64(value) for name, value in material.parameter_values().items()} | changed
    return material.energy(l1, l2, 1.0 / (l1 * l2), p, np)


def acceleration(material: Material, stretch: Any, rate: Any, m: Any, **fields: Any) -> FloatArray:
    """From the compiled equations, evaluated with NumPy; arrays (point,)."""
    actuator, drive = rm.Actuator(material=material, c=0.3), rm.Constant(0.0)
    field = vector_field_for(actuator, drive)
    own = {**actuator.parameter_values(), **drive.parameter_values(), **fields, "m": m}
    rows = np.broadcast_arrays(stretch, rate, *(own[name] for name in field.parameter_names))
    columns = np.array(rows, dtype=np.float64).T
    return reference.evaluate_rates(field, 0.0, columns[:, :2], columns[:, 2:], np.empty(0))[:, 1]


# The undeformed state -------------------------------------------------------------------


@every
def test_undeformed_is_free_of_energy_and_stress(material: Material) -> None:
    """The undeformed state has no energy, and no stress in either direction."""
    assert abs(float(energy(material, 1.0, 1.0))) <= 1e-14
    for l1, l2 in ((1.0 + 1e-30j, 1.0), (1.0, 1.0 + 1e-30j)):
        assert abs(energy(material, l1, l2).imag / 1e-30) <= 1e-13


@every
def test_shear_modulus_is_one(material: Material) -> None:
    """W(exp e, exp -e, 1) = 2 e^2 + O(e^4), and exp f in the plane adds 2 (e^2 + e f + f^2)."""
    h = 1e-3
    for e, f, expected in ((1, -1, 2.0), (1, 0, 2.0), (0, 1, 2.0), (1, 1, 6.0)):
        both = [energy(material, np.exp(s * h * e), np.exp(s * h * f)) for s in (1.0, -1.0)]
        assert sum(both) / 2.0 / h**2 == pytest.approx(expected, rel=1e-4)


@every
def test_undeformed_is_the_only_minimum_nearby(material: Material) -> None:
    """W > 0 around rest, and it grows outwards."""
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    rings = [
        energy(material, np.exp(r * np.cos(angles)), np.exp(r * np.sin(angles)))
        for r in (1e-3, 0.05, 0.2, 0.4)
    ]
    assert (np.diff([np.zeros(24), *rings], axis=0) > 0.0).all()


@pytest.mark.parametrize("material", NAMED.values(), ids=NAMED.keys())
def test_energy_keeps_its_digits_near_rest(material: Material) -> None:
    """W = 6 d^2 (1 + O(d)) at l = 1 + d, to nine digits at d = 1e-6."""
    actuator, drive = rm.Actuator(material=material), rm.Constant(0.0)
    field = vector_field_for(actuator, drive)
    row = np.array([[*actuator.parameter_values().values(), 0.0]])
    sizes = []
    for d in (1e-6, -1e-6):
        seen = reference.evaluate_observables(
            field, 0.0, np.array([[1.0 + d, 0.0]]), row, np.empty(0)
        )
        sizes.append(float(seen["energy"][0]) / 6e-12)
    assert np.mean(sizes) == pytest.approx(1.0, abs=1e-9)


# Stress ---------------------------------------------------------------------------------


@every
def test_stress_by_complex_steps_is_the_symbolic_one(material: Material) -> None:
    """The derivative of the energy in complex arithmetic is the symbolic derivative."""
    l1, l2 = sp.symbols("l1 l2", positive=True)
    p = {name: sp.Symbol(f"p.{name}", real=True) for name in material.parameter_values()}
    values = {p[name]: value for name, value in material.parameter_values().items()}
    strain = material.energy(l1, l2, 1 / (l1 * l2), p, sp)
    for symbol, step in ((l1, (1e-30j, 0.0)), (l2, (0.0, 1e-30j))):
        stress = sp.lambdify((l1, l2), sp.diff(strain, symbol).subs(values), "numpy")
        steps = energy(material, PAIRS[:, 0] + step[0], PAIRS[:, 1] + step[1]).imag / 1e-30
        np.testing.assert_allclose(steps, stress(*PAIRS.T), rtol=1e-11, atol=1e-12)


@every
def test_compiled_force_is_minus_the_slope_of_the_energy(material: Material) -> None:
    """(2/3) M l'' = -dU/dl at zero rate, U = W - 2 S (l - 1) - m l^-2."""
    x, m, S = PAIRS[:, 0], 0.3, 0.7
    slope = energy(material, x + 1e-30j, x + 1e-30j).imag / 1e-30 - 2.0 * S + 2.0 * m * x**-3
    expected = -1.5 * slope / (1.0 + 0.6 * x**-6)
    found = acceleration(material, x, 0.0, m, prestress=S)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


@every
def test_energy_does_not_know_the_order_of_stretches(material: Material) -> None:
    """An isotropic energy is the same in every order of its stretches."""
    p = {name: np.float64(value) for name, value in material.parameter_values().items()}
    for l1, l2 in PAIRS:
        orders = permutations((l1, l2, 1.0 / (l1 * l2)))
        values = [material.energy(a, b, c, p, np) for a, b, c in orders]
        assert np.ptp(values) <= 1e-12 * (1.0 + max(values))


# Temperature ----------------------------------------------------------------------------


@every
def test_temperature_scales_out(material: Material) -> None:
    """l''(T; m, S, l') = theta l''(T0; m/theta, S/theta, l'/sqrt theta) for f = 1."""
    x, v, m, S, theta = PAIRS[:, 0], 0.4, 0.3, 0.7, 1.3
    warm = acceleration(material, x, v, m, prestress=S, temperature=theta * 293.0)
    cold = acceleration(material, x, v / np.sqrt(theta), m / theta, prestress=S / theta)
    np.testing.assert_allclose(warm, theta * cold, rtol=1e-12, atol=1e-13)


@every
def test_an_energetic_solid_does_not_feel_temperature(material: Material) -> None:
    """Without an entropic part, accelerations are the same at every temperature."""
    still = material.replace(entropic_fraction=0.0)
    x = PAIRS[:, 0]
    cold, warm = (
        acceleration(still, x, 0.1, 0.3, temperature=T, **{"material.entropic_fraction": 0.0})
        for T in (250.0, 400.0)
    )
    np.testing.assert_array_equal(cold, warm)


# As a value, and in a study -------------------------------------------------------------


@every
def test_materials_are_values(material: Material) -> None:
    """Copies are equal, a repr rebuilds its material, and each number can be replaced alone."""
    copy = material.replace()
    assert copy == material
    assert hash(copy) == hash(material)
    rebuilt = eval(repr(material), {k: getattr(rm, k) for k in rm.__all__})  # noqa: S307
    assert rebuilt == material
    for name, value in material.parameter_values().items():
        changed = material.replace(**{name: 0.9 * value})
        assert changed.parameter_values() == {**material.parameter_values(), name: 0.9 * value}
        assert changed.equation_structure() == material.equation_structure()


@every
@pytest.mark.parametrize("bad", [np.nan, np.inf, "1", None, True, [1.0], 1j])
def test_every_number_is_checked(material: Material, bad: Any) -> None:
    """Whatever is not a finite number is refused, in each parameter, by its name."""
    assert "entropic_fraction" in material.parameter_values()
    for name in material.parameter_values():
        with pytest.raises(InputError, match=f"^`{name}` must be"):
            material.replace(**{name: bad})


@every
def test_batch_check_agrees_with_single_check(material: Material) -> None:
    """A batch marks as invalid exactly the values that a single material refuses."""
    assert "entropic_fraction" in material.parameter_values()
    values = np.array([np.nan, -np.inf, -1e3, -1.0, 0.0, 0.5, 1.0, 1.5, 40.0, 1e300])
    for name in material.parameter_values():
        expected = [refused(material, name, value) for value in values]
        assert material.where_invalid({name: values}).tolist() == expected


def refused(material: Material, name: str, value: float) -> bool:
    try:
        material.replace(**{name: value})
    except InputError:
        return True
    return False


@of_motion
def test_numbers_may_be_varied_by_a_study(material: Material) -> None:
    """Each of a sweep is what the changed material gives by itself, bit for bit."""
    assert "entropic_fraction" in material.parameter_values()
    drive = rm.Constant(0.2)
    for name, value in material.parameter_values().items():
        field, values = f"material.{name}", sorted((value, 0.95 * value))
        swept = rm.simulate(
            rm.Actuator(material=material), drive, times=[1.0], over={field: values}
        )
        alone = rm.simulate(
            rm.Actuator().replace(material=material.replace(**{name: values[0]})),
            drive,
            times=[1.0],
        )
        assert float(swept.stretch[0, 0]) == float(alone.stretch[0])


@of_motion
def test_motion_agrees_with_an_independent_engine(material: Material) -> None:
    """SciPy's DOP853 on the complex-step force, within the reported errors, also of extremes."""
    times, c, S, b, w = np.linspace(0.0, 6.0, 13), 0.3, 0.4, 0.9, 1.3
    actuator = rm.Actuator(c=c, prestress=S, material=material)
    ds = rm.simulate(actuator, rm.SineSquared(b, w), times=times, tolerance=1e-9)
    assert int(ds.status) == 1

    def rates(t: float, y: FloatArray) -> list[float]:
        x, v = y
        slope = energy(material, x + 1e-30j, x + 1e-30j).imag / 1e-30
        force = slope / 2.0 - S + (b * np.sin(w * t)) ** 2 * x**-3
        return [v, float((6.0 * c * x**-7 * v * v - 3.0 * force) / (1.0 + 2.0 * c * x**-6))]

    def turns(_t: float, y: FloatArray) -> float:
        return float(y[1])

    options: dict[str, Any] = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "events": turns}
    path = solve_ivp(rates, (0.0, 6.0), [1.0, 0.0], t_eval=times, **options)
    ours = np.stack([ds.stretch.values, ds.stretch_rate.values])
    assert np.abs(ours - path.y).max() <= float(ds.error) + 1e-11
    assert path.y_events is not None
    seen = np.concatenate([path.y_events[0][:, 0], path.y[0, [0, -1]]]) ** -2.0
    response = rm.frequency_response(actuator, rm.SineSquared(b, w), [w], duration=6.0).squeeze()
    bound = float(response.amplitude_error) + 1e-10
    assert abs(float(response.maximum) - seen.max()) <= bound
    assert abs(float(response.minimum) - seen.min()) <= bound


@of_motion
def test_motion_in_two_directions_agrees_with_an_independent_engine(material: Material) -> None:
    """(1 + c g g^T) l'' = -3 dU/dl - c K g, by DOP853; x = 1/(l1 l2), x'' = g l'' + K."""
    times, c, S, b, w = np.linspace(0.0, 4.0, 9), 0.3, np.array([0.3, -0.1]), 0.6, 1.3
    actuator = rm.Actuator(c=c, prestress=tuple(S), material=material)
    ds = rm.simulate(actuator, rm.SineSquared(b, w), times=times, tolerance=1e-9)
    assert int(ds.status) == 1

    def rates(t: float, y: FloatArray) -> FloatArray:
        stretches, speeds = y[:2], y[2:]
        x, e = 1.0 / stretches.prod(), speeds / stretches
        g, K = -x / stretches, x * (e.sum() ** 2 + (e * e).sum())
        slope = [energy(material, *(stretches + 1e-30j * unit)).imag / 1e-30 for unit in np.eye(2)]
        force = -3.0 * (slope - S - (b * np.sin(w * t)) ** 2 * g)
        mass = np.eye(2) + c * np.outer(g, g)
        return np.concatenate([speeds, np.linalg.solve(mass, force - c * K * g)])

    start = [1.0, 1.0, 0.0, 0.0]
    path = solve_ivp(rates, (0.0, 4.0), start, "DOP853", times, rtol=1e-13, atol=1e-14)
    names = ("stretch_1", "stretch_2", "stretch_1_rate", "stretch_2_rate")
    ours = np.stack([ds[name].values for name in names])
    assert np.abs(ours - path.y).max() <= float(ds.error) + 1e-11
    assert abs(float(ds.stretch_1[-1] - ds.stretch_2[-1])) > 1e-3


@of_motion
def test_balances_close_where_temperature_moves(material: Material) -> None:
    """Both laws within the error, with losses, exchange and a remanence that takes part."""
    body = rm.Actuator(
        prestress=(0.2, -0.1), material=material, dissipation=rm.Rayleigh(0.1),
        heat=rm.Heat(2e-3, 0.1), magnet=rm.Magnet(-1e-3),
    )  # fmt: skip
    ds = rm.energy_balance(body, rm.SineSquared(0.4, 1.25), duration=5.0)
    assert float(abs(ds.balance).max()) <= 20.0 * float(ds.error)
    assert float(abs(ds.entropy_balance).max()) <= 20.0 * float(ds.error)
    assert float(ds.entropy_produced[-1]) > 1e-3
    assert float(abs(ds.heat_given_off).max()) > 1e-4


# Limits ---------------------------------------------------------------------------------

LIMITS: dict[str, tuple[Material, Material, float]] = {
    "gent without limit": (rm.Gent(1e5), rm.NeoHookean(), 3e-5),
    "mooney-rivlin without c2": (rm.MooneyRivlin(7.0, 0.0), rm.NeoHookean(), 1e-14),
    "ogden of order 2": (rm.Ogden([3.0], [2.0]), rm.NeoHookean(), 1e-14),
    "ogden of orders 2 and -2": (
        rm.Ogden([0.6, -0.2], [2.0, -2.0]), rm.MooneyRivlin(0.3, 0.1), 1e-14,
    ),
    "long chains": (rm.ArrudaBoyce(1e5), rm.NeoHookean(), 1e-9),
    "gent's formula": (MATERIALS["formula with a limit"], rm.Gent(12.0), 1e-13),
    "hencky": (MATERIALS["formula of a stretch"], rm.Ogden([1e5], [1e-5]), 1e-4),
}  # fmt: skip


@pytest.mark.parametrize("name", LIMITS)
def test_limits_are_other_materials(name: str) -> None:
    """In its limit a material has the energy of the simpler one."""
    one, other, tolerance = LIMITS[name]
    np.testing.assert_allclose(energy(one, *PAIRS.T), energy(other, *PAIRS.T), rtol=tolerance)


def test_series_of_arruda_and_boyce_is_that_of_the_inverse_langevin_function() -> None:
    """dW/dI1 is beta(y)/(6 y), y = sqrt(I1/3)/L, by five terms of the inverse of coth b - 1/b."""
    _, b, y = sp.ring("b y", sp.QQ)
    langevin = sum(
        sp.bernoulli(2 * n) * 2 ** (2 * n) / sp.factorial(2 * n) * b ** (2 * n - 1)
        for n in range(1, 7)
    )
    inverse = rs_series_reversion(langevin, b, 11, y)
    terms = {int(powers[1]): float(value) for powers, value in inverse.terms()}

    def slope(square: Any) -> Any:
        return sum(terms[k] * square ** ((k - 1) // 2) for k in (1, 3, 5, 7, 9)) / 6.0

    L, x = 2.5, PAIRS[:, 0]
    invariant, growth = 2.0 * x**2 + x**-4, 4.0 * x - 4.0 * x**-5
    expected = slope(invariant / (3.0 * L**2)) * growth / (2.0 * slope(1.0 / L**2))
    found = energy(rm.ArrudaBoyce(L), x + 1e-30j, x + 1e-30j).imag / 1e-30
    np.testing.assert_allclose(found, expected, rtol=1e-12)


# The limiting chain extension -----------------------------------------------------------

LIMITED = {"gent": rm.Gent(2.0), "formula": rm.StrainEnergy("-log(1 - (I1 - 3)/j)", {"j": 2.0})}
limited = pytest.mark.parametrize("material", LIMITED.values(), ids=LIMITED.keys())


@limited
def test_a_state_beyond_the_limit_is_refused(material: Material) -> None:
    """A start beyond the limit of the chains is refused alone, and invalid in an ensemble."""
    actuator, beyond = rm.Actuator(material=material), (1.7, 0.0)
    with pytest.raises(InputError, match="`initial` must be a state that the material can reach"):
        rm.simulate(actuator, rm.Constant(0.1), duration=1.0, initial=beyond)
    over = {"initial.stretch": [0.6, 1.0, 1.7]}
    ds = rm.simulate(actuator, rm.Constant(0.1), duration=1.0, over=over)
    assert ds.status.values.tolist() == [4, 1, 4]


@limited
def test_no_state_beyond_the_limit_is_ever_returned(material: Material) -> None:
    """Driven hard against it, motions stay within or end with a status."""
    rng, count = np.random.default_rng(2), 24
    over = {
        "prestress": xr.DataArray(rng.uniform(-2.0, 2.0, count), dims="case"),
        "b": xr.DataArray(rng.uniform(0.5, 2.0, count), dims="case"),
        "c": xr.DataArray(10.0 ** rng.uniform(-1.5, 0.0, count), dims="case"),
    }
    ds = rm.simulate(
        rm.Actuator(material=material), rm.SineSquared(1.0, 1.1), duration=8.0, over=over,
        tolerance=1e-7,
    )  # fmt: skip
    share = (2.0 * ds.stretch**2 + ds.stretch**-4 - 3.0) / 2.0
    assert 0.95 < float(share.max()) < 1.0
    assert set(ds.status.values.tolist()) <= {1, 2, 7}
    assert (ds.status.values == 1).any()
    assert np.isfinite(ds.stretch.values[ds.status.values == 1]).all()


@limited
def test_rates_beyond_the_limit_do_not_exist(material: Material) -> None:
    """Accelerations are NaN beyond the limit of the chains, and only there."""
    with np.errstate(invalid="ignore"):
        found = acceleration(material, np.array([1.0, 1.4, 1.7, 0.6]), 0.0, 0.1)
    assert np.isnan(found).tolist() == [False, False, True, True]


# What is refused ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rm.Gent(0.0), "`jm` must be a finite number greater than 0; got 0.0"),
        (lambda: rm.MooneyRivlin(0.0, 0.0), r"`2 \(c1 \+ c2\)` must be .* greater than 0; got 0"),
        (lambda: rm.MooneyRivlin(-1.0, 2.0), "`c1` must be a finite number, at least 0"),
        (lambda: rm.Ogden([1.0, 2.0], [1.0]), "`exponents` must have as many entries"),
        (lambda: rm.Ogden([1.0], [0.0]), "`exponents.0` must be a finite number other than 0"),
        (lambda: rm.Ogden([1.0], [-2.0]), "`sum of moduli times exponents` must be"),
        (lambda: rm.Ogden([], []), "`moduli` must be a sequence"),
        (lambda: rm.ArrudaBoyce(1.0), "`locking_stretch` must be .* greater than 1; got 1.0"),
        (lambda: rm.StrainEnergy("l1**2"), "`expression` must be the same when stretches are exch"),
        (lambda: rm.StrainEnergy("log(I1 - 3)"), "`the shear modulus at rest` must be .* got nan"),
        (lambda: rm.StrainEnergy("3 - I1"), "`the shear modulus at rest` must be"),
        (lambda: rm.StrainEnergy("(I1 - 3)**2"), "`the shear modulus at rest` must be"),
        (lambda: rm.StrainEnergy("7"), "`the shear modulus at rest` must be"),
        (lambda: rm.StrainEnergy("a*I1"), "names in `constants` only; got a"),
        (lambda: rm.StrainEnergy("I1", {"a": 1.0}), "`constants` must occur in the expression"),
        (lambda: rm.StrainEnergy("a*I1", {"a": np.nan}), "`a` must be a finite number"),
        (lambda: rm.StrainEnergy("I1", {"l1": 1.0}), "`constants` must have names of their own"),
        (lambda: rm.StrainEnergy("I1", {"a b": 1.0}), "`constants` must be a mapping of names"),
        (lambda: rm.StrainEnergy(3.0), "`expression` must be text or a SymPy expression"),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_bad_materials_are_explained(make: Any, message: str) -> None:
    """The message names the constant, and says what it must be."""
    with pytest.raises(InputError, match=message):
        make()


def test_a_formula_with_a_limit_of_its_own_rests_where_gent_does() -> None:
    """-50 ln(1 - (I1 - 3)/100) is Gent's energy for J_m = 100, with numbers in place of fields."""
    written = rm.Actuator(material=rm.StrainEnergy("-50*log(1 - (I1 - 3)/100)"))
    gent = rm.Actuator(material=rm.Gent(100.0))
    ours, theirs = (rm.equilibria(body, 0.3) for body in (written, gent))
    np.testing.assert_allclose(ours.stretch, theirs.stretch, rtol=1e-12)


def test_yeoh_by_name_and_by_formula() -> None:
    """A first and a zeroth power are flat at rest: the formula is the named solid."""
    constants = {"c1": 0.5, "c2": -0.005, "c3": 1e-4}
    formula = "c1*(I1 - 3)**1 + c2*(I1 - 3)**2 + c3*(I1 - 3)**3 + (I1 - 3)**0"
    for l1, l2 in PAIRS:
        named = energy(rm.Yeoh(**constants), l1, l2)
        assert energy(rm.StrainEnergy(formula, constants), l1, l2) == pytest.approx(
            named, abs=1e-13
        )


def test_an_energy_whose_value_at_rest_is_e() -> None:
    """exp(I1/3) moves as k = 1/3 in exp(k I1), which is compiled without the number e."""
    runs = [
        rm.simulate(rm.Actuator(material=solid), rm.Constant(0.3), duration=5.0).stretch.values
        for solid in (rm.StrainEnergy("exp(I1/3)"), rm.StrainEnergy("exp(k*I1)", {"k": 1 / 3}))
    ]
    np.testing.assert_allclose(runs[0], runs[1], atol=1e-9)

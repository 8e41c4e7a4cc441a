"""Folds of equilibria, and the step load from which on a motion passes a saddle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import remanent as rm
from remanent._typing import FloatArray

MATERIALS = {
    "neo-hookean": rm.NeoHookean(),
    "gent": rm.Gent(40.0),
    "mooney-rivlin": rm.MooneyRivlin(0.9, 0.1),
    "ogden": rm.Ogden([0.63, 0.0012, -0.01], [1.3, 5.0, -2.0]),
    "arruda-boyce": rm.ArrudaBoyce(5.0),
    "formula": rm.StrainEnergy("I1 + b*(I1 - 3)**2", {"b": 0.002}),
}


def balance(x: float, S: float) -> float:
    """The load under which x is an equilibrium, theta = 1: m = S x^3 - x^4 + x^-2."""
    return S * x**3 - x**4 + x**-2


def slope_of_balance(x: float, S: float) -> float:
    return 3.0 * S * x**2 - 4.0 * x**3 - 2.0 * x**-3


@pytest.mark.parametrize("S", [1.9, 2.2, 2.6])
def test_folds_over_the_load_are_extremes_of_the_balancing_load(S: float) -> None:
    """Equilibria fold where the load that balances a stretch has an extreme."""
    ds = rm.equilibria(rm.Actuator(prestress=S), over={"m": np.linspace(0.5, 6.0, 12)})
    peak = max(np.linspace(0.8, 2.0, 400), key=lambda x: slope_of_balance(x, S))
    roots = [
        brentq(slope_of_balance, low, high, args=(S,), xtol=1e-14)
        for low, high in ((0.5, float(peak)), (float(peak), 3.0))
    ]
    np.testing.assert_allclose(ds.fold_stretch, roots, atol=1e-12)
    np.testing.assert_allclose(ds.fold_m, [balance(x, S) for x in roots], atol=1e-12)


def test_folds_over_prestress_and_temperature_are_the_same_points() -> None:
    """S/theta and m/theta decide: a fold at (m, S) is one in each of the three."""
    cold = rm.Actuator(prestress=2.2)
    m = float(rm.equilibria(cold, over={"m": [1.0, 4.0]}).fold_m[1])
    S = rm.equilibria(rm.Actuator(), m, over={"prestress": [1.0, 4.0]}).fold_prestress.values
    T = rm.equilibria(cold, m, over={"temperature": [200.0, 400.0]}).fold_temperature.values
    assert np.abs(S - 2.2).min() <= 1e-11
    assert np.abs(T / 293.0 - 1.0).min() <= 1e-11


def test_folds_end_in_the_cusp() -> None:
    """At beta = (25/4)^(1/3), S/theta = 1.8640, l = 1.1650 the two folds over S meet."""
    beta = (25.0 / 4.0) ** (1.0 / 3.0)
    over = {"prestress": np.linspace(1.5, 2.5, 11)}
    below, above = (rm.equilibria(rm.Actuator(), b, over=over) for b in (beta - 1e-4, beta + 1e-4))
    assert below.sizes["fold"] == 0
    assert above.fold_prestress.values == pytest.approx([1.8640, 1.8640], abs=2e-4)
    assert above.fold_stretch.values.mean() == pytest.approx(1.1650, abs=2e-4)


def test_there_is_no_fold_without_prestress_or_under_the_rotation_law() -> None:
    """Without prestress, or without a magnetic load, there is one equilibrium at every load."""
    loads = {"m": np.linspace(-5.0, 5.0, 5)}
    turned = rm.Actuator(prestress=2.2, magnet=rm.Magnet(law="rotation"))
    for actuator in (rm.Actuator(), turned):
        ds = rm.equilibria(actuator, over=loads)
        assert ds.sizes["fold"] == 0
        assert ds.sizes["equilibrium"] == 1


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS.keys())
def test_equilibria_alternate_and_the_outer_ones_are_stable(material: rm.NeoHookean) -> None:
    """The potential rises at both ends, so stable and unstable alternate, stable first."""
    actuator = rm.Actuator(material=material)
    loads, prestress = [-2.0, 0.5, 1.9, 2.3, 3.0], [-1.0, 0.0, 1.9, 2.2]
    ds = rm.equilibria(actuator, over={"m": loads, "prestress": prestress})
    words = ds.stability.values.reshape(-1, ds.sizes["equilibrium"])
    for row in words:
        kinds = [word for word in row if word]
        assert kinds == ["stable", "unstable"] * (len(kinds) // 2) + ["stable"]
    x = ds.stretch.values
    p = {k: np.float64(v) for k, v in material.parameter_values().items()}
    there = np.isfinite(x)
    S, m = (
        np.broadcast_to(a, x.shape)[there]
        for a in (np.array(prestress)[None, :, None], np.array(loads)[:, None, None])
    )
    step = x[there] + 1e-30j
    slope = np.asarray(material.energy(step, step, step**-2, p, np)).imag / 1e-30
    left = slope - 2.0 * S + 2.0 * m * x[there] ** -3
    assert np.abs(left).max() <= 1e-9


@pytest.mark.parametrize("load", [-200.0, -5.0, 0.3, 5.0, 200.0])
def test_equilibria_near_the_limit_of_the_chains_are_found(load: float) -> None:
    """Gent: however large the load, one equilibrium within the limit."""
    ds = rm.equilibria(rm.Actuator(material=rm.Gent(0.8)), load)
    (x,) = ds.stretch.values
    left = 1.0 - (2.0 * x**2 + x**-4 - 3.0) / 0.8
    assert left > 0.0
    assert (2.0 * x - 2.0 * x**-5) / left + 2.0 * load * x**-3 == pytest.approx(0.0, abs=1e-8)
    assert ds.stability.values.tolist() == ["stable"]


def energy(x: FloatArray | float, S: float, m: float) -> FloatArray | float:
    return x**2 + x**-4 / 2.0 - 2.0 * S * x - m * x**-2


def test_threshold_is_where_the_saddle_has_the_energy_of_the_start() -> None:
    """A step from rest passes the saddle from the load on at which their energies are equal."""
    S = 2.2
    thin = brentq(lambda x: x - x**-5 - S, 1.5, 3.0, xtol=1e-14)
    ds = rm.snap_through(rm.Actuator(prestress=S), "m", (1.0, 4.0), initial=thin)

    def rise(x: float) -> float:
        return float(energy(x, S, balance(x, S)) - energy(thin, S, balance(x, S)))

    saddle = brentq(rise, 1.05, 1.55, xtol=1e-14)
    assert ds.snap_stretch.values == pytest.approx([saddle], abs=1e-10)
    assert ds.snap_m.values == pytest.approx([balance(saddle, S)], abs=1e-10)
    assert ds.snap_direction.values.tolist() == [-1.0]
    assert float(ds.snap_m[0]) < float(ds.fold_m.max())


@pytest.mark.parametrize("material", list(MATERIALS.values())[1:3])
def test_motions_on_both_sides_of_the_threshold(material: rm.Gent) -> None:
    """A step one in ten thousand above it passes the saddle, as much below it turns."""
    actuator = rm.Actuator(prestress=2.4, c=0.3, material=material)
    thin = float(rm.equilibria(actuator, 0.0).stretch[-1])
    ds = rm.snap_through(actuator, "m", (1.0, 6.0), initial=thin)
    m, saddle = float(ds.snap_m[-1]), float(ds.snap_stretch[-1])
    over = {"m": [m * (1.0 - 1e-4), m * (1.0 + 1e-4)]}
    run = rm.simulate(actuator, rm.Constant(m), duration=15.0, initial=(thin, 0.0), over=over)
    assert (run.status == 1).all()
    assert (run.stretch.min("time").values < saddle).tolist() == [False, True]


def test_a_start_on_the_saddle_itself() -> None:
    """From the undeformed state under S > 2, it is m = S that decides the direction."""
    ds = rm.snap_through(rm.Actuator(prestress=2.3), "m", (1.0, 4.0))
    assert ds.snap_m.values == pytest.approx([2.3], abs=1e-12)
    run = rm.simulate(rm.Actuator(prestress=2.3), rm.Constant(0.1), duration=8.0,
                      over={"m": [2.299, 2.301]})  # fmt: skip
    assert (run.stretch.values[:, -1] > 1.0).tolist() == [True, False]
    assert ds.snap_direction.values.tolist() == [-1.0]


def test_nothing_snaps_without_prestress() -> None:
    """With one equilibrium at every load there is nothing to snap to."""
    ds = rm.snap_through(rm.Actuator(), "m", (-3.0, 10.0))
    assert (ds.sizes["fold"], ds.sizes["snap"]) == (0, 0)

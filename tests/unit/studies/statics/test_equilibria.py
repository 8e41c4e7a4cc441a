"""Equilibria and their folds over grids of parameters."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
import sympy as sp

import remanent as rm
from remanent.analysis.statics.rounding import Rounded, RoundedDual
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_errors import squared_frequency_error, stretch_error


def test_folds_are_found_for_each_of_the_other_fields() -> None:
    """Folds over one field are those of each set of the other fields alone."""
    loads = np.linspace(0.5, 6.0, 4)
    over: dict[str, Any] = {"m": loads, "prestress": [1.0, 1.9, 2.2], "temperature": [293.0]}
    ds = rm.equilibria(rm.Actuator(), over=over)
    assert ds.fold_m.dims == ("prestress", "temperature", "fold")
    single = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": loads})
    np.testing.assert_array_equal(ds.fold_m.values[2, 0], single.fold_m.values)
    assert np.isnan(ds.fold_m.values[0]).all()


def test_the_limit_of_a_material_is_no_equilibrium() -> None:
    """Law: a force that grows without bound changes its sign at a pole, and rests nowhere."""
    body = rm.Actuator(
        temperature=281.5342198667933,
        reference_temperature=297.8721755173643,
        prestress=0.8104286717494649,
        material=rm.Gent(12.558486526447425),
    )
    ds = rm.equilibria(body, -1.7759650189179725)
    assert ds.stretch.values == pytest.approx([1.45363326])
    limits = np.random.default_rng(0).uniform(2.0, 40.0, 40)
    for jm in limits.tolist():
        found = rm.equilibria(rm.Actuator(material=rm.Gent(jm)), 0.3)
        assert found.sizes["equilibrium"] == 1
        assert float(found.stretch_error[0]) < 1e-13


def test_an_invalid_point_has_no_numbers_but_folds_of_the_others() -> None:
    """Law: invalid values leave NaN in every variable, and do not hide folds beside them."""
    loads = np.append(np.linspace(1.0, 4.0, 7), np.nan)
    curve = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": loads})
    assert curve.status.values.tolist() == [1] * 7 + [4]
    point = curve.isel(m=-1)
    numbers = [v for v in point.data_vars if v != "status" and "m" in curve[v].dims]
    assert all(np.isnan(point[v]).all() for v in numbers if point[v].dtype.kind == "f")
    whole = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": loads[:-1]})
    assert whole.sizes["fold"] == 2
    np.testing.assert_array_equal(curve.fold_m, whole.fold_m)
    assert (curve.fold_m_error < 1e-13).all()


def test_errors_of_two_coordinates_are_those_of_one_where_they_are_equal() -> None:
    """Law: equal dead loads rest at equal stretches, within both errors."""
    one = rm.equilibria(rm.Actuator(prestress=0.3), 0.2)
    two = rm.equilibria(rm.Actuator(prestress=(0.3, 0.3)), 0.2)
    off = abs(float(two.stretch_1[0]) - float(one.stretch[0]))
    assert off <= float(two.stretch_1_error[0]) + float(one.stretch_error[0])
    assert float(two.stretch_1_error[0]) < 1e-10
    thickness, error = float(two.equilibrium_stretch[0]), float(two.equilibrium_stretch_error[0])
    assert abs(thickness - float(one.equilibrium_stretch[0])) <= error < 1e-10
    modes = two.natural_frequency.values[0]
    near = np.abs(modes - float(one.natural_frequency[0]))
    assert near.min() <= two.natural_frequency_error.values[0][near.argmin()] + 1e-14


#: An oscillator with a force and a varying stiffness, whose loads have names.
NAMED = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="x**4/4 - force*x - softening*x**2/2",
    loads=("force", "softening"),
)
#: The same with the stiffness as a parameter.
PLAIN = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="x**4/4 - load*x - softening*x**2/2",
    parameters={"softening": 0.8},
)


def test_loads_with_names_are_held_like_one_without() -> None:
    """A load that is held is a parameter: rest and free oscillations are the same, bit for bit."""
    held, box = {"softening": 0.8, "force": 0.1}, {"x": (-2.0, 2.0)}
    one, other = rm.equilibria(NAMED, held, state_box=box), rm.equilibria(PLAIN, 0.1, state_box=box)
    for name in ("x", "natural_frequency", "equilibrium_potential"):
        np.testing.assert_array_equal(one[name], other[name])
    assert one.stability.values.tolist() == ["stable", "unstable", "stable"]
    over = rm.equilibria(NAMED, held, state_box=box, over={"force.m": [-0.1, 0.1]})
    np.testing.assert_allclose(over.x[0], -over.x[1][::-1], rtol=1e-15)
    frequency = [rm.backbone(s, [1.5], m=m).frequency for s, m in ((NAMED, held), (PLAIN, 0.1))]
    np.testing.assert_array_equal(*frequency)


@pytest.mark.parametrize("m", [0.1, {}, {"force": 0.1, "load": 0.1}])
def test_loads_are_given_by_their_names(m: Any) -> None:
    """One number for two loads, no load, and an unknown one are refused with the names."""
    with pytest.raises(rm.InputError, match=r"`m` must .*loads .*: force, softening; got"):
        rm.equilibria(NAMED, m, state_box={"x": (-2.0, 2.0)})
    with pytest.raises(rm.InputError, match=r"`m` must .*loads .*: force, softening; got"):
        rm.backbone(NAMED, [1.5], m=m)


def test_motion_from_rest_runs_between_the_turning_points() -> None:
    """Law: energy.  Loads that push both ways, none, and the extremes of the motions themselves."""
    body, loads = rm.Actuator(prestress=0.2), np.array([-0.3, 0.1, 0.2, 0.5])
    ds = rm.equilibria(body, over={"m": loads})
    runs = rm.simulate(
        body, rm.Constant(0.0), over={"m": loads}, times=np.linspace(0.0, 6.0, 3001)
    ).thickness_stretch
    np.testing.assert_allclose(ds.turning_lower, runs.min("time"), atol=2e-5)
    np.testing.assert_allclose(ds.turning_upper, runs.max("time"), atol=2e-5)
    assert (ds.turning_upper - ds.turning_lower > 0.05).values.tolist() == [True, True, False, True]


def test_turning_points_of_a_block_from_rest_have_a_closed_form() -> None:
    """Law: without prestress x turns where m = (x - 1)(x + 2)/(2x), within the stated error."""
    loads = np.array([-0.4, -0.02, 0.05, 0.3, 1.0])
    ds = rm.equilibria(rm.Actuator(), over={"m": loads})
    turn = 0.5 * (2.0 * loads - 1.0 + np.sqrt((2.0 * loads - 1.0) ** 2 + 8.0))
    for name, exact in (("lower", np.minimum(turn, 1.0)), ("upper", np.maximum(turn, 1.0))):
        off = np.abs(ds[f"turning_{name}"] - exact)
        error = ds[f"turning_{name}_error"]
        assert (off <= error + 4e-16 * exact).all()
        assert (error < 1e-12).all()


def test_where_nothing_holds_a_force_there_is_no_eigenvalue_and_no_stability() -> None:
    """Law: x'' = f - x^2 rests at +-sqrt(f), with eigenvalues +-sqrt(-2x), and nowhere if f < 0."""
    system = rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2",
        potential="x**3/3 - force*x",
        loads=("force",),
    )
    ds = rm.equilibria(system, over={"force.m": [-1.0, 1.0]}, state_box={"x": (-3.0, 3.0)})
    np.testing.assert_allclose(ds.x, [[np.nan, np.nan], [-1.0, 1.0]], atol=1e-14)
    assert np.isnan(ds.eigenvalues[0]).all()
    root = np.sqrt(2.0)
    np.testing.assert_allclose(ds.eigenvalues[1], [[root, -root], [1j * root, -1j * root]])
    assert ds.stability.values.tolist() == [["", ""], ["unstable", "stable"]]


def test_a_stiffness_beyond_floats_has_no_frequency_and_no_warning() -> None:
    """The block rests at a stretch of 1, stable, at 1e308 times its reference temperature."""
    with pytest.warns(rm.InputWarning, match="below 100 K"):
        cold = rm.Actuator(reference_temperature=3e-306, material=rm.Gent(0.5, 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rm.InputWarning)
        ds = rm.equilibria(cold, 0.0)
    assert ds.stretch.values.tolist() == [1.0]
    assert ds.stability.values.tolist() == ["stable"]
    assert np.isnan(ds.natural_frequency).all()


def test_the_error_of_a_zero_is_the_force_that_may_be_left_over_the_least_slope() -> None:
    """A force of 1 +- 0.1 (times 1e-12) with the slope -2 +- 0.5, and one of unknown sign."""
    force = RoundedDual(
        Rounded(np.array([1e-12, -1e-12, 1e-12]), np.array([1e-13, 0.0, 0.0])),
        Rounded(np.array([-2.0, 4.0, 0.1]), np.array([0.5, 0.0, 0.2])),
    )
    static = StaticEnsemble(lay_out_ensemble(rm.Actuator(), rm.Constant(0.1)))
    case = np.zeros(3, dtype=np.int64)
    found = stretch_error(static, case, np.ones(3), force)
    np.testing.assert_allclose(found, [1.1e-12 / 1.5, 0.25e-12, np.inf], rtol=1e-14)


def test_the_error_of_a_squared_frequency_is_the_change_of_the_slope() -> None:
    """|F''| times the error of the stretch; F of [Thermal, eq. 16] at rest, at T = T0 and c = 1."""
    x, m, error = sp.Symbol("x"), 0.1, 1e-6
    curvature = sp.diff(-3 * (x - x**-5 + m * x**-3) / (1 + 2 * x**-6), x, 2)
    static = StaticEnsemble(lay_out_ensemble(rm.Actuator(), rm.Constant(m)))
    case, places = np.zeros(3, dtype=np.int64), np.array([0.8, 0.95, 1.1])
    force = static.first_acceleration_with_rounding(case, places)
    found = squared_frequency_error(static, case, places, np.full(3, error), force)
    exact = [error * abs(float(curvature.subs(x, place))) for place in places]
    np.testing.assert_allclose(found, exact, rtol=1e-6)


def test_the_thickness_of_two_stretches_is_off_by_what_they_are_off() -> None:
    """Exact: l3 = 1/(l1 l2), so that relative errors add up, with a few roundings of its own."""
    ds = rm.equilibria(rm.Actuator(prestress=(0.4, 0.1)), over={"m": [0.0, 0.2, 0.4]})
    relative = ds.stretch_1_error / ds.stretch_1 + ds.stretch_2_error / ds.stretch_2
    found = ds.equilibrium_stretch_error / ds.equilibrium_stretch
    np.testing.assert_allclose(found, relative + 4.0 * np.finfo(float).eps, rtol=1e-12)


def test_the_potential_is_tabulated_beyond_rest_and_equilibria() -> None:
    """Three quarters of their distance beyond the outermost, and a tenth more, down to 0.05."""
    ds = rm.equilibria(rm.Actuator(), over={"m": [0.1, 0.6]})
    places = [1.0, *ds.equilibrium_stretch.values[np.isfinite(ds.equilibrium_stretch.values)]]
    margin = 0.75 * np.ptp(places) + 0.1
    ends = (max(0.05, min(places) - margin), max(places) + margin)
    np.testing.assert_allclose(ds.thickness_stretch[[0, -1]], ends, rtol=1e-12)

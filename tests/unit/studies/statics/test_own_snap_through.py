"""Folds, branch points and dynamic thresholds of systems that users write."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import remanent as rm
from remanent.studies.ensemble.constant_drive import constant_drive
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.statics._written_body import WrittenBody
from remanent.studies.statics._written_snaps import _NODES, _WEIGHTS

BALLOON = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - voltage*stretch**4/2",
    rest={"stretch": 1.0},
    loads=("pressure", "voltage"),
    units={"pressure": "kPa"},
)
INFLATED = {"stretch": (0.5, 4.0)}
WELLS = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="-k*x**2/2 + x**4/4 - load*x",
    dissipation="delta*x_rate**2/2",
    parameters={"k": 1.0, "delta": 0.1},
)
#: A bead on a hoop that turns at the rate w: it leaves the lowest point at w = 1.
HOOP = rm.LagrangianSystem(
    coordinates="angle",
    kinetic="angle_rate**2/2 + w**2*sin(angle)**2/2",
    potential="-cos(angle) - load*angle",
    parameters={"w": 0.5},
)
#: Two masses; the second follows the first as y = -c x/2, which leaves x^3 - (k + c^2/2) x = load.
PAIR = rm.LagrangianSystem(
    coordinates=("x", "y"),
    kinetic="(x_rate**2 + 2*y_rate**2)/2",
    potential="-k*x**2/2 + x**4/4 + y**2 + c*x*y - load*x",
    parameters={"k": 1.0, "c": 0.3},
)
SQUARE = {"x": (-3.0, 3.0), "y": (-3.0, 3.1)}


def within(values: Any, errors: Any, exact: Any) -> bool:
    """Each value within its error, which is none of a large one, from an exact one."""
    assert np.shape(values) == np.shape(exact)
    return bool((abs(values - exact) <= errors).all() and float(abs(errors).max()) < 1e-12)


@pytest.mark.parametrize("voltage", [0.0, 0.1, 0.2])
def test_a_balloon_holds_no_more_than_the_largest_pressure(voltage: float) -> None:
    """P = 2/x - 2/x^7 - 2 V x is largest at the fold: at V = 0, x = 7^(1/6) and P = 1.2395."""
    ds = rm.snap_through(
        BALLOON, "pressure.m", (0.0, 2.0), m={"voltage": voltage}, state_box=INFLATED
    )
    x = brentq(lambda x: -2.0 / x**2 + 14.0 / x**8 - 2.0 * voltage, 1.0, 2.0, xtol=1e-15)
    pressure = 2.0 / x - 2.0 / x**7 - 2.0 * voltage * x
    assert ds.status == rm.Status.OK
    assert within(ds["fold_pressure.m"], ds["fold_pressure.m_error"], [pressure])
    assert within(ds.fold_stretch, ds.fold_stretch_error + 1e-15, [x])
    assert ds.fold_stability.values.tolist() == ["stable"]
    assert ds["fold_pressure.m"].attrs["units"] == "kPa"


def test_a_step_of_pressure_bursts_earlier_than_a_slow_rise() -> None:
    """V(x) = V(1) and V'(x) = 0: eliminating P leaves one equation in x."""
    ds = rm.snap_through(BALLOON, "pressure.m", (0.0, 2.0), state_box=INFLATED)

    def pressure(x: float) -> float:
        return 2.0 / x - 2.0 / x**7

    def rise(x: float) -> float:
        return x**2 + x**-4 / 2.0 - 1.5 - pressure(x) * (x**3 - 1.0) / 3.0

    x = brentq(rise, 1.4, 3.0, xtol=1e-15)
    assert within(ds["snap_pressure.m"], ds["snap_pressure.m_error"], [pressure(x)])
    assert within(ds.snap_stretch, ds.snap_stretch_error + 1e-15, [x])
    assert ds.snap_direction.values.tolist() == [1.0]
    runs = [
        rm.simulate(BALLOON, loads, duration=60.0)
        for step in (-1e-3, 1e-3)
        for loads in [{"pressure": rm.Constant(pressure(x) + step), "voltage": rm.Constant(0.0)}]
    ]
    assert float(runs[0].stretch.max()) < x
    assert not float(runs[1].stretch.max()) < x


def test_over_each_case_has_thresholds_of_its_own() -> None:
    """Along other loads, as if each were asked for alone; where no pressure is held, none."""
    voltages = [0.0, 0.2, 0.5]
    ds = rm.snap_through(
        BALLOON, "pressure.m", (0.0, 2.0), over={"voltage.m": voltages}, state_box=INFLATED
    )
    for k, voltage in enumerate(voltages):
        one = rm.snap_through(
            BALLOON, "pressure.m", (0.0, 2.0), m={"voltage": voltage}, state_box=INFLATED
        )
        row = ds["fold_pressure.m"].values[k]
        np.testing.assert_array_equal(row[np.isfinite(row)], one["fold_pressure.m"].values)
    assert np.isnan(ds["fold_pressure.m"].values[2]).all()
    assert (ds.status == rm.Status.OK).all()


@pytest.mark.parametrize("k", [0.3, 1.0, 2.5])
def test_folds_of_two_wells(k: float) -> None:
    """x^3 - k x = load has a double root at x = -+(k/3)^(1/2), load = +-2 (k/3)^(3/2)."""
    ds = rm.snap_through(WELLS.replace(parameters={"k": k}), "m", (-4.0, 4.0),
                         state_box={"x": (-3.0, 3.0)})  # fmt: skip
    load = 2.0 * (k / 3.0) ** 1.5
    assert within(ds.fold_m, ds.fold_m_error + 1e-15, [-load, load])
    assert within(ds.fold_x, ds.fold_x_error + 1e-15, [(k / 3.0) ** 0.5, -((k / 3.0) ** 0.5)])
    assert "snap" not in ds.sizes  # it loses energy: nothing tells how far a motion goes


def test_folds_of_two_coordinates() -> None:
    """The second mass makes k + c^2/2 of k."""
    ds = rm.snap_through(PAIR, "m", (-2.0, 2.0), state_box=SQUARE)
    k = 1.0 + 0.3**2 / 2.0
    load, x = 2.0 * (k / 3.0) ** 1.5, (k / 3.0) ** 0.5
    assert within(ds.fold_m, ds.fold_m_error + 1e-15, [-load, load])
    assert within(ds.fold_x, ds.fold_x_error + 1e-15, [x, -x])
    assert within(ds.fold_y, ds.fold_y_error + 1e-15, [-0.15 * x, 0.15 * x])
    assert ds.sizes["branch_point"] == 0


@pytest.mark.parametrize(
    ("system", "name", "limits", "box", "place"),
    [
        (HOOP, "w", (0.2, 2.0), {"angle": (-3.0, 3.0)}, 1.0),
        (WELLS, "k", (-2.0, 2.1), {"x": (-3.0, 3.0)}, 0.0),
        (PAIR, "k", (-2.0, 2.0), SQUARE, -(0.3**2) / 2.0),
    ],
    ids=["hoop", "wells", "pair"],
)
def test_where_symmetric_systems_buckle_branches_cross(
    system: rm.LagrangianSystem,
    name: str,
    limits: tuple[float, float],
    box: dict[str, tuple[float, float]],
    place: float,
) -> None:
    """The middle loses stability at a pitchfork, which is no fold."""
    ds = rm.snap_through(system, name, limits, state_box=box)
    assert (ds.status.item(), ds.sizes["fold"]) == (rm.Status.OK, 0)
    error = ds[f"branch_point_{name}_error"] + 1e-15
    assert within(ds[f"branch_point_{name}"], error, [place])
    for coordinate in box:
        np.testing.assert_allclose(ds[f"branch_point_{coordinate}"], 0.0, atol=1e-12)


def test_folds_of_equilibria_over_a_load_are_those_of_snap_through() -> None:
    """The first field of `over` has its folds, one for each value of the others."""
    over: dict[str, Any] = {"pressure.m": np.linspace(0.0, 2.0, 5), "voltage.m": [0.0, 0.1]}
    at_rest = rm.equilibria(BALLOON, over=over, state_box=INFLATED)
    ds = rm.snap_through(BALLOON, "pressure.m", (0.0, 2.0), over={"voltage.m": [0.0, 0.1]},
                         state_box=INFLATED)  # fmt: skip
    assert at_rest["fold_pressure.m"].dims == ("voltage.m", "fold")
    np.testing.assert_array_equal(at_rest["fold_pressure.m"], ds["fold_pressure.m"])


def test_folds_of_rates_need_no_energy() -> None:
    """x' = y - x^3 + load, y' = k x - y: x^3 - k x = load, as in the wells."""
    system = rm.FirstOrderSystem(
        rates={"x": "y - x**3 + load", "y": "k*x - y"}, parameters={"k": 1.2}
    )
    box = {"x": (-2.0, 2.0), "y": (-3.0, 3.0)}
    ds = rm.snap_through(system, "m", (-2.0, 2.0), state_box=box)
    assert within(ds.fold_m, ds.fold_m_error + 1e-15, [-2.0 * 0.4**1.5, 2.0 * 0.4**1.5])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"state_box": None}, "`state_box` must give bounds of x"),
        ({"initial": 0.5}, "`initial` must be left out"),
        ({"parameter": "mu"}, "`parameter` must be one of"),
        ({"over": {"m": [0.1]}}, "`over` must not hold m"),
        ({"m": {"push": 0.1}}, "`m` must name loads of the system: load"),
    ],
)
def test_bad_arguments_are_explained(change: dict[str, Any], message: str) -> None:
    """The message names the argument, and says what it must be."""
    sound = {"parameter": "m", "parameter_range": (0.0, 1.0), "state_box": {"x": (-3.0, 3.0)}}
    with pytest.raises(rm.InputError, match=message):
        rm.snap_through(WELLS, **{**sound, **change})


def test_one_number_does_not_say_which_of_several_loads_it_is() -> None:
    """Loads go by their names; those that are left out are 0, and so are all by default."""
    with pytest.raises(rm.InputError, match="`m` must give the loads by their names"):
        constant_drive(BALLOON, 0.3)
    drive = constant_drive(BALLOON, {"voltage": 0.3})
    assert drive.parameter_values() == {"pressure.m": 0.0, "voltage.m": 0.3}
    assert constant_drive(rm.Actuator(), 0.3) == rm.Constant(0.3)


@pytest.mark.parametrize("power", range(1, 32))
def test_mean_slopes_near_the_start_are_exact_integrals(power: int) -> None:
    """Exact: the mean of x^n on [0, 1] is 1/(n + 1), up to n = 31 with sixteen nodes."""
    assert _WEIGHTS @ _NODES**power == pytest.approx(1.0 / (power + 1.0), rel=1e-14)


def test_slopes_of_an_energy_are_its_derivatives_by_each_coordinate() -> None:
    """Exact: x^4/4 - x^2/2 + y^2 + 3 x y/10 - 2 x by x and by y, at places of rest or not."""
    ens = lay_out_ensemble(PAIR, rm.Constant(2.0))
    body = WrittenBody(ens, 0)
    (energy,) = ens.vector_field.energy_names
    x, y = np.random.default_rng(5).uniform(-2.0, 2.0, (2, 9))
    slopes = body.observable_slopes(energy, body.states(np.column_stack([x, y])))
    expected = np.column_stack([x**3 - x + 0.3 * y - 2.0, 2.0 * y + 0.3 * x])
    np.testing.assert_allclose(slopes, expected, rtol=1e-12, atol=1e-12)

"""Derivatives obey the model's own scaling; designs invert what they differentiate."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.orbits._period_map import StroboscopicMap

HOT = rm.Actuator(temperature=350.0)
FOLD = rm.SineSquared(0.4, 1.2668)
START = (1.2268, 0.0)


def test_the_fold_obeys_the_scaling_with_temperature() -> None:
    """omega = sqrt(theta) g(b^2/theta), so that E_T = 1/2 - E_b/2, within the errors."""
    ds = rm.sensitivity(
        rm.locate_bifurcation, HOT, FOLD, "fold", "omega", initial=START, of="omega",
        parameters=["temperature", "b"],
    )  # fmt: skip
    warm, field = ds.elasticity.values
    allowed = float(ds.elasticity_error[0] + 0.5 * ds.elasticity_error[1])
    assert abs(warm - 0.5 + 0.5 * field) <= allowed
    assert allowed < 1e-6


def test_the_fold_moves_as_tangents_say() -> None:
    """d omega/dp = -(w F_p)/(w F_omega), w the left null vector of dF/dy: no differences."""
    fields = ("temperature", "b", "c")
    place = rm.locate_bifurcation(HOT, FOLD, "fold", "omega", initial=START)
    omega, state = float(place.omega), np.array([float(place.stretch), float(place.stretch_rate)])
    map_ = StroboscopicMap(lay_out(HOT, FOLD.replace(omega=omega)), ("omega", *fields), 1e-11)
    image = map_(state[None], np.array([[omega, 350.0, 0.4, 1.0]]), 1)
    left = np.linalg.svd(image.jacobian[0] - np.eye(2))[0][:, -1]
    push = left @ image.parameter_jacobian[0]
    ds = rm.sensitivity(
        rm.locate_bifurcation,
        HOT,
        FOLD,
        "fold",
        "omega",
        initial=START,
        of="omega",
        parameters=fields,
    )
    np.testing.assert_allclose(ds.derivative, -push[1:] / push[0], rtol=1e-6)


def test_the_switch_obeys_the_scaling_with_temperature() -> None:
    """tau ~ 1/sqrt(theta) for a given target: the elasticity is -1/2."""
    ds = rm.sensitivity(
        rm.shape_commands, rm.Actuator(), 1.3, of="switch_time", parameters="temperature"
    )
    assert abs(float(ds.elasticity[0]) + 0.5) <= float(ds.elasticity_error[0])
    assert float(ds.elasticity_error[0]) < 1e-6


def test_the_resonance_and_the_peak() -> None:
    """A measure with a dimension of its own; against a difference of the verb itself."""
    drive = rm.SineSquared(0.4, 1.0)
    ds = rm.sensitivity(
        rm.frequency_response, HOT, drive, [1.0, 1.1], of="maximum", parameters=["c", "prestress"],
        duration=20.0,
    )  # fmt: skip
    assert ds.derivative.dims == ("field", "omega")
    ends = rm.frequency_response(HOT, drive, [1.0, 1.1], duration=20.0, over={"c": [0.999, 1.001]})
    slope = (ends.maximum[1] - ends.maximum[0]) / 0.002
    np.testing.assert_allclose(ds.derivative[0], slope, rtol=1e-4)
    assert (ds.derivative_error < 1e-5).all()


def test_any_function_of_an_actuator_is_a_measure() -> None:
    """omega_n = sqrt(18 theta/(1 + 2c)) at rest: elasticities 1/2 and -c/(1 + 2c)."""

    def natural(actuator: rm.Actuator) -> float:
        return float(rm.equilibria(actuator).natural_frequency[0])

    ds = rm.sensitivity(natural, rm.Actuator(), parameters=["temperature", "c"])
    np.testing.assert_allclose(ds.elasticity, [0.5, -1.0 / 3.0], rtol=1e-9)
    same = rm.sensitivity(
        rm.equilibria, rm.Actuator(), parameters=["temperature", "c"],
        of=lambda found: found.natural_frequency.isel(equilibrium=0),
    )  # fmt: skip
    np.testing.assert_allclose(same.elasticity, [0.5, -1.0 / 3.0], rtol=1e-9)


def test_a_rule_that_differences_would_break_gives_nan() -> None:
    """A viscosity of 0 has no differences to both sides."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.0))
    ds = rm.sensitivity(
        rm.frequency_response, body, rm.SineSquared(0.4, 1.0), [0.8], of="maximum",
        parameters="dissipation.0.eta", duration=5.0,
    )  # fmt: skip
    assert np.isnan(ds.derivative).all()


def test_designs_reach_their_targets() -> None:
    """Two measures, two fields: closed forms of both invert."""

    def natural(actuator: rm.Actuator) -> float:
        return float(rm.equilibria(actuator).natural_frequency[0])

    def held(actuator: rm.Actuator) -> float:
        return float(rm.equilibria(actuator, 0.5).equilibrium_stretch[0])

    measures = [rm.Measure(natural, rm.Actuator()), rm.Measure(held, rm.Actuator())]
    ds = rm.design(measures, [2.0, 1.15], ["temperature", "c"], parameter_ranges={"c": (0.1, 5.0)})
    theta = 0.5 * 1.15**2 / (1.15**3 - 1.0)
    c = (18.0 * theta / 4.0 - 1.0) / 2.0
    np.testing.assert_allclose(ds.solution, [293.0 * theta, c], rtol=1e-8)
    np.testing.assert_allclose(ds.reached, ds.target, rtol=1e-9)


def test_a_switch_is_put_where_it_is_wanted() -> None:
    """By temperature: 293 (tau/1.4)^2, as the time scales with its root; the error covers."""
    switch = rm.Measure(rm.shape_commands, rm.Actuator(), 1.5, of="switch_time")
    ds = rm.design(switch, 1.4, "temperature")
    exact = 293.0 * (float(rm.shape_command(rm.Actuator(), 1.5).times[1]) / 1.4) ** 2
    assert abs(float(ds.solution[0]) - exact) <= float(ds.solution_error[0])
    assert float(ds.solution_error[0]) < 1e-5


def test_a_fold_is_put_where_it_is_wanted() -> None:
    """By the field's strength; the diagram's own fold is there afterwards."""
    place = rm.Measure(rm.locate_bifurcation, HOT, FOLD, "fold", "omega", initial=START, of="omega")
    ds = rm.design(place, 1.26, "b", parameter_ranges={"b": (0.3, 0.6)})
    drive = FOLD.replace(b=float(ds.solution[0]), omega=1.2599)
    there = rm.locate_bifurcation(HOT, drive, "fold", "omega", initial=START)
    near = (float(there.stretch), float(there.stretch_rate))
    branch = rm.continue_orbit(HOT, drive, "omega", (1.0, 1.6), initial=near)
    folds = branch.special_omega[branch.special_kind == "fold"]
    assert np.abs(folds - 1.26).min() < 1e-7


def test_special_points_over_a_grid_are_those_of_branches() -> None:
    """Moved from one temperature to others, each is the fold of its own branch."""
    over = {"temperature": [345.0, 355.0]}
    ds = rm.locate_bifurcation(HOT, FOLD, "fold", "omega", initial=START, over=over)
    branch = rm.continue_orbit(
        HOT.replace(temperature=355.0), FOLD, "omega", (1.0, 1.6), initial=START
    )
    fold = branch.special_omega[branch.special_kind == "fold"]
    assert float(ds.omega[1]) == pytest.approx(float(fold[0]), abs=1e-8)
    assert (ds.omega_error < 1e-8).all()


def test_what_cannot_be_measured_is_refused() -> None:
    """The message says what is missing."""
    with pytest.raises(rm.InputError, match="`parameters` must name fields"):
        rm.sensitivity(
            rm.shape_commands, rm.Actuator(), 1.5, of="switch_time", parameters="stiffness"
        )
    with pytest.raises(rm.InputError, match="switch_time"):
        rm.sensitivity(rm.shape_commands, rm.Actuator(), 1.5, of="switch", parameters="c")
    with pytest.raises(rm.InputError, match="sample"):
        rm.sensitivity(
            rm.shape_commands,
            rm.Actuator(),
            1.5,
            parameters="c",
            of=lambda ds: ds.switch_time.mean(),
        )
    with pytest.raises(rm.InputError, match="actuator"):
        rm.sensitivity(xr.Dataset, parameters="c")
    measure = rm.Measure(rm.shape_commands, rm.Actuator(), 1.5, of="switch_time")
    with pytest.raises(rm.InputError, match="1 values"):
        rm.design(measure, [1.0, 2.0], "c")
    with pytest.raises(rm.InputError, match="around"):
        rm.design(measure, 1.0, "c", parameter_ranges={"c": (2.0, 3.0)})

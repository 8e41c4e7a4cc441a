"""Designs invert the measures that they aim with."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import remanent as rm

HOT = rm.Actuator(temperature=350.0)
FOLD = rm.SineSquared(0.4, 1.2668)
START = (1.2268, 0.0)


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


def test_targets_that_cannot_be_reached_are_refused() -> None:
    """The message says what is missing."""
    measure = rm.Measure(rm.shape_commands, rm.Actuator(), 1.5, of="switch_time")
    with pytest.raises(rm.InputError, match="1 values"):
        rm.design(measure, [1.0, 2.0], "c")
    with pytest.raises(rm.InputError, match="around"):
        rm.design(measure, 1.0, "c", parameter_ranges={"c": (2.0, 3.0)})


def test_a_target_out_of_reach_has_a_status() -> None:
    """No prestress gives this block a natural frequency of 5; a lost equilibrium is no crash."""
    natural = rm.Measure(
        rm.equilibria, rm.Actuator(), 0.16,
        of=lambda found: found.natural_frequency.isel(equilibrium=0, drop=True),
    )  # fmt: skip
    missed = rm.design(natural, 5.0, "prestress", parameter_ranges={"prestress": (-5.0, 5.0)})
    assert int(missed.status) == rm.Status.INCOMPLETE
    assert "missed" in missed.attrs["reason"]
    reached = rm.design(natural, 2.4, "prestress")
    assert int(reached.status) == rm.Status.OK
    body = rm.read_system(reached)
    assert isinstance(body, rm.Actuator)
    assert float(rm.equilibria(body, 0.16).natural_frequency[0]) == pytest.approx(2.4, abs=1e-6)


def test_only_the_solution_is_warned_of() -> None:
    """A search that tries cold blocks says so where it ends in one, and not of every step."""
    natural = rm.Measure(rm.equilibria, rm.Actuator(), 0.16, of="turning_upper")
    for target, is_cold in ((1.2, False), (1.5, True)):  # reached at 176 K and 80 K
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", rm.InputWarning)
            rm.design(natural, target, "temperature")
        told = {str(warning.message) for warning in caught}
        assert len(told) == int(is_cold)
        assert all("80.3657 K" in message for message in told)

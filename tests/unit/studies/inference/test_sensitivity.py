"""Derivatives obey the model's own scaling."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.inference.sensitivity import _DifferenceStencil
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
    map_ = StroboscopicMap(
        lay_out_ensemble(HOT, FOLD.replace(omega=omega)), ("omega", *fields), 1e-11
    )
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
    assert (ds.status == rm.Status.INCOMPLETE).all()
    assert "break a rule" in ds.attrs["reason"]
    for step in (0.0, 1e-10, 1.0, 25.0):
        with pytest.raises(rm.InputError, match="between 1e-9 and 1"):
            rm.sensitivity(rm.backbone, rm.Actuator(), [1.1], parameters="c", step=step)


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


def test_what_a_measure_may_be_off_is_in_the_error_of_its_slope() -> None:
    """3 x + 5 y about (2, 0), to 1e-3: an error that changes over the size of a field tilts it."""
    stencil = _DifferenceStencil.centred_at(np.array([2.0, 0.0]), 0.02)
    values = stencil.points @ [3.0, 5.0]
    noise = np.full((len(values), 1), 1e-3)
    slopes, errors = stencil.derivatives(values[:, None], noise)
    np.testing.assert_allclose(slopes[:, 0], [3.0, 5.0], rtol=1e-9)
    assert (errors[:, 0] >= 1e-3 / np.array([2.0, 1.0])).all()
    assert (errors[:, 0] < 1e-2).all()

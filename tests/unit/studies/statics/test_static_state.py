"""The state at rest that holds a given thickness, and its motion nearby."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent.analysis.control.shaping import controllable_poles
from remanent.codegen.build import build_field
from remanent.studies.statics._static_state import StaticState


def test_rest_and_poles_of_two_coordinates() -> None:
    """Equal dead loads leave one mode to move, that of one coordinate; unequal ones both."""
    pair = rm.Actuator(prestress=(0.2, 0.2))
    field = build_field(pair, rm.Constant(0.1))
    own = {**pair.parameter_values(), "m": 0.0}
    row = np.array([own[name] for name in field.parameter_names])
    body = StaticState(field, row, np.array([1.0, 0.0, 1.0, 0.0])).rest_at_thickness(1.2)
    assert body is not None
    one = rm.equilibria(rm.Actuator(prestress=0.2), body.magnetic_load)
    assert float(one.equilibrium_stretch[0]) == pytest.approx(1.2, abs=1e-12)
    modes = controllable_poles(*body.rate_derivatives())
    np.testing.assert_allclose(
        sorted(modes.imag), np.array([-1, 1]) * float(one.natural_frequency[0])
    )
    row[field.parameter_names.index("prestress_2")] = 0.3
    bent = StaticState(field, row, body.state).rest_at_thickness(1.2)
    assert bent is not None
    assert controllable_poles(*bent.rate_derivatives()).size == 4
    assert bent.thickness() == pytest.approx(1.2, abs=1e-12)

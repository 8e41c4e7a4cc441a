"""Thresholds of snap-through over grids of parameters, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent._errors import InputError


def test_thresholds_over_other_fields() -> None:
    """Each set has its own threshold, which does not depend on inertia."""
    over = {"prestress": [-1.0, 1.9, 2.2], "c": [0.1, 1.0]}
    ds = rm.snap_through(rm.Actuator(), "m", (1.0, 4.0), over=over, initial=1.9)
    assert ds.snap_m.dims == ("prestress", "c", "snap")
    np.testing.assert_array_equal(ds.snap_m[:, 0], ds.snap_m[:, 1])
    assert np.isnan(ds.snap_m.values[0]).all()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"actuator": rm.Actuator(dissipation=rm.Rayleigh(0.1))}, "no dissipation and no heat"),
        ({"parameter": "load"}, "`parameter` must be one of"),
        ({"parameter_range": (2.0, 1.0)}, "`parameter_range` must be the lowest and the highest"),
        ({"over": {"m": [1.0]}}, "`over` must not hold m"),
        ({"initial": -1.0}, "`initial` must have a stretch greater than 0"),
    ],
)
def test_bad_arguments_are_explained(fields: dict[str, object], message: str) -> None:
    """The message names the argument, and says what it must be."""
    given = {"actuator": rm.Actuator(), "parameter": "m", "parameter_range": (0.0, 1.0), **fields}
    with pytest.raises(InputError, match=message):
        rm.snap_through(**given)  # type: ignore[arg-type]


@pytest.mark.parametrize("parameter", ["c", "prestress"])
def test_a_load_that_is_held_can_be_read_back(parameter: str) -> None:
    """Invariant: a result names its drive, but where it looks for the load itself."""
    held = rm.snap_through(rm.Actuator(prestress=2.2), parameter, (0.5, 1.0), m=0.3)
    assert rm.read_drive(held) == rm.Constant(0.3)
    with pytest.raises(InputError, match="which drive"):
        rm.read_drive(rm.snap_through(rm.Actuator(prestress=2.2), "m", (0.0, 5.0)))

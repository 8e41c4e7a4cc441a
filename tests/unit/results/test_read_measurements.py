"""What a file of measurements must say, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import remanent as rm

PHYSICAL = rm.Actuator.from_si(
    shear_modulus="1 MPa", density="2000 kg/m^3", half_length="5 mm", half_thickness="5 mm",
    remanence="1 T", force="3 N",
)  # fmt: skip


def test_bad_measurements_are_refused(tmp_path: Path) -> None:
    """The message says which column, and why."""
    with pytest.raises(rm.InputError, match="from_si"):
        rm.read_measurements({"time [ms]": [0.0, 1.0], "stretch": [1.0, 1.0]}, rm.Actuator())
    with pytest.raises(rm.InputError, match="dimension of s"):
        rm.read_measurements({"time [kg]": [0.0], "stretch": [1.0]}, PHYSICAL)
    with pytest.raises(rm.InputError, match="schema"):
        rm.read_measurements({"time": [0.0, 1.0], "strech": [1.0, 1.0]})
    with pytest.raises(rm.InputError, match="readable"):
        rm.read_measurements(tmp_path / "missing.csv")
    with pytest.raises(rm.InputError, match="`time` or `omega`"):
        rm.read_measurements({"stretch": [1.0, 1.0]})

"""What is looked at, as plain data, is read as a study file is, and written back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import remanent as rm
from remanent.page.spec import read_spec, write_spec
from remanent.page.toml import toml_text
from remanent.studies.sweep.faults import FaultsError
from remanent.studies.sweep.study_file import read_study
from tests.contracts.exported import CASES

DRIVE = {"kind": "SineSquared", "b": 0.4, "omega": 1.25}
FILM = {
    "shear_modulus": "100 kPa", "density": "2000 kg/m^3", "half_length": "5 mm",
    "half_thickness": "0.5 mm", "remanence": "143 mT",
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_description_is_read_as_it_was_written(case: str) -> None:
    """Law: reading what was written gives equal values, also through JSON."""
    system, drive = CASES[case]
    spec = json.loads(json.dumps(write_spec(system, drive, {})))
    assert read_spec(spec) == (system, drive, {})


def test_sizes_in_si_are_kept() -> None:
    """Law: scales come back to the last digits; loads with units are read by them."""
    spec = {
        "actuator": {"si": FILM, "temperature": 350.0, "prestress": 0.2},
        "drive": {**DRIVE, "b": "140 mT"},
    }
    system, drive, _ = read_spec(spec)
    assert isinstance(system, rm.Actuator)
    again, same, _ = read_spec(write_spec(system, drive, {}))
    assert isinstance(again, rm.Actuator)
    assert again.scales == system.scales
    assert (again.temperature, again.prestress) == (350.0, 0.2)
    assert again.c == pytest.approx(system.c, rel=1e-15)
    assert same == drive
    assert drive.parameter_values()["b"] == pytest.approx(float(system.load("140 mT")) ** 0.5)


def test_parts_have_units_as_in_a_study_file(tmp_path: Path) -> None:
    """Law: tables are read as those of a study file, with units in the parts of the actuator."""
    spec: dict[str, Any] = {
        "actuator": {"dissipation": [{"kind": "Rayleigh", "eta": "20 Pa s"}], "si": FILM},
        "drive": {"kind": "Sine", "m": "140 mT", "omega": "50 Hz"},
    }
    path = tmp_path / "study.toml"
    path.write_text(
        toml_text({"verb": "simulate", **spec, "over": {"temperature": [300.0]},
                   "options": {"duration": 1.0}}), "utf-8"
    )  # fmt: skip
    study = read_study(path).study
    assert read_spec(spec)[:2] == (study.system, study.drive)


def test_faults_of_sizes_hide_no_units() -> None:
    """Law: where the sizes have a fault it is told, and units beside them are not."""
    spec = {
        "actuator": {"si": {**FILM, "density": "heavy"}},
        "drive": {"kind": "Sine", "m": "140 mT", "omega": "50 Hz"},
    }
    with pytest.raises(FaultsError) as caught:
        read_spec(spec)
    assert [fault.path for fault in caught.value.faults] == [("actuator", "si", "density")]


def test_starts_are_read_by_name() -> None:
    """Law: what is named starts there; it is written back."""
    spec = {"actuator": {}, "drive": DRIVE, "initial": {"stretch": 1.1}}
    system, drive, initial = read_spec(spec)
    assert initial == {"stretch": 1.1}
    assert write_spec(system, drive, initial)["initial"] == {"stretch": 1.1}


def test_what_no_table_says_is_refused() -> None:
    """Law: nothing is dropped in silence: sizes over their own are refused, those of 1 are not."""
    varied = rm.Actuator().with_parameter("density", 1.0)
    assert read_spec(write_spec(varied, rm.Constant(0.1), {}))[0] == rm.Actuator()
    with pytest.raises(rm.InputError, match="physical sizes"):
        write_spec(varied.with_parameter("density", 2.0), rm.Constant(0.1), {})


@pytest.mark.parametrize(
    ("spec", "places"),
    [
        ([], [()]),
        ({}, [("actuator",), ("drive",)]),
        ({"actuator": {}, "system": {}, "drive": DRIVE}, [("actuator",)]),
        ({"actuator": {}, "drive": DRIVE, "verb": "classify"}, [("verb",)]),
        ({"actuator": {"c": -1}, "drive": {"kind": "Sine", "m": "x", "omega": 0}},
         [("actuator", "c"), ("drive", "m"), ("drive", "omega")]),
        ({"actuator": {"material": {"kind": "Gent"}}, "drive": DRIVE},
         [("actuator", "material", "jm")]),
        ({"actuator": {}, "drive": DRIVE, "initial": {"stretch": "far"}}, [("initial", "stretch")]),
        ({"system": {"kind": "os.system"}, "drive": DRIVE}, [("system", "kind")]),
    ],
)  # fmt: skip
def test_every_fault_has_its_place(spec: Any, places: list[tuple[str, ...]]) -> None:
    """Law: all faults at once, each with table and key."""
    with pytest.raises(FaultsError) as caught:
        read_spec(spec)
    assert [fault.path for fault in caught.value.faults] == places
    assert all(fault.why and fault.fix for fault in caught.value.faults)

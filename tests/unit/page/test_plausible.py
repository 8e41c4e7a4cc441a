"""How large numbers may be on a page: all that is usual is followed, slips of the keyboard not."""

from __future__ import annotations

from typing import Any

import pytest

import remanent as rm
from remanent.page.kinds import kinds
from remanent.page.model import page_model
from remanent.page.plausible import faults_of_size
from remanent.page.presets import presets
from remanent.page.spec import read_spec
from remanent.studies.sweep.faults import FaultsError
from remanent.web.subjects import read_subject

SIZES = {"shear_modulus": "100 kPa", "density": "2000 kg/m^3", "half_length": "5 mm",
         "half_thickness": "2 mm", "remanence": "143 mT"}  # fmt: skip


@pytest.mark.parametrize("preset", presets(), ids=lambda one: one["id"])
def test_presets_are_followed(preset: dict[str, Any]) -> None:
    """Law: whatever the page itself offers is within its bounds."""
    assert faults_of_size(*read_spec(preset["spec"])) == []


def test_kinds_are_followed() -> None:
    """Law: so are the usual numbers of every kind of part."""
    for group in ("drive", "material", "dissipation", "heat", "magnet"):
        for kind in kinds()[group]:
            spec: dict[str, Any] = {"actuator": {}, "drive": {"kind": "Constant", "m": 0.1}}
            if group == "drive":
                spec["drive"] = kind["table"]
            else:
                table = kind["table"]
                spec["actuator"][group] = [table] if group == "dissipation" else table
            assert read_subject(spec).system is not None


def test_sliders_end_within_the_bounds() -> None:
    """Law: nothing that a slider reaches is refused."""
    system = rm.Actuator(prestress=(0.1, 0.2), dissipation=(rm.Rayleigh(0.1), rm.Zener(0.5, 1.0)))
    for drive in (rm.SineSquared(0.4, 1.25), rm.Sine(0.2, 1.0), rm.Chirp(0.05, 1.0, 4.0, 100.0)):
        for one in page_model(system, drive).description["parameters"]:
            assert one["bounds"]["least"] <= one["min"] < one["max"] <= one["bounds"]["most"]


@pytest.mark.parametrize(
    ("table", "change", "key"),
    [
        ("actuator", {"temperature": 1e308}, "temperature"),
        ("actuator", {"prestress": [0.0, -1e5]}, "prestress.1"),
        ("actuator", {"dissipation": [{"kind": "Rayleigh", "eta": 1e200}]}, "dissipation.0.eta"),
        ("actuator", {"si": {**SIZES, "shear_modulus": "1e300 Pa"}}, "si.shear_modulus"),
        ("drive", {"omega": 1e12}, "omega"),
        ("drive", {"kind": "Steps", "times": [0, 1], "loads": [0, 1e30]}, "loads.1"),
        ("initial", {"stretch": 1e200}, "stretch"),
        ("initial", {"stretch_rate": -1e300}, "stretch_rate"),
    ],
)
def test_numbers_that_no_block_has_are_refused_in_words(
    table: str, change: dict[str, Any], key: str
) -> None:
    """Law: the place, the bounds and the reason are told."""
    spec: dict[str, Any] = {
        "actuator": {}, "drive": {"kind": "SineSquared", "b": 0.4, "omega": 1.25}
    }  # fmt: skip
    spec[table] = change if "kind" in change else {**spec.get(table, {}), **change}
    with pytest.raises(FaultsError) as caught:
        read_subject(spec)
    (fault,) = caught.value.faults
    assert ".".join(map(str, fault.path)) == f"{table}.{key}"
    assert "be between" in fault.must
    assert fault.why.endswith(".")


def test_systems_of_ones_own_have_units_of_their_own() -> None:
    """Law: of their numbers nothing is known, but that enormous ones are slips too."""
    system = rm.LagrangianSystem(
        coordinates="x", kinetic="mass*x_rate**2/2", potential="stiffness*x**2/2 - load*x",
        parameters={"mass": 1e-3, "stiffness": 1e6},
    )  # fmt: skip
    assert faults_of_size(system, rm.Sine(5e4, 3e4), {"x": -2e3}) == []
    assert faults_of_size(system, rm.Sine(1e10, 3e4), {})

"""Laws of what a result says of its making, and of reading that back."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.models.drives.base import Drive
from remanent.results import build, provenance
from tests.contracts.test_elements import ELEMENTS
from tests.contracts.test_materials import MATERIALS

DRIVES: tuple[Drive, ...] = (
    rm.Constant(0.1 + 0.2),
    rm.SineSquared(0.4, 1.25, 0.3),
    rm.Sines([0.1, 0.05], [1, 2**0.5], 2.5),
    rm.Steps([0.0, 1.0 / 3.0], [0.1, 0.2]),
    rm.Sampled(np.linspace(0.0, 1.0, 11), np.sqrt(np.arange(11.0))),
)


class Callback(Drive):
    """A drive of somebody's own, which is not public."""

    def __call__(self, tau: Any) -> Any:
        return 0.0 * np.asarray(tau)

    def load(self, p: Any, u: Any, phase: Any, fn: Any) -> Any:
        return 0

    def load_schedule(self, values: Any, duration: Any) -> Any:
        raise NotImplementedError


@dataclass(frozen=True)
class Keeper:
    """A dataclass that holds no plain data."""

    function: Any


def described(system: object, drive: object, **more: Any) -> xr.Dataset:
    return xr.Dataset(attrs=provenance.attributes(system, drive, 1e-9, **more))


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: type(drive).__name__)
@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS.keys())
def test_system_and_drive_are_rebuilt(material: Any, drive: Drive) -> None:
    """What is read from the attributes equals what was passed."""
    system = rm.Actuator(material=material, dissipation=tuple(ELEMENTS.values()), prestress=1 / 3)
    dataset = described(system, drive)
    assert provenance.read_system(dataset) == system
    assert provenance.read_drive(dataset) == drive


def test_attributes_are_those_of_a_verb() -> None:
    """A verb's Dataset says which system and drive made it, scales included."""
    film = rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm",
        half_thickness="0.5 mm", remanence="143 mT",
    )  # fmt: skip
    result = rm.simulate(film, rm.Constant(0.1), times=[0.0, 1.0])
    rebuilt = provenance.read_system(result)
    assert rebuilt == film
    assert rebuilt.scales == film.scales
    assert rm.to_si(rm.simulate(rebuilt, rm.Constant(0.1), times=[0.0, 1.0])).equals(
        rm.to_si(result)
    )


def test_a_selected_point_has_the_system_of_that_point() -> None:
    """Fields of `over` have the value that the Dataset was reduced to, if it was."""
    over = {"temperature": [250.0, 350.0], "b": [0.3, 0.4], "material.jm": [10.0, 20.0]}
    result = rm.simulate(
        rm.Actuator(material=rm.Gent(30.0)), rm.SineSquared(0.1, 1.0), times=[0.0, 1.0], over=over
    )
    assert provenance.varying_field_names(result) == list(over)
    point = result.sel(temperature=350.0).isel({"b": 0, "material.jm": 1})
    assert provenance.varying_field_names(point) == []
    assert provenance.read_system(point) == rm.Actuator(temperature=350.0, material=rm.Gent(20.0))
    assert provenance.read_drive(point) == rm.SineSquared(0.3, 1.0)
    assert provenance.varying_field_names(result.isel(b=0, drop=True)) == list(over)


def test_what_is_not_public_is_text_or_refused() -> None:
    """A class of the user's own is described, but not imported by what a file says."""
    attrs = provenance.attributes(rm.Actuator(), Callback(), None)
    assert json.loads(attrs["drive"])["kind"].endswith(".Callback")
    with pytest.raises(rm.InputError, match=r"Callback.*of your own"):
        provenance.read_drive(xr.Dataset(attrs=attrs))
    attrs = provenance.attributes(Keeper(print), None, None)
    assert "system" not in attrs
    assert attrs["system_text"] == repr(Keeper(print))
    with pytest.raises(rm.InputError, match="Pass system="):
        provenance.read_system(xr.Dataset(attrs=attrs))


@pytest.mark.parametrize("text", ["", "Actuator()", "[1, 2]", "3"])
def test_missing_attributes_are_refused_with_the_remedy(text: str) -> None:
    """Arithmetic drops attributes: they can be given again."""
    with pytest.raises(rm.InputError, match="Pass system="):
        provenance.read_system(xr.Dataset(attrs={"system": text}))


def test_a_drive_is_no_system() -> None:
    """Each attribute holds its own kind of value."""
    swapped = described(rm.Constant(0.1), rm.Actuator())
    with pytest.raises(rm.InputError, match="which system"):
        provenance.read_system(swapped)
    with pytest.raises(rm.InputError, match="which drive"):
        provenance.read_drive(swapped)


def test_equal_runs_have_equal_provenance() -> None:
    """Nothing in the attributes depends on when they were made."""
    first, second = (
        provenance.attributes(rm.Actuator(), rm.Constant(0.1), 1e-9, over=["omega"], every=2)
        for _ in range(2)
    )
    assert first == second
    assert not {"time", "date", "history", "created"} & set(first)


def test_provenance_says_what_made_it() -> None:
    """System, drive, tolerance, versions and settings are all there."""
    attrs = provenance.attributes(
        rm.Actuator(), rm.Constant(0.1), 1e-6, over=["b", "omega"], duration=100.0, every=None,
        ranges=[(1.0, 2.0), (3.0, 4.0)],
    )  # fmt: skip
    assert attrs["system_text"] == repr(rm.Actuator())
    assert attrs["drive_text"] == repr(rm.Constant(0.1))
    assert (attrs["over"], attrs["settings"]) == ("b omega", "duration ranges")
    assert (attrs["tolerance"], attrs["duration"]) == (1e-6, 100.0)
    assert attrs["ranges"] == (1.0, 2.0, 3.0, 4.0)
    assert {"remanent", "numpy", "llvmlite"} <= set(attrs["versions"].replace(",", "").split())
    assert "every" not in attrs


def test_long_tables_are_cut_in_the_text_only() -> None:
    """A signal of many samples is whole in the data, short for people."""
    drive = rm.Sampled(np.arange(1e4), np.arange(1e4))
    dataset = build.dataset({}, {}, provenance.attributes(rm.Actuator(), drive, None))
    assert len(dataset.attrs["drive_text"]) <= provenance.MAX_MODEL_TEXT_LENGTH
    assert provenance.read_drive(dataset) == drive

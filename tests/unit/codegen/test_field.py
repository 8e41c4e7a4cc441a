"""Fields come from memory, from the cache or from the derivation, and are always equal."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from remanent import _cache
from remanent._field import Field
from remanent.codegen import field as module
from remanent.codegen import reference
from remanent.codegen.build import build_field
from remanent.codegen.field import vector_field_for
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Rayleigh
from remanent.models.drives.piecewise import Ramp, Steps
from remanent.models.drives.waves import Constant, SineSquared
from remanent.models.materials.named import NeoHookean


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache on disk, and nothing in memory."""
    monkeypatch.setenv("REMANENT_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(module, "_fields_by_fingerprint", {})
    return tmp_path / "cache"


@pytest.fixture
def derivations(fresh: Path, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Filled with an entry for each derivation."""
    assert not fresh.exists()
    done: list[Any] = []

    def derived(actuator: Actuator, drive: Any) -> Field:
        done.append((actuator, drive))
        return build_field(actuator, drive)

    monkeypatch.setattr(module, "_derive_field", derived)
    return done


def test_names_of_the_field_of_the_reproduced_article() -> None:
    """A field lists its states, parameters, waveforms and observables, in a fixed order."""
    field = vector_field_for(Actuator(dissipation=Rayleigh(0.1)), SineSquared(0.4, 1.25))
    assert field.state_names == ("stretch", "stretch_rate")
    assert field.parameter_names == (
        "c",
        "temperature",
        "reference_temperature",
        "prestress",
        "material.entropic_fraction",
        "dissipation.0.eta",
        "magnet.temperature_coefficient",
        "b",
        "omega",
        "phase",
    )
    assert field.waveform_names == ("sin_pi_phase", "cos_pi_phase")
    assert set(field.observables) == {
        "thickness_stretch",
        "thickness_stretch_rate",
        "energy",
        "load",
        "stored_energy",
        "drive_power",
        "dissipated_power",
    }


def test_values_of_parameters_make_no_new_field(derivations: list[Any]) -> None:
    """Other numbers use the field that has been derived."""
    first = vector_field_for(Actuator(), Constant(0.1))
    assert vector_field_for(Actuator(temperature=350.0), Constant(0.2)) is first
    assert len(derivations) == 1


def test_field_is_read_from_the_cache(
    derivations: list[Any], fresh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A field from the cache is the one that was stored, and is not derived again."""
    first = vector_field_for(Actuator(), Constant(0.1))
    assert len(list(fresh.rglob("*"))) == 2
    monkeypatch.setattr(module, "_fields_by_fingerprint", {})
    assert vector_field_for(Actuator(), Constant(0.1)).to_json() == first.to_json()
    assert len(derivations) == 1


@pytest.mark.parametrize("text", ["", "{}", "[]", "not JSON", '{"state": 1}'])
def test_unreadable_entries_are_derived_again(text: str, derivations: list[Any]) -> None:
    """A damaged entry costs a derivation, and changes nothing."""
    actuator, drive = Actuator(), Constant(0.1)
    key = module.structure_fingerprint((actuator.equation_structure(), drive.equation_structure()))
    assert _cache.store_text("fields", key, text)
    assert vector_field_for(actuator, drive).to_json() == build_field(actuator, drive).to_json()
    assert len(derivations) == 1


def test_choices_and_kinds_have_their_own_fingerprint() -> None:
    """Different structures have different fingerprints."""
    structures = [
        (actuator.equation_structure(), drive.equation_structure())
        for actuator in (Actuator(), Actuator(dissipation=Rayleigh(0.1)))
        for drive in (Constant(0.1), SineSquared(0.4, 1.0), Steps([0.0], [0.1]))
    ]
    assert len({module.structure_fingerprint(s) for s in structures}) == len(structures)


def test_tables_of_all_kinds_and_lengths_share_their_equations() -> None:
    """One compiled kernel serves steps, ramps and sampled signals."""
    steps = vector_field_for(Actuator(), Steps([0.0, 1.0], [0.1, 0.2]))
    ramp = vector_field_for(Actuator(), Ramp([0.0, 1.0, 2.0], [0.1, 0.2, 0.3]))
    assert steps.fingerprint == ramp.fingerprint


@dataclass(frozen=True)
class Homemade(NeoHookean):
    """A material of somebody else's, whose code may change without notice."""


def test_foreign_parts_are_derived_every_time(derivations: list[Any], fresh: Path) -> None:
    """A part that is not of the package leaves nothing in the cache."""
    for _ in range(2):
        vector_field_for(Actuator(material=Homemade()), Constant(0.1))
    assert len(derivations) == 2
    assert not list(fresh.rglob("*"))


@pytest.mark.usefixtures("fresh")
def test_a_cached_field_needs_no_sympy() -> None:
    """SymPy is imported for the first derivation only."""
    script = (
        "import sys\n"
        "from remanent.codegen.field import vector_field_for\n"
        "from remanent.models.actuator import Actuator\n"
        "from remanent.models.drives.waves import Constant\n"
        "vector_field_for(Actuator(), Constant(0.1))\n"
        "print('sympy' in sys.modules)"
    )
    command, environment = [sys.executable, "-c", script], dict(os.environ)
    runs = [
        subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert [run.strip() for run in runs] == ["True", "False"]


def test_reference_evaluates_rows() -> None:
    """At rest the acceleration is 3 (S - m)/(1 + 2 c), the energy -m."""
    actuator, drive = Actuator(), Constant(0.1)
    field = vector_field_for(actuator, drive)
    own = {**actuator.parameter_values(), **drive.parameter_values()}
    loads, prestresses = np.array([0.1, -0.2, 0.0]), np.array([0.0, 1.0, 0.5])
    rows = [
        list({**own, "m": m, "prestress": s}.values())
        for m, s in zip(loads, prestresses, strict=True)
    ]
    y, p, u = np.tile([1.0, 0.0], (3, 1)), np.array(rows), np.empty(0)
    rates = reference.evaluate_rates(field, 0.0, y, p, u)
    np.testing.assert_allclose(rates[:, 1], prestresses - loads, rtol=1e-15)
    np.testing.assert_array_equal(rates[:, 0], 0.0)
    np.testing.assert_array_equal(
        reference.evaluate_observables(field, 0.0, y, p, u)["energy"], -loads
    )
    seen = reference.evaluate_observable_and_rates(field, 0.0, y, p, u)
    np.testing.assert_allclose(seen[:, 0], 1.0, rtol=1e-15)
    np.testing.assert_array_equal(seen[:, [1, 3]], 0.0)
    np.testing.assert_allclose(seen[:, 2], -2.0 * rates[:, 1], rtol=1e-15)
    with pytest.raises(ValueError, match="do not fit"):
        reference.evaluate_rates(field, 0.0, y, p[:, :-1], u)

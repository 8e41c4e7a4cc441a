"""The lines and the study file that a page gives away make what it shows."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import remanent as rm
from remanent.page.presets import presets
from remanent.page.reproduction import reproduction
from remanent.page.spec import read_spec, write_spec
from remanent.page.toml import toml_text
from remanent.studies.sweep.study_file import read_study
from tests.contracts.exported import CASES
from tests.repetitions import fast_and_slow

#: Systems whose equations take long to derive.
TAKE_A_SECOND = {"of Ogden", "of ArrudaBoyce", "two stretches", "pair", "magnet", "Prony series"}
PRESETS = {one["id"]: one["spec"] for one in presets()}
FILM = {
    "actuator": {
        "si": {"shear_modulus": "100 kPa", "density": "2000 kg/m^3", "half_length": "5 mm",
               "half_thickness": "0.5 mm", "remanence": "143 mT"},
        "prestress": 0.1, "material": {"kind": "Gent", "jm": 30.0},
    },
    "drive": {"kind": "SineSquared", "b": "140 mT", "omega": "50 Hz"},
}  # fmt: skip
SPECS: dict[str, Any] = {
    **{name: PRESETS[name] for name in ("figure-6", "two-wells", "parametric", "viscoelastic")},
    "film": FILM,
}


def run_python(text: str, folder: Path, *, until: str | None = None) -> dict[str, Any]:
    """What lines of Python leave behind, up to one of them."""
    path = folder / "lines.py"
    lines = text.splitlines()
    kept = lines if until is None else lines[: lines.index(until)]
    path.write_text("\n".join(kept), encoding="utf-8")
    found = runpy.run_path(str(path))
    plt.close("all")
    return found


@pytest.mark.parametrize("name", SPECS)
def test_lines_and_study_make_the_same_motion(name: str, tmp_path: Path) -> None:
    """Law: both give, to the last bit, what the package gives for the spec."""
    system, drive, initial = read_spec(SPECS[name])
    length = {"periods": 3} if drive.period is not None else {"duration": 7.0}
    text = reproduction(SPECS[name], **length)
    seen = run_python(text["python"], tmp_path)
    start = None
    if initial:
        start = [initial.get("stretch_1", 1.0), 0.0, 1.0, 0.0]
    motion = rm.simulate(system, drive, initial=start, **length)
    (tmp_path / "study.toml").write_text(text["study"], encoding="utf-8")
    study = read_study(tmp_path / "study.toml").study
    assert study.drive is not None
    stored = rm.simulate(study.system, study.drive, over=study.over, **study.options)
    for variable in ("energy", "load"):
        np.testing.assert_allclose(seen["motion"][variable], motion[variable], rtol=1e-12)
        np.testing.assert_allclose(np.ravel(stored[variable]), motion[variable], rtol=1e-12)


@pytest.mark.parametrize("case", fast_and_slow(list(CASES), slow=TAKE_A_SECOND))
def test_lines_make_equal_values(case: str, tmp_path: Path) -> None:
    """Law: system and drive of every kind are written so that they are read as they were."""
    system, drive = CASES[case]
    text = reproduction(write_spec(system, drive, {}))
    first = next(line for line in text["python"].splitlines() if line.startswith("motion = "))
    seen = run_python(text["python"], tmp_path, until=first)
    assert seen["system"] == system
    made = rm.Loads(seen["drive"]) if isinstance(seen["drive"], dict) else seen["drive"]
    assert made == drive
    (tmp_path / "study.toml").write_text(text["study"], encoding="utf-8")
    study = read_study(tmp_path / "study.toml").study
    assert (study.system, study.drive) == (system, drive)


@given(st.dictionaries(st.text(max_size=9), st.text(max_size=30), max_size=4))
def test_any_text_is_written_as_toml(texts: dict[str, str]) -> None:
    """Law: keys and texts of any characters come back."""
    import tomllib

    table = {"table": {**texts, "list": [1.5, True, "x"], "inner": {"a": {"b": 2}}}}
    assert tomllib.loads(toml_text(table)) == table

"""Stores: every verb that takes `over` fills one that is read back as what the verb returns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.sweep import chunks
from remanent.studies.sweep.encoding import WORDS
from remanent.studies.sweep.study import Study, study_from_plain, verbs_of_studies
from remanent.studies.sweep.verify import Integrity, verify_store
from tests.contracts.sound_calls import SOUND
from tests.repetitions import fast_and_slow

#: Text that is kept as text, as its words are not the same for every system.
_FREE_TEXT = {"reason", "end_reason", "end_bound", "state", "end"}
#: Verbs of which a store takes long.
TAKE_SECONDS = {"basins", "locate_bifurcation", "resonances", "response_diagram", "symmetry_check"}


def _study(verb: str) -> Study:
    """A sound call over a grid with a point that is invalid, and one that is empty of results."""
    arguments = {k: v for k, v in SOUND[verb]().items() if k not in ("over", "progress")}
    system = arguments.pop(next(iter(arguments)))
    drive = arguments.pop("drive", None)
    over = {"temperature": np.array([280.0, 350.0]), "c": np.array([-1.0, 0.5, 1.0])}
    return Study(verb, system, drive, over, arguments)


@pytest.mark.parametrize("verb", fast_and_slow(list(verbs_of_studies()), slow=TAKE_SECONDS))
@pytest.mark.filterwarnings("ignore::remanent.InputWarning")
def test_a_store_is_what_the_verb_returns(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bit for bit, with every variable's attributes, in chunks of two points."""
    monkeypatch.setattr(chunks, "_POINTS_PER_CHUNK", 2)
    monkeypatch.setattr(chunks, "_POINTS_PER_CHUNK_OF_SEARCHES", 2)
    study = _study(verb)
    expected = study.result_of(study.grid.whole)
    path = tmp_path / "study.zarr"
    options = dict(study.options)
    ds = rm.sweep(study.system, study.drive, study.over, verb, store=path, **options)
    xr.testing.assert_equal(ds, expected)
    for name, variable in expected.variables.items():
        xr.testing.assert_identical(ds.variables[name], variable)
        if variable.dtype.kind == "U":
            assert str(name) in WORDS or name in _FREE_TEXT
    assert set(expected.attrs) <= set(ds.attrs)
    assert verify_store(path).integrity is Integrity.WHOLE
    again = study_from_plain(study.plain)
    assert again.text == study.text

"""Stores: whatever the grid, its chunks and its shares, they hold what the verb returns."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import remanent as rm
from remanent.studies.sweep import chunks
from remanent.studies.sweep.run import run_here, writable_store
from remanent.studies.sweep.study import Study, study_from_plain
from remanent.studies.sweep.verify import Integrity, verify_store

#: Values that a field may take, in an order that a dimension cannot have by itself.
_VALUES = {
    "omega": [1.3, 0.9, 1.1, 1.5, 1.05], "b": [0.5, 0.2, 0.8, 0.3, 0.7],
    "temperature": [350.0, 280.0, 300.0, 410.0, 320.0], "prestress": [0.2, 0.0, 0.4, -0.1, 0.3],
    "dissipation.0.eta": [0.1, 0.02, 0.3, 0.05, 0.2],
}  # fmt: skip
#: Verbs with one number a point, with one along a dimension of their own, and with lists.
_VERBS: dict[str, dict[str, Any]] = {
    "cycle_losses": {"periods": 1},
    "simulate": {"times": [0.0, 0.5, 1.0]},
    "crossings": {"variable": "thickness_stretch", "value": 1.05, "duration": 12.0},
    "periodic_orbits": {"state_box": {"stretch": [0.7, 2.0]}, "tolerance": 1e-5},
}


@st.composite
def grids(draw: st.DrawFn) -> dict[str, Any]:
    """Fields of their own, fields that go together, in any order, with labels or without."""
    names = draw(st.permutations(list(_VALUES)))[: draw(st.integers(1, 4))]
    together = names[: draw(st.integers(0, len(names)))] if len(names) > 1 else []
    length = draw(st.integers(1, 5))
    labels = {"case": draw(st.permutations("vwxyz"))[:length]} if draw(st.booleans()) else {}
    over: dict[str, Any] = {}
    for name in draw(st.permutations(names)):
        values = _VALUES[name]
        if name in together:
            over[name] = xr.DataArray(values[:length], dims="case", coords=labels)
        else:
            over[name] = np.sort(values[: draw(st.integers(1, 3))])
    return over


@pytest.mark.parametrize(
    ("verb", "count"),
    [("cycle_losses", 6), pytest.param("periodic_orbits", 6, marks=pytest.mark.slow),
     *(pytest.param(verb, 60, marks=pytest.mark.slow) for verb in _VERBS)],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::remanent.InputWarning")
def test_a_store_of_any_grid_is_what_the_verb_returns(verb: str, count: int) -> None:
    """In any chunks, in shares that are filled in any order."""

    @settings(max_examples=count)
    @given(grids(), st.integers(1, 12), st.permutations([1, 2, 3]))
    def check(over: dict[str, Any], points: int, shares: list[int]) -> None:
        study = Study(
            verb, rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25), over,
            _VERBS[verb],
        )  # fmt: skip
        expected = study.result_of(study.grid.whole)
        again = study_from_plain(study.plain)
        assert (again.text, again.grid.dims) == (study.text, study.grid.dims)
        with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
            patch.setattr(chunks, "_POINTS_PER_CHUNK", points)
            patch.setattr(chunks, "_POINTS_PER_CHUNK_OF_SEARCHES", points)
            path = Path(folder) / "it.zarr"
            for share in shares:
                with writable_store(path, study, (share, 3)) as store:
                    run_here(store, (share, 3))
            assert verify_store(path).integrity is Integrity.WHOLE
            loaded = rm.load(path)
            xr.testing.assert_equal(loaded, expected)
            assert list(loaded.coords) == list(expected.coords)
            assert [n for n in loaded if n != "reason"] == [n for n in expected if n != "reason"]

    check()

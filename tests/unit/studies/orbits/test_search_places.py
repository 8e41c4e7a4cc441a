"""Where orbits are looked for: between which stretches, and from which guesses."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent._typing import FloatArray
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._checks import require_state_box
from remanent.studies.orbits._grid_search import _box_guesses
from remanent.studies.orbits._orbit_search import OrbitSearch
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._search_region import (
    _STRETCHES,
    _USUAL_STRETCHES,
    _ends_of_rise,
)

LAST = len(_STRETCHES) - 1


@pytest.mark.parametrize(
    ("potential", "low", "high"),
    [
        (1.0 / _STRETCHES, _STRETCHES[0], _USUAL_STRETCHES[1]),
        (_STRETCHES, _USUAL_STRETCHES[0], _STRETCHES[-1]),
        (np.log(_STRETCHES) ** 2, _STRETCHES[0], _STRETCHES[-1]),
        (np.where(_STRETCHES < 9.0, np.log(_STRETCHES) ** 2, np.nan), _STRETCHES[0], 9.0),
        (np.where(_STRETCHES > 0.1, np.log(_STRETCHES) ** 2, np.inf), 0.1, _STRETCHES[-1]),
    ],
    ids=["falls", "rises", "rises outwards", "ends above", "ends below"],
)
def test_the_ends_up_to_which_a_potential_rises_outwards(
    potential: FloatArray, low: float, high: float
) -> None:
    """Known potentials: to the ends of the table, of what is finite, or of usual stretches."""
    first, last = _ends_of_rise(potential)
    assert 0 <= first < last <= LAST
    ratio = float(_STRETCHES[1] / _STRETCHES[0])
    assert max(_STRETCHES[first] / low, low / _STRETCHES[first]) < ratio
    assert max(_STRETCHES[last] / high, high / _STRETCHES[last]) < ratio


@pytest.mark.parametrize("is_dense", [True, False])
def test_guesses_favour_neither_of_two_stretches(is_dense: bool) -> None:
    """With the stretches exchanged, and their rates, they are the same guesses."""
    ens = lay_out_ensemble(rm.Actuator(prestress=(0.1, 0.1)), rm.SineSquared(0.4, 1.25))
    box = require_state_box("state_box", None, ens)
    search = OrbitSearch(StroboscopicMap(ens, (), 1e-10), box, 1, 1e-9, False, is_dense)
    guesses = _box_guesses(search)
    names = ens.vector_field.state_names
    assert names == ("stretch_1", "stretch_1_rate", "stretch_2", "stretch_2_rate")
    exchanged = guesses[:, [2, 3, 0, 1]]
    assert {*map(tuple, exchanged.tolist())} == {*map(tuple, guesses.tolist())}
    np.testing.assert_allclose(guesses.min(axis=0), box[:, 0])
    np.testing.assert_allclose(guesses.max(axis=0), box[:, 1])

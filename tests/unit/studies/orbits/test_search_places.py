"""Where orbits are looked for: between which stretches, and from which guesses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import remanent as rm
from remanent._typing import FloatArray
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._checks import require_state_box
from remanent.studies.orbits._grid_search import _box_guesses
from remanent.studies.orbits._orbit_search import OrbitSearch, is_inside_box
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._planar_search import _first_grid
from remanent.studies.orbits._search_region import (
    _STRETCHES,
    _USUAL_STRETCHES,
    EnergyLevels,
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


@pytest.mark.parametrize("level", [0.1, 0.5, 8.0])
def test_points_on_a_level_have_its_energy(level: float) -> None:
    """(ln x)^2 + M(x) v^2/2: on the level, on both sides of rest and of zero rate, in its box."""
    inertia = 1.0 + 2.0 / _STRETCHES**2
    levels = EnergyLevels(np.log(_STRETCHES) ** 2, inertia)
    points, box = levels.points(level), levels.box(level)
    stretch, rate = points.T
    energy = np.log(stretch) ** 2 + 0.5 * (1.0 + 2.0 / stretch**2) * rate**2
    np.testing.assert_allclose(energy, level, rtol=2e-2, atol=1e-4)
    assert {*zip(stretch > 1.0, rate > 0.0, strict=True)} == {
        (a, b) for a in (0, 1) for b in (0, 1)
    }
    assert ((points >= box[:, 0]) & (points <= box[:, 1])).all()
    reach = np.exp(level**0.5)
    np.testing.assert_allclose(box[0], [1.0 / reach, reach], rtol=2e-2)
    fine = np.linspace(1.0 / reach, reach, 100_001)
    fastest = np.sqrt(2.0 * (level - np.log(fine) ** 2).clip(0.0) / (1.0 + 2.0 / fine**2)).max()
    np.testing.assert_allclose(box[1], [-fastest, fastest], rtol=2e-2)


def test_what_is_inside_a_box_but_for_rounding() -> None:
    """A billionth of each width beyond a bound counts as inside, and no more."""
    box = np.array([[1.0, 3.0], [-2.0, 5.0], [100.0, 101.0]])
    middle, width = box.mean(axis=1), np.ptp(box, axis=1)
    for k in range(3):
        for bound, outwards in ((0, -1.0), (1, 1.0)):
            states = np.tile(middle, (3, 1))
            states[:, k] = box[k, bound] + outwards * width[k] * np.array([-0.1, 0.5e-9, 2e-9])
            assert is_inside_box(states, box).tolist() == [True, True, False]


@pytest.mark.parametrize("known", [(0, LAST), (0, 1900), (200, LAST), (300, 301), (700, 700)])
def test_possible_stretches_are_those_with_a_finite_energy(known: tuple[int, int]) -> None:
    """Exact: from the first to the last stretch whose energy is known; without any, one alone."""
    place, (low, high) = np.arange(LAST + 1), known
    inside = (place >= low) & (place <= high)
    levels = EnergyLevels(np.where(inside, 1.0, np.nan), np.ones(LAST + 1))
    assert levels.possible_stretches == (_STRETCHES[low], _STRETCHES[high])
    nowhere = EnergyLevels(np.full(LAST + 1, np.nan), np.ones(LAST + 1))
    lowest, highest = nowhere.possible_stretches
    assert lowest == highest


@pytest.mark.parametrize("fastest", np.linspace(0.2, 9.0, 12))
@pytest.mark.parametrize("refinement", [1, 2, 3])
def test_a_mirrored_grid_begins_at_zero_rate(fastest: float, refinement: int) -> None:
    """Half of the box is searched where motion can be reversed, from rates of exactly zero on."""
    ens = lay_out_ensemble(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    box = np.array([[0.7, 1.9], [-fastest, fastest]])
    search = OrbitSearch(StroboscopicMap(ens, (), 1e-10), box, 1, 1e-9, True, True)
    grid = _first_grid(search, box, refinement)
    stretches, rates = grid.edges
    assert grid.is_mirrored
    assert (rates[0], rates[-1]) == pytest.approx((0.0, fastest), abs=1e-12)
    np.testing.assert_allclose(stretches[[0, -1]], box[0])
    _, both = _first_grid(replace(search, is_reversible=False), box, refinement).edges
    np.testing.assert_allclose(both[-rates.size :], rates, atol=1e-12)
    np.testing.assert_allclose(both, -both[::-1], atol=1e-12)

"""Motion near curves of points that almost come back: its energy, and how often it turns back."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent.models.drives.base import Drive
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._checks import require_state_box
from remanent.studies.orbits._flat_curves import _highest_energy, _oscillation_counts
from remanent.studies.orbits._orbit_search import OrbitSearch
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._search_region import EnergyAtSection

BODY, ROW = rm.Actuator(), np.empty(0)


def search_of(drive: Drive, orbit_period: int) -> OrbitSearch:
    """A search for undamped orbits of a period."""
    ens = lay_out_ensemble(BODY, drive)
    box = require_state_box("state_box", None, ens)
    return OrbitSearch(StroboscopicMap(ens, (), 1e-10), box, orbit_period, 1e-9, True)


@pytest.mark.parametrize("orbit_period", [1, 2, 3])
def test_the_highest_energy_is_that_of_the_times_at_which_an_orbit_may_be_at_rest(
    orbit_period: int,
) -> None:
    """Law: at every whole period of one orbit, and at every half one if its period is even."""
    drive = rm.SineSquared(0.4, 1.25)
    search = search_of(drive, orbit_period)
    energy = EnergyAtSection(search.map, ROW)
    step = search.drive_period(ROW) * (1.0 if orbit_period % 2 else 0.5)
    count = orbit_period if orbit_period % 2 else 2 * orbit_period
    for start in [(0.6, 0.0), (1.0, 0.5), (1.2, -0.4), (1.5, 0.2), (1.0, -0.6)]:
        motion = rm.simulate(BODY, drive, times=step * np.arange(count), initial=start)
        states = np.column_stack([motion.stretch.values, motion.stretch_rate.values])
        found = _highest_energy(search, energy, np.array([start]), ROW)
        assert found == pytest.approx(energy(states).max(), abs=1e-2)


@pytest.mark.parametrize(("orbit_period", "turns"), [(1, 2), (2, 1), (3, 5)])
def test_small_free_motion_turns_back_once_in_each_of_its_own_periods(
    orbit_period: int, turns: int
) -> None:
    """Known frequency: M s^2 + 18 = 0 at rest, where M = 3, so that it is sqrt(6)."""
    free = rm.SineSquared(0.0, 1.0)
    length = turns * 2.0 * np.pi / 6.0**0.5
    assert free.period is not None
    search = search_of(free.replace(omega=free.period * orbit_period / length), orbit_period)
    starts = np.array([[1.05, 0.0], [1.0, 0.1], [1.0, -0.1], [0.97, 0.05]])
    assert _oscillation_counts(search, ROW, starts).tolist() == [turns] * len(starts)

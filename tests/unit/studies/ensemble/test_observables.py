"""At which phase of which piece an instant lies."""

from __future__ import annotations

import numpy as np

import remanent as rm
from remanent._load_schedule import LoadSchedule
from remanent.studies.ensemble.observables import phase_and_piece_index


def still(phase: np.ndarray) -> np.ndarray:
    return np.empty((0, *np.shape(phase)))


def test_boundaries_belong_to_the_piece_that_begins() -> None:
    """And the end of the run to the last piece."""
    load_schedule = LoadSchedule(np.array([[2.0], [3.0]]), False, {}, still)
    phase, piece = phase_and_piece_index(load_schedule, np.array([[0.0, 1.0, 2.0, 3.5, 5.0]]))
    assert piece.tolist() == [[0, 0, 1, 1, 1]]
    np.testing.assert_allclose(phase, [[0.0, 0.5, 0.0, 0.5, 1.0]], rtol=0, atol=1e-15)


def test_whole_periods_have_phase_zero() -> None:
    """However many of them have passed."""
    period = np.pi / 1.25
    load_schedule = LoadSchedule(np.array([[period]]), True, {}, still)
    phase, _ = phase_and_piece_index(load_schedule, np.arange(20_000.0)[None] * period)
    assert (phase == 0.0).all()


def test_energy_jumps_with_the_load() -> None:
    """At a step the energy is that of the load that begins: -m lambda**-2 jumps."""
    times = [0.0, 1.0 - 1e-9, 1.0]
    ds = rm.simulate(rm.Actuator(), rm.Steps([0.0, 1.0], [0.0, 0.5]), times=[*times, 2.0])
    assert abs(float(ds.energy[1] - ds.energy[0])) < 1e-8
    jump = float(ds.energy[2] - ds.energy[1])
    assert abs(jump + 0.5 * float(ds.stretch[2]) ** -2) < 1e-8

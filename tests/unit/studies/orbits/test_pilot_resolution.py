"""Resolutions of the period map follow from the place alone."""

from __future__ import annotations

import numpy as np

from remanent.studies.orbits._pilot_resolution import FIRST_RESOLUTION, PilotResolution


def test_resolutions_are_those_of_cells() -> None:
    """Points of a cell agree, whatever was asked before; the cache only saves pilot runs."""
    runs: list[int] = []

    class Image:
        def __init__(self, states: np.ndarray, resolution: np.ndarray) -> None:
            self.resolution = resolution
            self.largest_period_error = (
                1e-6 * np.abs(states[:, 0]) * (FIRST_RESOLUTION / resolution) ** 8.0
            )

    def run(states: np.ndarray, parameters: np.ndarray, resolution: np.ndarray) -> Image:
        runs.append(len(parameters))
        return Image(states, resolution)

    states, parameters = np.array([[1.0], [1.001], [50.0], [np.nan]]), np.full((4, 1), 0.3)
    pilot = PilotResolution(1e-9, 8, 1024, 4)
    first = pilot(run, states, parameters, iterate=1, half=False)  # type: ignore[arg-type]
    assert first[0] == first[1] < first[2]
    assert first[3] == FIRST_RESOLUTION
    again = pilot(run, states, parameters, iterate=1, half=False)  # type: ignore[arg-type]
    np.testing.assert_array_equal(first, again)
    assert len(runs) == 1
    for k in range(4):
        fresh = PilotResolution(1e-9, 8, 1024, 4)
        alone = fresh(run, states[k : k + 1], parameters[k : k + 1], iterate=1, half=False)  # type: ignore[arg-type]
        assert alone[0] == first[k]

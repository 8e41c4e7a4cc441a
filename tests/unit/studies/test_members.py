"""Members of an ensemble one by one: padding, and boxes of states."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.orbits._checks import require_state_box
from remanent.studies.orbits._members import for_each_member, stack_padded, stack_tables
from remanent.studies.orbits._pilot_resolution import FIRST_RESOLUTION, PilotResolution

DRIVE = rm.SineSquared(0.4, 1.25)
WARM = rm.Actuator(heat=rm.Heat(1e-3, exchange=0.1), dissipation=rm.Rayleigh(0.1))


def test_padding_keeps_kinds_and_leaves_no_number() -> None:
    """NaN after the last number, -1 after the last index, nothing after the last word."""
    numbers = stack_padded([np.ones((2, 2)), np.ones((1, 2))], np.empty((0, 2)))
    assert np.isnan(numbers).sum() == 2
    assert np.isnan(numbers[1, 1]).all()
    assert stack_padded([np.array([3, 4]), np.array([5])], np.empty(0, int)).tolist() == [
        [3, 4],
        [5, -1],
    ]
    assert stack_padded([np.array(["a"]), np.empty(0, "<U3")], np.empty(0, "<U3")).tolist() == [
        ["a"],
        [""],
    ]
    assert stack_padded([], np.empty((0, 2), complex)).shape == (0, 0, 2)


def test_a_missing_table_is_all_padding() -> None:
    stacked = stack_tables([None, {"x": np.array([1.0])}], {"x": np.empty(0)})
    np.testing.assert_array_equal(stacked["x"], [[np.nan], [1.0]])


def test_a_single_member_says_why_it_failed_and_many_do_not() -> None:
    """An InputError is for who asked for one thing; among others it is a missing result."""

    def fail(_member: object) -> None:
        raise rm.InputError("x", must="be", got=0, why="It is not.", fix="Pass 1.")

    with pytest.raises(rm.InputError):
        for_each_member(lay_out(rm.Actuator(), DRIVE), fail)
    assert for_each_member(lay_out(rm.Actuator(), DRIVE, {"b": [0.1, 0.2]}), fail) == [None, None]


def test_a_box_without_a_temperature_is_refused_by_name() -> None:
    """NaN around the body leaves no default; a given pair needs none."""
    ens = lay_out(WARM, DRIVE, {"temperature": [np.nan, 300.0]})
    assert require_state_box("state_box", None, ens)[-1].tolist() == [295.0, 305.0]
    with pytest.raises(rm.InputError, match=r"^`box` must name state variables, stretch"):
        require_state_box("box", {"strech": (0.3, 4.0)}, ens)
    with pytest.raises(rm.InputError, match=r"^`box` must give stretch a lower"):
        require_state_box("box", {"stretch": (4.0, 0.3)}, ens)
    ds = rm.periodic_orbits(WARM, DRIVE, over={"temperature": [np.nan, 300.0]})
    assert ds.status.values.tolist() == [rm.Status.INVALID, rm.Status.OK]
    assert ds.orbits.values.tolist()[0] == 0
    assert ds.orbits.values.tolist()[1] > 0


def test_resolutions_are_those_of_cells() -> None:
    """Points of a cell agree, whatever was asked before; the cache only saves pilot runs."""
    runs: list[int] = []

    class Image:
        def __init__(self, states: np.ndarray, resolution: np.ndarray) -> None:
            self.resolution = resolution
            self.error = 1e-6 * np.abs(states[:, 0]) * (FIRST_RESOLUTION / resolution) ** 8.0

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

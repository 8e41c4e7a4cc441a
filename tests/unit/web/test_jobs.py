"""Jobs: what they give, what they refuse, and what they are thought to cost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.studies.sweep.faults import FaultsError
from remanent.web.costs import run_seconds
from remanent.web.errors import RefusalError
from remanent.web.jobs import JOBS, job_result
from remanent.web.limits import JOB_LIMITS
from remanent.web.subjects import Subject, initial_state, read_subject
from tests.unit.web.server import SPEC

#: Options with which each job is quick.
QUICK: dict[str, dict[str, Any]] = {
    "frequency_response": {"range": [1.0, 1.5], "count": 11},
    "response_diagram": {"range": [1.2, 1.25]},
    "classify": {"periods": 100},
    "basins": {"grid": {"stretch_rate": [-0.1, 0.1], "stretch": [0.9, 1.1]}, "count": 2,
               "periods": 100},
    "regime_chart": {"grid": {"omega": [1.7, 2.0], "b": [0.2, 0.3]}, "count": 2, "periods": 100},
    "equilibria": {"load": 0.16},
}  # fmt: skip


@pytest.fixture(scope="module")
def subject() -> Subject:
    return read_subject(SPEC)


def own_system(**drive: Any) -> dict[str, Any]:
    """A double well, as a page sends it."""
    return {
        "system": {
            "kind": "LagrangianSystem", "coordinates": ["x"], "kinetic": "x_rate**2/2",
            "potential": "-x**2/2 + x**4/4 - load*x", "dissipation": "delta*x_rate**2/2",
            "parameters": {"delta": 0.15}, "observable": "x",
        },
        "drive": {"kind": "Sine", "m": 0.3, "omega": 1.2, **drive},
    }  # fmt: skip


def test_every_job_has_a_limit() -> None:
    """Law: the server knows the jobs that its processes know."""
    assert JOBS.keys() == JOB_LIMITS.keys() == QUICK.keys()


@pytest.mark.parametrize("name", QUICK)
def test_every_job_gives_what_is_drawn(subject: Subject, name: str) -> None:
    """Law: a result names its kind, the options that made it, and why something is missing."""
    shares: list[float] = []
    result = job_result(name, subject, QUICK[name], shares.append)
    assert result["kind"] == name
    assert result["series"]
    assert QUICK[name].items() <= result["settings"].items()
    assert isinstance(result["reason"], str)
    assert all(0.0 <= share <= 1.0 for share in shares)
    assert shares == sorted(shares)


@pytest.mark.parametrize("name", [name for name in QUICK if name != "equilibria"])
def test_own_systems_are_computed(name: str) -> None:
    """Law: systems of one's own are looked at as actuators are."""
    own = {
        "basins": {"grid": {"x": [-1.0, 1.0], "x_rate": [-0.1, 0.1]}, "count": 2, "periods": 100},
        "regime_chart": {"grid": {"m": [0.1, 0.2], "delta": [0.1, 0.2]}, "count": 2,
                         "periods": 100},
        "response_diagram": {"range": [1.2, 1.25], "state_box": {"x": [-2, 2], "x_rate": [-2, 2]}},
    }  # fmt: skip
    result = job_result(name, read_subject(own_system()), own.get(name, QUICK[name]))
    assert result["series"]


def test_a_job_begins_where_the_motion_does(subject: Subject) -> None:
    """Law: the state at the start is that of the request, the rest of it at rest."""
    moved = read_subject({**SPEC, "initial": {"stretch_rate": 0.4}})
    assert initial_state(subject) is None
    start = initial_state(moved)
    assert start is not None
    assert start.tolist() == [1.0, 0.4]
    result = job_result("frequency_response", moved, QUICK["frequency_response"])
    expected = rm.frequency_response(
        moved.system, moved.drive, np.linspace(1.0, 1.5, 11), initial=[1.0, 0.4]
    )
    assert result["series"][0]["amplitude"]["values"] == expected.amplitude.values.tolist()


def test_sweeps_find_both_responses() -> None:
    """Law: rising and falling frequencies differ between the two folds alone, and both follow
    stable branches."""
    damping = {"dissipation": [{"kind": "Rayleigh", "eta": 0.05}]}
    lightly = read_subject({**SPEC, "actuator": {"temperature": 350.0, **damping}})
    options = {"range": [1.1, 1.4], "count": 11, "sweeps": True, "sweep_count": 31}
    result = job_result("frequency_response", lightly, options)
    assert [series["name"] for series in result["series"]] == ["rest", "up", "down"]
    omega, up, down = (
        np.array(result["series"][k][name]["values"], dtype=np.float64)
        for k, name in ((1, "omega"), (1, "amplitude"), (2, "amplitude"))
    )
    diagram = rm.response_diagram(lightly.system, lightly.drive, (1.05, 1.45))
    low, high = sorted(diagram.special_omega.values)
    assert np.array_equal(np.abs(up - down) > 0.05, (omega > low) & (omega < high))
    stable = diagram.stability.values == "stable"
    branch, amplitude = diagram.omega.values[stable], diagram.amplitude.values[stable]
    for swept in (up, down):
        for stop, found in zip(omega, swept, strict=True):
            near = np.abs(branch - stop) < 0.006
            assert np.abs(amplitude[near] - found).min() < 0.02


def test_strips_of_a_chart_are_the_chart(subject: Subject, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: a chart does not depend on how many of its points are computed together."""
    options = {**QUICK["regime_chart"], "count": 3}
    whole = job_result("regime_chart", subject, options)
    monkeypatch.setattr("remanent.web.jobs._POINTS_PER_STRIP", 1)
    shares: list[float] = []
    assert job_result("regime_chart", subject, options, shares.append) == whole
    assert len(shares) == 3


@pytest.mark.parametrize(
    ("name", "options", "place"),
    [
        ("frequency_response", {"range": [2.0, 1.0]}, "range"),
        ("frequency_response", {"range": [1.0]}, "range"),
        ("frequency_response", {"range": [1.0, float("nan")]}, "range"),
        ("frequency_response", {"count": 1}, "count"),
        ("frequency_response", {"count": 10**9}, "count"),
        ("frequency_response", {"cuont": 9}, "cuont"),
        ("classify", {"periods": 99}, "periods"),
        ("classify", {"periods": "many"}, "periods"),
        ("basins", {}, "grid"),
        ("basins", {"grid": {"stretch": [0.9, 1.1]}}, "grid"),
        ("regime_chart", {"grid": {"b": [0, 1], "omega": [1, 2]}, "count": 129}, "count"),
        ("equilibria", {"load": []}, "load"),
    ],
)
def test_options_are_checked(
    subject: Subject, name: str, options: dict[str, Any], place: str
) -> None:
    """Law: an option that is not sound is refused by its name before anything is computed."""
    with pytest.raises(FaultsError) as refused:
        job_result(name, subject, options)
    assert refused.value.faults[0].path[:2] == ("options", place)


@pytest.mark.parametrize("options", [{}, {"range": [0.5, 2.0]}])
@pytest.mark.parametrize("verb", ["frequency_response", "response_diagram"])
def test_verbs_have_the_last_word(verb: str, options: dict[str, Any]) -> None:
    """Law: a load that a verb refuses is refused in its way, whoever chooses the frequencies."""
    constant = read_subject({**SPEC, "drive": {"kind": "Constant", "m": 0.1}})
    with pytest.raises(rm.InputError, match="must have a field `omega`") as refused:
        job_result(verb, constant, options)
    assert refused.value.name == "drive"


@pytest.mark.parametrize("omega", [1e-300, 1e-9, 1.0, 1e9, 1e300])
def test_costs_are_told_for_every_period(omega: float) -> None:
    """Law: an estimate is positive, or infinite, and grows with the number of runs."""
    drive = rm.SineSquared(0.4, omega)
    one, many = (run_seconds(drive, count, None) for count in (1.0, 1000.0))
    assert 0.0 < one <= many
    assert many == pytest.approx(1000.0 * one)


def test_what_costs_too_much_is_not_begun(subject: Subject) -> None:
    """Law: the refusal has the estimate and a remedy."""
    with pytest.raises(RefusalError) as refused:
        job_result("frequency_response", subject, {"duration": 1e9})
    assert refused.value.status == 422
    assert "about" in refused.value.message
    assert JOB_LIMITS["frequency_response"].remedy in refused.value.message

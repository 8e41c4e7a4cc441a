"""Several loads, each by a drive of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.models.drives.base import Drive
from remanent.models.plain import from_plain_data, to_plain_data
from tests.contracts.test_drives import through_load_schedule

#: A mass on a spring that two loads pull, one of them with the other's stiffness.
SYSTEM = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="x**2/2 - push*x + pull*x**2/4",
    loads=("push", "pull"),
)
#: Drives that go together.
TOGETHER: dict[str, dict[str, Drive]] = {
    "one constant": {"push": rm.Sine(0.3, 2.0, mean=0.1, phase=0.4), "pull": rm.Constant(0.2)},
    "two periods": {"push": rm.Sine(0.3, 2.0), "pull": rm.SineSquared(0.4, 3.0, phase=0.2)},
    "steps": {"push": rm.Steps([0.0, 2.0], [0.1, 0.3]), "pull": rm.Constant(-0.1)},
    "constants": {"push": rm.Constant(0.3), "pull": rm.Constant(-0.1)},
    "samples": {"push": rm.Constant(0.3), "pull": rm.Sampled([0.0, 5.0, 12.0], [0.0, 0.3, 0.1])},
}
APART = {
    "irrational": {"push": rm.Sine(0.3, 2.0), "pull": rm.Sine(0.1, 2.0**0.5)},
    "steps and sine": {"push": rm.Steps([0.0, 2.0], [0.1, 0.3]), "pull": rm.Sine(0.1, 1.0)},
    "no drive": {"push": 0.3, "pull": rm.Constant(0.1)},
}


@pytest.mark.parametrize("drives", TOGETHER.values(), ids=TOGETHER)
def test_each_load_follows_its_own_law(drives: dict[str, Drive]) -> None:
    """Loads along a motion are those of the drives at the same times, and SciPy agrees."""
    from scipy.integrate import solve_ivp

    run = rm.simulate(SYSTEM, rm.Loads(drives), duration=9.0, initial=(0.3, 0.0))
    for name, drive in drives.items():
        np.testing.assert_allclose(run[name].values, drive(run.time.values), atol=1e-12)

    def rates(t: float, y: Any) -> list[float]:
        push, pull = (float(drives[name](t)) for name in ("push", "pull"))
        return [y[1], -y[0] + push - pull * y[0] / 2.0]

    exact = solve_ivp(
        rates, (0.0, 9.0), (0.3, 0.0), method="DOP853", rtol=1e-11, atol=1e-11, max_step=0.05,
        t_eval=run.time.values,
    )  # fmt: skip
    np.testing.assert_allclose(run.x.values, exact.y[0], atol=2e-6)


@pytest.mark.parametrize("drives", TOGETHER.values(), ids=TOGETHER)
def test_to_a_system_with_one_load_they_are_the_first(drives: dict[str, Drive]) -> None:
    """In the equations of motion, at all phases of all pieces, as in time."""
    times, load = through_load_schedule(rm.Loads(drives), {}, np.array([9.0]))
    np.testing.assert_allclose(load, drives["push"](times), atol=1e-13)


def test_the_common_period_is_the_smallest() -> None:
    """Periods pi and pi/3 make pi; both loads repeat after it and after no part of it."""
    loads = rm.Loads({"push": rm.Sine(0.3, 2.0), "pull": rm.SineSquared(0.4, 3.0)})
    assert loads.period == pytest.approx(np.pi, rel=1e-15)
    times = np.linspace(0.0, 3.0, 50)
    np.testing.assert_allclose(loads(times + np.pi), loads(times), atol=1e-13)


@pytest.mark.parametrize("drives", APART.values(), ids=APART)
def test_loads_without_a_common_course_are_refused(drives: Any) -> None:
    """What has neither a common period nor common pieces raises `InputError`."""
    with pytest.raises(rm.InputError, match="drive"):
        rm.Loads(drives)


def test_a_period_that_overflows_is_refused() -> None:
    """An angular frequency can be so small that floating point has no period for it."""
    with pytest.raises(rm.InputError, match="must have finite periods"):
        rm.Loads({"push": rm.Sine(0.1, 5e-324), "pull": rm.Constant(0.5)})


def test_fields_are_varied_under_the_name_of_their_load() -> None:
    """A point of `over` equals the call with that value alone."""
    drives = TOGETHER["two periods"]
    over: dict[str, Any] = {"push.m": [0.1, 0.3], "pull.b": [0.4]}
    loads = rm.Loads(drives)
    run = rm.simulate(SYSTEM, loads, duration=3.0, over=over)
    alone = rm.simulate(SYSTEM, loads.replace(**{"push.m": 0.1}), duration=3.0)
    np.testing.assert_array_equal(run.x[0, 0].values, alone.x.values)
    assert run["push.m"].attrs["long_name"] == "load of the push"
    assert from_plain_data(to_plain_data(loads)) == loads
    assert rm.read_drive(run) == loads
    invalid = rm.simulate(
        SYSTEM, loads, duration=3.0, over={"push.omega": [2.0, 6.0]}
    ).status.values
    assert invalid.tolist() == [int(rm.Status.OK), int(rm.Status.INVALID)]


def test_an_actuator_takes_no_other_loads() -> None:
    """A system says which loads it has, where a mapping of drives gives others."""
    drives: Any = {"push": rm.Constant(0.1)}
    with pytest.raises(rm.InputError, match="loads of the system: load"):
        rm.simulate(rm.Actuator(), drives, duration=1.0)

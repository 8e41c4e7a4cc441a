"""Work of the drive minus dissipation is the change of energy."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm

DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.1), c=0.1, prestress=0.4)
COLD = rm.Actuator(magnet=rm.Magnet(-0.001), temperature=250.0)
CASES = {
    "damped": (DAMPED, rm.SineSquared(0.9, 1.25)),
    "two harmonics": (DAMPED, rm.Sines([0.3, 0.1], [1, 2], 1.1)),
    "two frequencies": (rm.Actuator(), rm.Sines([0.3, 0.1], [1, 2**0.5], 1.1)),
    "cold magnet": (COLD, rm.Steps([0, 4.0], [0.2, 0.5])),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_energy_balances(case: tuple[rm.Actuator, rm.SineSquared]) -> None:
    """Stored energy changes by work minus dissipation, within 1e-8 and the error.

    Law: Energy and work.
    """
    ds = rm.energy_balance(*case, duration=200.0, tolerance=1e-10)
    assert float(ds.drive_work[-1]) > 1e-3
    assert float(np.abs(ds.balance).max()) < 1e-8
    assert float(np.abs(ds.balance).max()) < 20 * float(ds.error)


def test_a_free_block_only_loses() -> None:
    """Without a load no work is done, and all stored energy is dissipated in the end."""
    damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    ds = rm.energy_balance(damped, rm.Constant(0.0), duration=50.0, initial=(1.3, 0.0))
    assert not ds.drive_work.any()
    assert (ds.dissipated_energy.diff("time") > -1e-12).all()
    assert float(ds.dissipated_energy[-1]) == pytest.approx(float(ds.stored_energy[0]), rel=0.01)


def test_energy_is_stored_energy_and_that_in_the_field() -> None:
    """The observable `energy` is the stored energy less m lambda_3, that of the magnet in the
    field."""
    actuator, drive = rm.Actuator(temperature=350.0), rm.Sine(0.2, 1.1, mean=0.1)
    times = np.linspace(0.0, 30.0, 50)
    whole = rm.simulate(actuator, drive, times=times)
    ds = rm.energy_balance(actuator, drive, times=times)
    field = -drive(times) * whole.thickness_stretch
    np.testing.assert_allclose(ds.stored_energy + field, whole.energy, atol=1e-8)


def test_the_mean_is_that_of_many_samples() -> None:
    """The mean stretch is the integral of the history over its length."""
    actuator, drive = rm.Actuator(), rm.Sines([0.3], [1], 1.3)
    ds = rm.energy_balance(actuator, drive, periods=10)
    fine = rm.simulate(actuator, drive, times=np.linspace(0.0, float(ds.time[-1]), 20_001))
    mean = np.trapezoid(fine.thickness_stretch, fine.time) / float(ds.time[-1])
    assert float(ds.mean_thickness_stretch[-1]) == pytest.approx(mean, abs=1e-6)
    assert float(ds.mean_thickness_stretch[0]) == 1.0


def test_the_mean_is_that_of_the_time_so_far() -> None:
    """x = cos t has the mean sin t/t up to any time, and at once its value."""
    free = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 - load*x", rest={"x": 1.0}
    )
    times = np.array([0.0, 0.25, 0.5, 0.9, 2.0, 5.0])
    ds = rm.energy_balance(free, rm.Constant(0.0), times=times)
    off = np.abs(ds.mean_x.values - np.sinc(times / np.pi))
    assert (off <= ds.mean_x_error.values + 1e-15).all()
    assert off.max() < 1e-9

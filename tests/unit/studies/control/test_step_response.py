"""What a step leaves: its metrics, its energy, and how they scale."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import remanent as rm


def test_physical_sizes_scale_what_they_should() -> None:
    """A larger modulus is a warmer block; remanence is load; density is slowness."""
    actuator = rm.Actuator(prestress=0.3, dissipation=rm.Rayleigh(0.2))
    command = rm.Steps([0.0, 1.3], [0.2, 0.4])

    def left(body: rm.Actuator, drive: rm.Steps, **over: float) -> list[float]:
        names = {k: [v] for k, v in over.items()}
        ds = rm.step_response(body, drive, duration=20.0, over=names)
        names = ("residual_amplitude", "rise_time", "settling_time", "farthest")  # type: ignore[assignment]
        return [ds[name].item() for name in names]

    hot = left(actuator, command, temperature=1.1 * 293.0)
    np.testing.assert_allclose(left(actuator, command, shear_modulus=1.1), hot, rtol=1e-7)
    strong = left(actuator, rm.Steps([0.0, 1.3], [0.22, 0.44]))
    np.testing.assert_allclose(left(actuator, command, remanence=1.1), strong, rtol=1e-7)
    slow = np.sqrt(1.1)
    heavy = rm.step_response(
        actuator.replace(dissipation=rm.Rayleigh(0.2 / slow)),
        rm.Steps([0.0, 1.3 / slow], [0.2, 0.4]),
        duration=20.0 / slow,
    )
    expected = [
        heavy.residual_amplitude, heavy.rise_time * slow, heavy.settling_time * slow,
        heavy.farthest,
    ]  # fmt: skip
    np.testing.assert_allclose(left(actuator, command, density=1.1), expected, rtol=1e-7)


def test_a_magnet_in_itself_changes_with_remanence_and_modulus() -> None:
    """B_r^2/(mu mu0), beside m ~ B_r/mu and times in the unit of the modulus."""
    remanence, modulus = 1.2, 1.1
    over = {"remanence": xr.DataArray([remanence], dims="case"),
            "shear_modulus": xr.DataArray([modulus], dims="case")}  # fmt: skip
    body = rm.Actuator(magnet=rm.Magnet(demagnetisation=0.2))
    ds = rm.step_response(body, rm.Constant(0.3), duration=6.0, over=over)
    changed = body.with_parameter("magnet.demagnetisation", 0.2 * remanence**2 / modulus)
    load = rm.Constant(0.3 * remanence / modulus)
    alone = rm.step_response(changed, load, duration=6.0 * np.sqrt(modulus))
    assert float(ds.farthest[0]) == pytest.approx(float(alone.farthest), abs=1e-8)


def test_metrics_of_a_small_step() -> None:
    """Overshoot exp(-pi zeta/sqrt(1 - zeta^2)); settling as a dense history has it."""
    actuator = rm.Actuator(dissipation=rm.Rayleigh(0.6))
    ds = rm.step_response(actuator, rm.Constant(1e-4), duration=20.0)
    zeta = 0.6 * 3.0 / (2.0 * 3.0) / np.sqrt(6.0)  # 3 l'' + 3 eta l' + 18 l = 0
    expected = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    assert float(ds.overshoot) == pytest.approx(expected, rel=1e-3)
    dense = rm.simulate(actuator, rm.Constant(1e-4), times=np.linspace(0.0, 20.0, 40_001))
    share = (dense.thickness_stretch - 1.0) / (ds.final - 1.0)
    outside = dense.time[np.flatnonzero(np.abs(share - 1.0) > 0.02)[-1]]
    assert float(ds.settling_time) == pytest.approx(float(outside), abs=1e-3)
    rise = [float(dense.time[np.flatnonzero(share > s)[0]]) for s in (0.1, 0.9)]
    assert float(ds.rise_time) == pytest.approx(rise[1] - rise[0], abs=1e-3)


def test_residual_energy_is_the_kinetic_and_potential_energy_above_rest() -> None:
    """E - min U of the history, at the last step and after it (no damping)."""
    actuator, command = rm.Actuator(prestress=0.5), rm.Steps([0.0, 0.7], [0.1, 0.5])
    ds = rm.step_response(actuator, command)
    lowest = rm.equilibria(actuator, 0.5).equilibrium_potential
    energy = rm.simulate(actuator, command, times=[0.7, 5.0]).energy
    np.testing.assert_allclose(energy - float(lowest.min()), float(ds.residual_energy), atol=1e-9)

"""Damping and frequency of a ringdown are those of the linear oscillator."""

from __future__ import annotations

import numpy as np

import remanent as rm

TRUE = rm.Actuator(dissipation=rm.Rayleigh(0.2), prestress=0.2)


def test_decrement_of_small_oscillations() -> None:
    """(1 + 2c) u'' + 3 eta u' + 18 theta u = 0, over a grid, from the verb's own histories."""
    over = {"dissipation.0.eta": [0.05, 0.1], "temperature": [293.0, 350.0]}
    run = rm.simulate(TRUE.replace(prestress=0.0), rm.Constant(0.0), duration=20.0,
                      initial=(1.00001, 0.0), over=over)  # fmt: skip
    found = rm.logarithmic_decrement(run)
    theta, eta = run.temperature / 293.0, run["dissipation.0.eta"]
    zeta = eta / np.sqrt(8.0 * theta * 3.0)
    omega = np.sqrt(6.0 * theta * (1.0 - zeta**2))
    np.testing.assert_allclose(found.damping_ratio, zeta, rtol=1e-4)
    np.testing.assert_allclose(found.frequency, omega.transpose(*found.dims), rtol=1e-4)

"""Forced oscillators of the textbooks as users write them, under the load cos(omega t)."""

from __future__ import annotations

import numpy as np

import remanent as rm

#: x'' = F cos wt - (d + g x^2) x' - (a + e cos wt) x - k x^3: Duffing, van der Pol, Mathieu.
OSCILLATOR = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="(a + e*load)*x**2/2 + k*x**4/4 - F*load*x",
    dissipation="(d + g*x**2)*x_rate**2/2",
    parameters=dict.fromkeys(("d", "g", "a", "e", "k", "F"), 0.0),
)
#: x'' = F cos wt - d x' - sin x.
PENDULUM = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="-cos(x) - F*load*x",
    dissipation="d*x_rate**2/2",
    parameters={"d": 0.0, "F": 0.0},
)
#: cos t.
COSINE = rm.Sine(1.0, 1.0, phase=np.pi / 2.0)

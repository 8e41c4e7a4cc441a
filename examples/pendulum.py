"""How does the period of a pendulum grow with its swing?

It is 4K(sin² θ₀/2), and without bound near the upright position. The free oscillations
agree with the elliptic integral, up to swings of 179 degrees.

Figure: Left, the phase plane with five swings inside the dashed separatrix; right, the
period against the swing, on the curve of the elliptic integral.

Source: A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations (Wiley, 1979), chapter 2.
"""

import numpy as np
import remanent as rm
from scipy.special import ellipk

pendulum = rm.LagrangianSystem(
    coordinates="theta",
    kinetic="theta_rate**2/2",
    potential="-cos(theta) - load*theta",
    symbols={"theta": r"\theta"},
)
swing = np.radians(np.linspace(1.0, 179.0, 60))
free = rm.backbone(pendulum, swing)
period = 2 * np.pi / free.frequency.values
exact = 4 * ellipk(np.sin(swing / 2) ** 2)
print("largest relative difference", abs(period / exact - 1).max())

speeds = [0.5, 1.0, 1.5, 1.8, 1.98]
motion = rm.simulate(
    pendulum,
    rm.Constant(0.0),
    times=np.linspace(0, 17, 801),
    initial=(0.0, 1.0),
    over={"initial.theta_rate": speeds},
)

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.8))
    rm.plot.phase(motion, ax=left, legend=False, start=False)
    theta = np.linspace(-np.pi, np.pi, 200)
    for sign in (-1, 1):
        left.plot(theta, 2 * sign * np.cos(theta / 2), color="0.5", ls="--", lw=0.8)
    left.set(xlim=(-np.pi, np.pi), xlabel=r"angle, $\theta$", ylabel=r"$\dot{\theta}$")
    right.plot(np.degrees(swing), exact, color="0.6", lw=2.5, label="elliptic integral")
    right.plot(np.degrees(swing), period, ":", color="black", label="computed")
    right.set(
        xlabel=r"swing, $\theta_0$ (degrees)", ylabel="period, $T$", xlim=(0, 180)
    )
    right.legend(loc="upper left")
    figure.savefig("pendulum.png")

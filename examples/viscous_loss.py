"""Which relaxation time takes most energy out of a motion?

For small motions the loss in a period is that of linear viscoelasticity, a quotient of
ωt in t_r, largest where the branch relaxes about as fast as the load oscillates. Slower
branches act as springs, faster ones follow without resistance.

Figure: Energy lost in a period against the relaxation time, on logarithmic axes:
computed points on the curve of linear viscoelasticity, which has one maximum.

Source: the Zener solid of "Thermal effects on nonlinear oscillations of hard-magnetic
soft actuators", section 2, linearised about rest.
"""

import numpy as np
import remanent as rm

modulus, b, omega = 0.5, 0.1, 0.6
times = np.geomspace(0.02, 20.0, 25)
body = rm.Actuator(dissipation=rm.Zener(modulus, 1.0))
settled = rm.cycle_losses(
    body,
    rm.SineSquared(b, omega),
    periods=80,
    discard=79,
    over={"dissipation.0.relaxation_time": times},
    tolerance=1e-9,
)
loss = settled.dissipated_energy.values[:, 0]

# Small motions: 3u'' + 18u + 18 modulus (u - v) = -3 m, t_r v' = u - v, m at 2 omega.
w = 2 * omega
branch = 18 * modulus * (1j * w * times) / (1 + 1j * w * times)
u = -3 * (b**2 / 2) / (18 - 3 * w**2 + branch)
linear = np.pi * branch.imag * abs(u) ** 2 * 2 / 3
print("largest difference from the linear loss:", abs(loss / linear - 1).max())

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.8))
    axes.loglog(times, linear, color="0.6", lw=2.5, label="linear viscoelasticity")
    axes.loglog(times, loss, "o", ms=3, color="#0072B2", label="computed")
    axes.set(xlabel=r"relaxation time, $t_\mathrm{r}$")
    axes.set_ylabel(r"energy lost in a period, over $\mu$")
    axes.legend(loc="lower center")
    figure.savefig("viscous_loss.png")

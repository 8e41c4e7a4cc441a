"""Is the motion at 350 K aperiodic, as its published Poincaré section says?

No. It winds around a torus: 600 points of the section lie on a closed curve, and
`classify` finds it quasi-periodic. With the method of MATLAB's ode45 at its usual
tolerances the points leave this curve and fill an area, because the errors of its steps
add up to a drift from torus to torus.

Figure: Poincaré section of one motion, by a converged integration (a), where the points
form a closed curve, and by RK45 at its usual tolerances (b), where they fill a ring.

Source: figure 5(d) of "Thermal effects on nonlinear oscillations of hard-magnetic soft
actuators", which was integrated by ode45; SciPy's RK45 is the same pair of formulas.
"""

import numpy as np
import remanent as rm
from scipy.integrate import solve_ivp

actuator, drive = rm.Actuator(temperature=350), rm.SineSquared(b=0.4, omega=1.25)
section = rm.poincare_section(actuator, drive, periods=600)
regime = str(rm.classify(actuator, drive, periods=600).regime.values)

times = drive.period * np.arange(601)
loose = solve_ivp(
    rm.rates(actuator, drive),
    (0, times[-1]),
    (1, 0),
    "RK45",
    times,
    rtol=1e-3,
    atol=1e-6,
)
thick = loose.y[0] ** -2
rate = -2 * loose.y[0] ** -3 * loose.y[1]
print(regime, "error", float(section.error))

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(
        1, 2, figsize=(7.0, 3.0), sharex=True, sharey=True
    )
    rm.plot.section(section, ax=left)
    right.plot(thick, rate, ".", ms=2, color="0.25", rasterized=True)
    right.set(xlabel=left.get_xlabel(), xlim=(0.55, 1.05), ylim=(-0.65, 0.65))
    rm.plot.style.set_panel_title(left, "a", f"error below $10^{{-8}}$: {regime}")
    rm.plot.style.set_panel_title(right, "b", "RK45 at rtol $10^{-3}$, atol $10^{-6}$")
    figure.savefig("tolerance.png")

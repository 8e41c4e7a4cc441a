"""How fast do neighbours separate on Lorenz's attractor?

By a factor of e in 1/0.9056 units of time, a published exponent; the second exponent is
zero, as in every flow. A single motion is known only up to its horizon, about 17 units
here, while averages along it can be continued, with a standard error.

Figure: Left, the attractor in the plane of x and z; right, the two largest exponents
against the length of the run, approaching the published 0.9056 and zero.

Source: D. Viswanath, thesis (Cornell University, 1998).
"""

import numpy as np
import remanent as rm

lorenz = rm.FirstOrderSystem(
    rates={"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"},
    parameters={"sigma": 10.0, "rho": 28.0, "beta": 8 / 3},
    observable="z",
    rest={"x": 1.0, "y": 1.0, "z": 27.0},
)
none = rm.Constant(0.0)
motion = rm.simulate(lorenz, none, times=np.linspace(0, 17, 3401), tolerance=1e-5)
spectrum = rm.lyapunov(lorenz, none, duration=800.0, count=2, tolerance=1e-6)
print(spectrum.exponent.values, "±", spectrum.exponent_error.values)

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.9))
    left.plot(motion.x, motion.z, lw=0.5, color="0.2")
    left.set(xlabel="$x$", ylabel="$z$")
    for k, colour in enumerate(("#0072B2", "#D55E00")):
        right.plot(spectrum.time, spectrum.exponent_history[:, k], color=colour)
    right.axhline(0.9056, color="black", ls="--", lw=0.8, label="published, 0.9056")
    right.set(
        xlabel="time, $t$", ylabel=r"Lyapunov exponents, $\Lambda$", ylim=(-0.2, 1.4)
    )
    right.legend(loc="center right")
    figure.savefig("lorenz.png")

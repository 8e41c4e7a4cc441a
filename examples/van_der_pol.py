"""How long is the period of van der Pol's oscillator?

For small μ it is 2π (1 + μ²/16), to fourth order in μ. For larger μ the oscillation
relaxes, with slow creep and fast jumps, and takes longer. Whatever the start, the same
cycle is reached.

Figure: Histories and phase plane for three values of the parameter: nearly circular for
small ones, with fast jumps for large ones.

Source: A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations (Wiley, 1979), chapter 3.
"""

import numpy as np
import remanent as rm

oscillator = rm.FirstOrderSystem(
    rates={"x": "v", "v": "mu*(1 - x**2)*v - x"},
    parameters={"mu": 1.0},
    observable="x",
    rest={"x": 2.0, "v": 0.0},
)
none, values = rm.Constant(0.0), [0.1, 1.0, 4.0]
upward = rm.crossings(
    oscillator, none, "x", 0.0, direction="up", duration=200.0, over={"mu": values}
)
period = [
    float(np.diff(row[np.isfinite(row)])[-1]) for row in upward.crossing_time.values
]
print(dict(zip(values, period, strict=True)))

motion = rm.simulate(
    oscillator,
    none,
    times=np.linspace(0, 60, 4001),
    initial=(0.3, 0.0),
    over={"mu": values},
)
with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(
        1, 2, figsize=(7.0, 2.7), width_ratios=(1.5, 1)
    )
    rm.plot.history(motion, ax=left, legend=False)
    lines = rm.plot.phase(motion, ax=right, legend=False, start=False)
    left.set(xlim=(0, 30), ylabel="$x$")
    right.set(xlabel="$x$", ylabel=r"$\dot{x}$")
    names = [
        rf"$\mu = {mu:g}$, period {t:.4f}" for mu, t in zip(values, period, strict=True)
    ]
    figure.legend(lines, names, loc="outside upper center", ncols=3)
    figure.savefig("van_der_pol.png")

"""Do the exported equations move as the actuator does?

`export` writes the right-hand side as source text. SciPy integrates the Python one; its
difference from our motion stays below the tolerance of 10⁻¹¹. The same call writes
MATLAB, Julia, C, JavaScript and AUTO-07p.

Figure: Above, our motion with points of SciPy's; below, their difference on a
logarithmic axis, below the tolerance.

Source: an integrator that shares no code with ours, DOP853 of SciPy.
"""

import runpy
from pathlib import Path

import numpy as np
import remanent as rm
from scipy.integrate import solve_ivp

actuator = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.05))
drive = rm.SineSquared(b=0.4, omega=1.25)
for name, text in rm.export(actuator, drive, "python").items():
    Path(name).write_text(text)
system = runpy.run_path("system.py")

times = np.linspace(0.0, 60.0, 601)
ours = rm.simulate(actuator, drive, times=times, tolerance=1e-11)
theirs = solve_ivp(
    system["rates"], (0, 60), system["initial"], "DOP853", times, rtol=1e-12, atol=1e-13
)
difference = abs(theirs.y[0] - ours.stretch.values)
print("largest difference", difference.max(), "stated", float(ours.error))

with rm.plot.style.context():
    figure, (above, below) = rm.plot.style.subplots(
        2, 1, figsize=(4.6, 3.6), sharex=True, height_ratios=(1.4, 1)
    )
    rm.plot.history(ours, "stretch", ax=above, label="remanent")
    above.plot(
        times[::6], theirs.y[0, ::6], ".", ms=3, color="#D55E00", label="exported"
    )
    figure.legend(loc="outside upper center", ncols=2)
    below.semilogy(times[1:], difference[1:] + 1e-17, color="0.3", lw=0.7)
    below.set(xlabel=r"time, $\tau$", ylabel="difference", ylim=(1e-16, 1e-10))
    figure.savefig("another_tool.png")

"""Along which line do the resonances of a large motion bend?

Along the backbone, the frequency of free oscillations against their amplitude. It
starts from √(18θ/(1 + 2c)) and falls towards 2√(3θ)/(1 + √c): rubber that is squeezed
and stretched far softens. The peaks of damped response to growing loads lie on it.

Figure: Left, responses for three loads with their folds along the dotted backbone;
right, the frequency of free oscillations from its limit at rest to that of unbounded
swings.

Source: both limits follow from the equation of motion; A. H. Nayfeh and D. T. Mook,
Nonlinear Oscillations (Wiley, 1979), chapter 4.
"""

import numpy as np
import remanent as rm

actuator = rm.Actuator()
free = rm.backbone(actuator, 1.0 + np.geomspace(1e-3, 60.0, 60))
limits = np.sqrt(18 / 3), np.sqrt(3.0)
print("frequencies", free.frequency.values[[0, -1]], "limits", limits)

forced = rm.response_diagram(
    actuator.replace(dissipation=rm.Rayleigh(0.04)),
    rm.SineSquared(b=0.4, omega=1.0),
    (0.98, 1.3),
    over={"b": [0.15, 0.25, 0.35]},
    tolerance=1e-7,
)

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.8))
    # The load of this drive repeats twice in a period of the field.
    left.plot(free.frequency / 2, free.amplitude, ":", color="black", label="backbone")
    rm.plot.branch(forced, ax=left)
    left.text(1.082, 1.18, "backbone", ha="right")
    left.set(xlim=(0.98, 1.3), ylim=(0, 1.3))
    right.semilogy(free.frequency, free.amplitude, color="black")
    for limit in limits:
        right.axvline(limit, color="0.5", ls="--", lw=0.8)
    right.set(
        xlabel=r"frequency of free oscillations, $\omega_0$", ylabel=left.get_ylabel()
    )
    figure.savefig("backbone.png")

"""What does a slow sweep of the frequency show, up and down?

The settled motion stays on its branch until that branch ends at a fold, and jumps to
the other. Upwards and downwards it jumps at different folds, and between them it
depends on the history.

Figure: Thickness stretch once per period against the frequency of the drive: points of
the sweeps up and down on the stable parts of the branch, and two jumps, each at a fold.

Source: the jumps lie within one step of the sweep from the folds that
`response_diagram` locates.
"""

import numpy as np
import remanent as rm

body = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.05))
drive = rm.SineSquared(b=0.4, omega=1.2)
omega = np.linspace(1.18, 1.32, 71)
sweeps = rm.bifurcation_diagram(
    body, drive, "omega", omega, direction="both", discard=120, keep=1, tolerance=1e-7
)
diagram = rm.response_diagram(body, drive, (1.18, 1.32), tolerance=1e-7)

strobed = sweeps.thickness_stretch.isel(period=0)
differs = omega[abs(strobed.sel(sweep="up") - strobed.sel(sweep="down")) > 1e-3]
folds = np.sort(diagram.special_omega.values)
print("two motions between", differs[[0, -1]], "folds at", folds)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.0))
    rm.plot.branch(diagram, "thickness_stretch", ax=axes, color="0.7")
    rm.plot.section(sweeps, "omega", "thickness_stretch", ax=axes)
    figure.savefig("hysteresis.png")

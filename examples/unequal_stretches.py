"""When does a square that is pulled equally on all edges stop being a square?

At a load m = 2 it does so for prestresses between 2 √((√5 − 1)/2) = 1.5723 and 2: there
equal stretches are unstable, and the sheet rests longer in one direction than in the
other. A model of one coordinate cannot see this. From S = 1.94 on a large square is
stable as well.

Figure: In-plane stretches at rest against the prestress: one curve of equal stretches
that becomes unstable between 1.57 and 2, where a pair of unequal ones is stable, and a
second, larger stable one from 1.94 on.

Source: the stiffness 3(2 − S/λ) against a difference of the stretches vanishes on the
equal equilibrium, so that λ⁶ − mλ² + 1 = 0 and S = 2λ.
"""

import numpy as np
import remanent as rm
import xarray as xr

pull = np.linspace(1.4, 2.2, 161)
both = xr.DataArray(pull, dims="pull")
sheet = rm.Actuator(prestress=(1.5, 1.5))
found = rm.equilibria(sheet, 2.0, over={"prestress_1": both, "prestress_2": both})

is_equal = abs(found.stretch_1 - found.stretch_2) < 1e-6
stable = found.stability == "stable"
lost = pull[(is_equal & ~stable).any("equilibrium")]
print("equal stretches are unstable from", lost[0], "to", lost[-1])

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.0))
    kinds = (
        (is_equal & stable, "#0072B2", 3, "equal, stable"),
        (is_equal & ~stable, "#0072B2", 0.8, "equal, unstable"),
        (~is_equal & stable, "#D55E00", 3, "unequal, stable"),
        (~is_equal & ~stable, "#D55E00", 0.8, "unequal, unstable"),
    )
    for chosen, colour, size, name in kinds:
        points = found.stretch_1.where(chosen)
        if points.notnull().any():
            axes.plot(pull, points[:, 0], ".", ms=size, color=colour, label=name)
            axes.plot(pull, points[:, 1:], ".", ms=size, color=colour)
    axes.set(
        xlabel="prestress on all edges, $S$",
        ylabel=r"in-plane stretches, $\lambda_1, \lambda_2$",
    )
    axes.legend(loc="upper left")
    figure.savefig("unequal_stretches.png")

"""Where can a pulled actuator rest in two shapes?

Inside a wedge in the plane of prestress and load, whose two edges are folds. They meet
in a cusp at m = (25/4)^(1/3) = 1.8420, S = 1.8640. Crossing an edge, the actuator snaps
to the other shape; a step of the field does so before the edge is reached.

Figure: The plane of prestress and magnetic load with a shaded wedge: the folds found
lie on its exact edges, which meet in a cusp.

Source: at an edge the force and its derivative vanish together, S = θ (λ − λ⁻⁵) + m λ⁻³
with dS/dλ = 0.
"""

import numpy as np
import remanent as rm

pulls = np.linspace(1.87, 2.4, 54)
found = rm.snap_through(rm.Actuator(), "m", (1.5, 4.0), over={"prestress": pulls})

stretch = np.linspace(0.85, 1.8, 400)
m_edge = (stretch**4 + 5 * stretch**-2) / 3
s_edge = stretch - stretch**-5 + m_edge * stretch**-3
cusp = (25 / 4) ** (1 / 3)
at = found.fold_stretch.values
exact = (at**4 + 5 * at**-2) / 3
print(
    "folds differ from the exact ones by", np.nanmax(abs(found.fold_m.values - exact))
)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.2))
    axes.fill(s_edge, m_edge, color="0.92")
    axes.plot(s_edge, m_edge, color="0.6", lw=2.2, label="exact")
    axes.plot(pulls[::3], found.fold_m[::3], "o", ms=3.5, mfc="white", color="#0072B2")
    axes.plot([], [], "o", ms=3.5, mfc="white", color="#0072B2", label="folds found")
    axes.plot(1.8640, cusp, "k*", ms=7, label="cusp")
    axes.annotate("two stable shapes", (2.27, 2.75))
    axes.set(
        xlabel="prestress, $S$",
        ylabel="magnetic load, $m$",
        xlim=(1.8, 2.4),
        ylim=(1.7, 3.3),
    )
    axes.legend(loc="upper left")
    figure.savefig("two_shapes.png")

"""How strong must a force be to make a double well chaotic?

Melnikov's method says that below F/δ = 4 cosh(πω/2) / (3√2 πω) the motion near the
saddle is not entangled: no point of the chart below that line is chaotic. Chaos that
lasts needs a stronger force than the line says. Hatched points are undecided after the
150 periods computed; longer runs decide more of them.

Figure: Regimes over frequency and force: chaotic and periodic cells in a tongue that
lies above Melnikov's line everywhere.

Source: J. Guckenheimer and P. Holmes, Nonlinear Oscillations, Dynamical Systems, and
Bifurcations of Vector Fields (Springer, 1983), section 4.5.
"""

import numpy as np
import remanent as rm

well = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="-x**2/2 + x**4/4 - load*x",
    dissipation="delta*x_rate**2/2",
    parameters={"delta": 0.25},
    rest={"x": 1.0},
    symbols={"x": "x"},
)
force, omega = np.linspace(0.02, 0.5, 25), np.linspace(0.6, 1.5, 19)
chart = rm.regime_chart(
    well, rm.Sine(0.3, 1.0), {"m": force, "omega": omega}, periods=150, tolerance=1e-6
)
threshold = 0.25 * 4 * np.cosh(np.pi * omega / 2) / (3 * np.sqrt(2) * np.pi * omega)
is_chaotic = chart.regime.transpose("m", "omega").values == "chaotic"
print(
    "chaotic cells:",
    is_chaotic.sum(),
    "below the line:",
    is_chaotic[force[:, None] < threshold].sum(),
)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(5.4, 3.4))
    rm.plot.map(chart, ax=axes)
    line = axes.plot(omega, threshold, "w", lw=2.5) + axes.plot(
        omega, threshold, "k--", lw=1
    )
    axes.annotate(
        "Melnikov", (omega[4], threshold[4]), (0, -11), textcoords="offset points"
    )
    figure.savefig("melnikov.png")

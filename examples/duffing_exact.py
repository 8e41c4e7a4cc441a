"""Can the stated error of a motion be believed?

The free oscillation of Duffing's equation is known: x = A cn(Ωt | k²). Against it the
true error of the computed motion lies below the stated one at every returned time, for
each tolerance.

Figure: True errors over time of four runs on a logarithmic axis, each below the dashed
line of the error that the run states.

Source: Jacobi's elliptic functions, as in SciPy.
"""

import numpy as np
import remanent as rm
from scipy.special import ellipj

spring = rm.LagrangianSystem(
    coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 + x**4/4 - load*x"
)
amplitude, times = 2.0, np.linspace(0.0, 100.0, 1001)
frequency = np.sqrt(1 + amplitude**2)
_, cn, _, _ = ellipj(frequency * times, amplitude**2 / (2 * frequency**2))

tolerances = [1e-4, 1e-6, 1e-8, 1e-10]
runs = [
    rm.simulate(
        spring, rm.Constant(0.0), times=times, initial=(2.0, 0.0), tolerance=tolerance
    )
    for tolerance in tolerances
]
true = np.array([abs(run.x.values - amplitude * cn) for run in runs])
stated = np.array([float(run.error) for run in runs])
print("largest true errors", true.max(axis=1), "stated", stated)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.0))
    colours = list(rm.plot.style.OKABE_ITO_COLOURS.values())
    for error, bound, tolerance, colour in zip(
        true, stated, tolerances, colours, strict=False
    ):
        axes.semilogy(times[1:], error[1:], lw=0.6, color=colour)
        axes.axhline(
            bound, color=colour, ls="--", label=f"$10^{{{np.log10(tolerance):.0f}}}$"
        )
    axes.set(
        xlabel="time, $t$", ylabel="error of the displacement, $x$", ylim=(1e-15, 1e-3)
    )
    figure.legend(
        title="stated, for a tolerance of", loc="outside upper center", ncols=4
    )
    figure.savefig("duffing_exact.png")

"""How far does an uncertain field blur the motion that it starts?

In the first swing the thickness stretch grows with the load, so the quantiles of the
motion are the motions under the quantiles of the load. Later the motions fall out of
step, since their frequencies differ, and the band no longer has the shape of any of
them.

Figure: Median and band of the thickness stretch over time; the dotted motions under the
quantiles of the load run along the edges of the band at first.

Source: the first half of this holds for any monotonic function; the estimates agree
with it.
"""

import numpy as np
import remanent as rm
from scipy.stats import norm

actuator = rm.Actuator(dissipation=rm.Rayleigh(0.1))
load = norm(0.5, 0.06)
times = np.linspace(0.0, 12.0, 121)
band = rm.uncertainty(
    rm.simulate,
    actuator,
    rm.Constant(0.5),
    times=times,
    of="thickness_stretch",
    parameter_ranges={"m": load},
    samples=512,
)
quantiles = band.thickness_stretch.transpose("quantile", "time")
single = rm.simulate(
    actuator,
    rm.Constant(0.5),
    times=times,
    over={"m": load.ppf(band["quantile"].values)},
)
difference = abs(quantiles.values - single.thickness_stretch.values)
print("largest difference up to τ = 1:", difference[:, times <= 1].max())
print("largest difference later:", difference[:, times > 1].max())

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.8))
    rm.plot.curve(band, "thickness_stretch", "time", ax=axes)
    for k, name in ((0, "motions under the quantiles of the load"), (2, None)):
        axes.plot(times, single.thickness_stretch[k], "k:", lw=0.9, label=name)
    axes.legend(loc="lower right", fontsize=7)
    figure.savefig("uncertain_step.png")

"""Between two folds two motions are stable. Which start leads to which?

The plane of initial states divides into two basins, which wind around each other: a
small change of the start decides between the large swing and the small one. Their
shares add up to one, and the two attractors are the two stable orbits that
`periodic_orbits` finds.

Figure: The plane of initial states in two colours, one for each attractor; the smaller
basin winds around the larger in bands.

Source: the two verbs do not share a search, so that each checks the other.
"""

import numpy as np
import remanent as rm

body = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.05))
drive = rm.SineSquared(b=0.4, omega=1.24)
grid = {
    "stretch": np.linspace(0.6, 1.7, 72),
    "stretch_rate": np.linspace(-1.5, 1.5, 54),
}
ends = rm.basins(body, drive, grid, periods=200, tolerance=1e-6)
orbits = rm.periodic_orbits(body, drive)
stable = orbits.initial.values[orbits.stability.values == "stable"]
print("shares", ends.fraction.values, "stable orbits", stable)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.6))
    rm.plot.basins(ends, ax=axes)
    figure.savefig("basins.png")

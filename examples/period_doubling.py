"""Where does the motion begin to repeat only after two periods of the load?

Where a multiplier of the orbit passes −1. There the branch loses its stability, and
another one of twice the period starts from it, which `switch_branch` follows.

Figure: Above, the branch with one value for each period and the one with two, which
starts where the first becomes a saddle; below, the multipliers, whose modulus leaves 1
between the two doublings, marked by squares.

Source: Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (Springer, 2004),
chapter 10.
"""

import numpy as np
import remanent as rm

body = rm.Actuator(dissipation=rm.Rayleigh(0.01))
drive = rm.SineSquared(b=0.8, omega=2.3)
branch = rm.continue_orbit(body, drive, "omega", (2.27, 2.36), tolerance=1e-8)
kinds, places = branch.special_kind.values, branch.special_omega.values
doublings = np.flatnonzero(kinds == "period doubling")
doubled = rm.switch_branch(branch, int(doublings[0]), tolerance=1e-8)

at = branch.isel(special=int(doublings[0]))
state = [[float(at.special_stretch), float(at.special_stretch_rate)]]
period_map = rm.period_map(body, drive.replace(omega=float(at.special_omega)))
multipliers = np.linalg.eigvals(period_map(state).jacobians[0])
print(kinds, places, "multipliers at the first:", multipliers)

with rm.plot.style.context():
    figure, (above, below) = rm.plot.style.subplots(
        2, 1, figsize=(4.6, 4.4), sharex=True, height_ratios=(1.4, 1)
    )
    rm.plot.branch(branch, "thickness_stretch", ax=above, color="#0072B2")
    rm.plot.branch(
        doubled, "thickness_stretch", ax=above, color="#D55E00", legend=False
    )
    rm.plot.multipliers(branch, ax=below, legend=False)
    above.set(xlim=(2.27, 2.36))
    above.text(2.358, 1.167, "repeats after one period", ha="right", color="#0072B2")
    above.text(2.287, 1.25, "after two", color="#D55E00")
    figure.savefig("period_doubling.png")

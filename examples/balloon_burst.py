"""Which pressure bursts a rubber balloon, slowly and suddenly?

Slowly 1.2395 μH/R, the fold at λ = 7^(1/6). Suddenly 1.1121, since the balloon
overshoots: a step that is larger by a thousandth bursts it, one that is smaller leaves
it swinging.

Figure: Left, equilibria of the balloon against pressure with their fold, and a dotted
line at the smaller pressure that bursts it suddenly; right, motions under steps just
below and just above that pressure.

Source: J. Zhu, S. Cai and Z. Suo, Polymer International 59 (2010) 378, for the model;
both numbers follow from its energy.
"""

import numpy as np
import remanent as rm

balloon = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential="stretch**2 + stretch**-4/2 - load*stretch**3/3",
    rest={"stretch": 1.0},
    symbols={"stretch": r"\lambda"},
)
found = rm.snap_through(balloon, "m", (0.1, 2.0), state_box={"stretch": (0.5, 6.0)})
slow, sudden = float(found.fold_m.max()), float(found.snap_m[0])
print("slowly", slow, "suddenly", sudden)

curve = rm.equilibria(
    balloon, over={"m": np.linspace(0.2, 1.3, 111)}, state_box={"stretch": (0.9, 6.0)}
)
steps = [0.9 * sudden, 0.999 * sudden, 1.001 * sudden]
runs = rm.simulate(
    balloon, rm.Constant(sudden), times=np.linspace(0, 14.4, 721), over={"m": steps}
)

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(
        1, 2, figsize=(7.0, 2.8), sharey=True
    )
    rm.plot.equilibria(curve, ax=left)
    left.axvline(sudden, color="#D55E00", ls=":", lw=1)
    lines = rm.plot.history(runs, ax=right, legend=False)
    right.legend(lines, [f"$m = {m:.4f}$" for m in steps], loc="upper left")
    left.set(ylim=(0.9, 4))
    figure.savefig("balloon_burst.png")

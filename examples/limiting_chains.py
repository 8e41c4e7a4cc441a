"""What do chains of limited length do to large oscillations?

They turn the backbone round. A neo-Hookean block softens as its swing grows; a Gent
solid stiffens near the limit I₁ = J_m + 3 of its chains, which the motion never passes.
As J_m grows without bound it becomes neo-Hookean. The published study follows how the
length of chains changes the dynamic response; its numbers were not at hand, so these
two limits are compared.

Figure: Amplitude against the frequency of free oscillations: the neo-Hookean curve
bends to the left, those of three Gent solids to the right, the more the shorter their
chains.

Source: S. Nandan, D. Sharma and A. K. Sharma, Dynamic modeling of hard-magnetic soft
actuators: Unraveling the role of polymer chain entanglements, crosslinks, and finite
extensibility, J. Magn. Magn. Mater. (2023) 171237; A. N. Gent, Rubber Chem. Technol. 69
(1996) 59.
"""

import numpy as np
import remanent as rm
from scipy.optimize import brentq


def longest_stretch(jm):
    """Stretch at which the chains are straight: 2 λ² + 1/λ⁴ = J_m + 3."""
    return brentq(lambda x: 2 * x**2 + x**-4 - 3 - jm, 1.0, 100.0)


lengths = [1.0, 3.0, 10.0]
limits = [longest_stretch(jm) for jm in lengths]
swings = np.linspace(0.005, 0.985, 60)
chains = {
    jm: rm.backbone(rm.Actuator(material=rm.Gent(jm)), 1 + (limit - 1) * swings)
    for jm, limit in zip(lengths, limits, strict=True)
}
free = rm.backbone(rm.Actuator(), 1 + np.linspace(0.005, 1.7, 60))
endless = rm.backbone(
    rm.Actuator(material=rm.Gent(1e9)), free["initial.stretch"].values
)
difference = float(abs(endless.frequency.values - free.frequency.values).max())
print("J_m = 1e9 and neo-Hookean differ by", difference)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.0))
    axes.plot(free.frequency, free.amplitude, "k--", label="neo-Hookean")
    for (jm, found), line in zip(chains.items(), ("-", "-.", ":"), strict=True):
        axes.plot(
            found.frequency, found.amplitude, line, lw=1.3, label=rf"$J_m = {jm:g}$"
        )
    axes.set(
        xlabel=r"frequency of free oscillations, $\omega_0$",
        ylim=(0, None),
        xlim=(2, 4),
    )
    axes.set_ylabel(r"thickness stretch amplitude, $\lambda_3^a$")
    figure.legend(loc="outside upper center", ncols=4)
    figure.savefig("limiting_chains.png")

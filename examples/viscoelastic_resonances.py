"""Which resonances does the viscoelastic actuator have?

A superharmonic, a primary and a subharmonic one: the load oscillates at about a half,
once and twice the frequency of the free oscillation of the same amplitude. Such
resonances are what the study of this actuator with a Zener solid and a linear dashpot
is reported to find; its numbers were not at hand, so only the three orders are
compared.

Figure: Amplitude of the settled motion against the frequency of the drive, for a weak
load with the superharmonic and the primary peak (a), and for a strong one with the
subharmonic peak (b); the numbers are the frequency of the load over that of the free
oscillation.

Source: S. Nandan, D. Sharma and A. K. Sharma, Viscoelastic effects on the nonlinear
oscillations of hard-magnetic soft actuators, J. Appl. Mech. 90 (2023), as cited by
"Thermal effects on nonlinear oscillations of hard-magnetic soft actuators".
"""

import numpy as np
import remanent as rm
from scipy.signal import argrelmax

body = rm.Actuator(dissipation=(rm.Zener(0.05, 20.0), rm.Rayleigh(0.05)))
cases = {0.4: np.linspace(0.55, 1.5, 96), 1.2: np.linspace(2.1, 2.3, 81)}
responses, marks = [], []
for b, omega in cases.items():
    found = rm.frequency_response(
        body,
        rm.SineSquared(b, 1.0),
        omega,
        duration=400,
        discard=350,
        tolerance=1e-4,
        resonance_width=1e-2,
    )
    amplitude = found.amplitude.values
    rest = float(
        rm.equilibria(rm.Actuator(), b**2 / 2).stretch[0]
    )  # under the mean load
    free = rm.backbone(rm.Actuator(), rest + np.linspace(1e-3, 1.0, 40), m=b**2 / 2)
    peaks = argrelmax(amplitude, order=4)[0]
    own = np.interp(amplitude[peaks], free.amplitude, free.frequency)
    marks.append(
        list(zip(omega[peaks], amplitude[peaks], 2 * omega[peaks] / own, strict=True))
    )
    responses.append(found)
print(marks)

with rm.plot.style.context():
    figure, panels = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.7))
    for axes, found, peaks, letter, b in zip(
        panels, responses, marks, "ab", cases, strict=True
    ):
        rm.plot.response(found, ax=axes, legend=False, resonances=False)
        axes.set_title(f"({letter})  $b = {b:g}$")
        axes.margins(y=0.12)
        for place, height, ratio in peaks:
            axes.annotate(
                f"{ratio:.2f}", (place, height), (0, 3), textcoords="offset points"
            )
    figure.savefig("viscoelastic_resonances.png")

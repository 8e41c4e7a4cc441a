"""At which frequencies does the actuator resonate, warm and cold, pulled and free?

At 1.05, 1.25 and 1.35 for 250, 350 and 400 K, and at 0.85, 1.08 and 1.19 under a
prestress S = 1: all six published frequencies come out within 0.01. The amplitude is
that of the motion from rest over a window of 100 units of time, and it jumps at each
resonance.

Figure: Amplitude against the frequency of the drive at three temperatures, without
prestress (a) and with it (b); rings mark the resonances found, triangles on the upper
edge the published ones.

Source: figure 4 and section 4 of "Thermal effects on nonlinear oscillations of hard-
magnetic soft actuators". The article does not state load, reference temperature and
window; those used here are reconstructed from its six frequencies.
"""

import numpy as np
import remanent as rm

published = [[1.05, 1.25, 1.35], [0.85, 1.08, 1.19]]
temperatures = [250.0, 350.0, 400.0]
result = rm.frequency_response(
    rm.Actuator(),
    rm.SineSquared(b=0.4, omega=1.0),
    np.linspace(0.6, 1.6, 201),
    duration=100,
    over={"prestress": [0.0, 1.0], "temperature": temperatures},
    resonance_width=1e-4,
    tolerance=1e-7,
)
print(result.resonance.values)

with rm.plot.style.context():
    figure, panels = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.7), sharey=True)
    colours = rm.plot.style.temperature_colours(temperatures)
    for k, (axes, letter) in enumerate(zip(panels, "ab", strict=True)):
        lines = rm.plot.response(result.isel(prestress=k), ax=axes, legend=False)
        axes.set_title(f"({letter})  $S = {k}$")
        axes.label_outer()
        axes.scatter(
            published[k],
            [0.97] * 3,
            marker="v",
            c=colours,
            s=14,
            transform=axes.get_xaxis_transform(),
        )
    names = [f"$T = {t:g}$ K" for t in temperatures]
    figure.legend(lines[:3], names, loc="outside upper center", ncols=3)
    figure.savefig("published_resonances.png")

"""Is a theory at one temperature enough?

For this model, yes: temperature only changes the scales. The responses at 250, 350 and
400 K fall on the isothermal one when the load is divided by θ = T/T₀ and the frequency
by √θ. Resonance frequencies therefore grow as √T under a load in proportion to T. The
isothermal model is that of Xing and Yong; of their article no numbers were at hand, so
the isothermal limit of the equations is what is compared.

Figure: Left, responses at three temperatures with their peaks apart; right, the same in
scaled axes, all on the isothermal one.

Source: Z. Xing and H. Yong, as cited by "Thermal effects on nonlinear oscillations of
hard-magnetic soft actuators"; equation 16 there, with T = T₀.
"""

import numpy as np
import remanent as rm

scaled = np.linspace(0.7, 1.4, 141)
responses = {}
for temperature in (293.0, 250.0, 350.0, 400.0):
    theta = temperature / 293.0
    body = rm.Actuator(
        temperature=temperature, dissipation=rm.Rayleigh(0.05 * theta**0.5)
    )
    drive = rm.SineSquared(b=0.4 * theta**0.5, omega=1.0)
    responses[temperature] = rm.frequency_response(
        body,
        drive,
        scaled * theta**0.5,
        duration=100 / theta**0.5,
        resonance_width=1e-4,
    )
isothermal = responses.pop(293.0).amplitude.values
difference = max(abs(r.amplitude.values - isothermal).max() for r in responses.values())
print("largest difference from the isothermal response", difference)

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(
        1, 2, figsize=(7.0, 2.7), sharey=True
    )
    colours = rm.plot.style.temperature_colours(responses)
    dashes = ["-", (0, (4, 4)), (4, (2, 6))]
    right.plot(scaled, isothermal, color="0.7", lw=4, label="isothermal")
    for (temperature, found), colour, line in zip(
        responses.items(), colours, dashes, strict=True
    ):
        name = f"$T = {temperature:g}$ K"
        left.plot(found.omega, found.amplitude, color=colour, label=name)
        right.plot(scaled, found.amplitude, color=colour, ls=line, lw=1.2)
    left.set(xlabel=r"drive frequency, $\omega$")
    left.set(ylabel=r"thickness stretch amplitude, $\lambda_3^a$")
    right.set(xlabel=r"scaled frequency, $\omega/\sqrt{\theta}$")
    left.legend(loc="upper right")
    right.legend(loc="upper right")
    figure.savefig("isothermal.png")

"""How much thinner is the actuator at 75 °C, because its magnet is weaker?

Warmth stiffens the rubber and weakens the magnet, and both make the actuation smaller.
The thickness stretch at rest is the root of x³ − βx² − 1 = 0 with β = m (1 + α(T − T₀))
T₀/T; the loss of remanence of NdFeB, α = −0.1 % per kelvin, makes the drop from 20 °C
to 75 °C larger by 28 %.

Figure: Thickness stretch at rest against temperature for three temperature coefficients
of the magnet; all fall, the steeper the larger the coefficient.

Source: equation 16 of "Thermal effects on nonlinear oscillations of hard-magnetic soft
actuators" at rest; α is a usual value for NdFeB.
"""

import numpy as np
import remanent as rm

temperature = np.linspace(253.0, 348.0, 20)
coefficients = [-0.002, -0.001, 0.0]
found = rm.equilibria(
    rm.Actuator(magnet=rm.Magnet(temperature_coefficient=-0.001)),
    0.5,
    over={"magnet.temperature_coefficient": coefficients, "temperature": temperature},
)
thick = found.equilibrium_stretch.values[:, :, 0]

strength = 1 + np.outer(coefficients, temperature - 293)
beta = 0.5 * strength * 293 / temperature
print("largest residual of the cubic", abs(thick**3 - beta * thick**2 - 1).max())

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.8))
    for row, alpha, line in zip(thick, coefficients, ("-", "--", ":"), strict=True):
        axes.plot(
            temperature, row, line, label=rf"$\alpha = {100 * alpha:g}$ % per kelvin"
        )
    axes.set(
        xlabel="temperature, $T$ (K)", ylabel=r"thickness stretch at rest, $\lambda_3$"
    )
    axes.legend(loc="upper right")
    figure.savefig("warm_magnet.png")

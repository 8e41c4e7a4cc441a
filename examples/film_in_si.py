"""At how many hertz does a film of 10 mm × 10 mm × 1 mm resonate?

A weak field finds the natural frequency √(18μ/(ρL²(1 + 2c)))/2π, here 945 Hz. The
response peaks where the field has half of it, since the load repeats twice in a period
of the field. A stronger field bends the resonance to lower frequencies.

Figure: Amplitude of the thickness in millimetres against frequency in hertz for three
flux densities; the peak leans to lower frequencies as the field grows; dashed, half of
the natural frequency.

Source: the frequency follows from the equation of motion in SI; equation 15 of "Thermal
effects on nonlinear oscillations of hard-magnetic soft actuators" has the scales.
"""

import numpy as np
import remanent as rm

film = rm.Actuator.from_si(
    shear_modulus="100 kPa",
    density="2000 kg/m^3",
    half_length="5 mm",
    half_thickness="0.5 mm",
    remanence="143 mT",
    dissipation=rm.Rayleigh(0.1),
)
fields = ["50 mT", "150 mT", "250 mT"]
drive = rm.SineSquared(b=film.load(fields[0]) ** 0.5, omega=1.0)
omega = np.linspace(film.frequency("300 Hz"), film.frequency("600 Hz"), 151)
result = rm.frequency_response(
    film,
    drive,
    omega,
    duration=160,
    discard=120,
    over={"b": [film.load(field) ** 0.5 for field in fields]},
    resonance_width=1e-4,
    tolerance=1e-6,
)
natural = np.sqrt(18 * 100e3 / (2000 * 0.005**2 * (1 + 2 * 0.01))) / (2 * np.pi)
in_si = rm.to_si(result, lengths=True)
print(in_si.resonance.values, in_si.resonance.attrs["units"], "half of", natural)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.8))
    rm.plot.response(in_si, ax=axes)
    axes.axvline(natural / 2, color="0.5", ls="--", lw=0.8)
    figure.savefig("film_in_si.png")

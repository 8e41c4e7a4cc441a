"""How warm does a damped block get that is shaken for long?

It warms until it gives as much heat to its surroundings as it dissipates: the mean rise
is the energy lost in a period, times the coupling, over the exchange and the period.

Figure: Temperature rise against time: a thin oscillating band that approaches the
dashed level that the balance gives.

Source: the balance of energy over a period; the equation of heat follows from the free
energy of "Thermal effects on nonlinear oscillations of hard-magnetic soft actuators",
equation 6.
"""

import numpy as np
import remanent as rm

coupling, exchange = 2e-4, 0.02
drive = rm.SineSquared(b=0.8, omega=1.3)
body = rm.Actuator(
    dissipation=rm.Zener(0.5, 0.5), heat=rm.Heat(coupling=coupling, exchange=exchange)
)
periods = 160
times = np.linspace(0, periods * drive.period, 40 * periods + 1)
motion = rm.simulate(body, drive, times=times, tolerance=1e-8)
rise = motion.body_temperature - 293.0

losses = rm.cycle_losses(
    body, drive, periods=periods, discard=periods - 1, tolerance=1e-8
)
predicted = (
    293 * coupling * float(losses.dissipated_energy[0]) / (exchange * drive.period)
)
mean_rise = float(rise[-41:-1].mean())
print("mean rise in K", mean_rise, "by the balance", predicted)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.8))
    axes.plot(times, rise, lw=0.5, color="#D55E00", label="temperature")
    axes.axhline(predicted, color="black", ls="--", label="loss over exchange")
    axes.set(xlabel=r"time, $\tau$", ylabel=r"temperature rise, $T - T_\infty$ (K)")
    axes.legend(loc="lower right")
    figure.savefig("self_heating.png")

"""Where does the work of the field go?

While the swing builds up most of it is stored; from then on all of it is lost to the
dashpot. At every instant work = stored + lost, to the error that the result states.

Figure: Three curves of energy over time: work of the field, energy stored, which levels
off, and energy lost, which then grows as the work does.

Source: the first law, integrated with the motion.
"""

import remanent as rm

body = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.05))
drive = rm.SineSquared(b=0.4, omega=1.27)
energy = rm.energy_balance(body, drive, periods=120)
print("imbalance", float(abs(energy.balance).max()), "±", float(energy.balance_error))

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.8))
    axes.plot(energy.time, energy.drive_work, "-", label="work of the field")
    axes.plot(energy.time, energy.dissipated_energy, "--", label="lost")
    axes.plot(energy.time, energy.stored_energy, "-.", label="stored")
    axes.set(xlabel=r"time, $\tau$", ylabel=r"energy per volume, over $\mu$")
    axes.legend(loc="upper left")
    figure.savefig("energy_balance.png")

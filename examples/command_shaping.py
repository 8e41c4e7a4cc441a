"""Can a block be moved to a new shape without ringing?

Yes, by two steps of the field in place of one: the first is chosen so that the block
turns round exactly at its target, and there the second holds it, as magnetic and
elastic force balance. A single step overshoots by the whole move and rings for ever.
The published scheme switches at the same point of balance; its numbers were not at
hand, so the loads are compared with their closed forms m₁ = (x − 1)(x + 2)/2x and m₂ =
(x³ − 1)/x², x being the thickness stretch at the target.

Figure: Above, one step makes the thickness stretch swing between 1 and 1.64 while two
steps bring it to 1.3 and keep it there; below, the two loads.

Source: Alleviation of residual vibrations in hard-magnetic soft actuators using a
command-shaping scheme, Polymers 14 (2022) 3037.
"""

import numpy as np
import remanent as rm

actuator, target = rm.Actuator(), 1.3
command = rm.shape_command(actuator, target)
exact = (target - 1) * (target + 2) / (2 * target), (target**3 - 1) / target**2
residual = float(rm.step_response(actuator, command).residual_amplitude)
print("loads", command.loads, "exact", exact, "residual vibration", residual)

times = np.linspace(0, 9, 1001)
shaped = rm.simulate(actuator, command, times=times)
plain = rm.simulate(actuator, rm.Constant(command.loads[-1]), times=times)

with rm.plot.style.context():
    figure, (above, below) = rm.plot.style.subplots(
        2, 1, figsize=(4.6, 3.8), sharex=True, height_ratios=(2, 1)
    )
    above.axhline(target, color="0.6", lw=0.8)
    for motion, name, line in ((plain, "one step", "--"), (shaped, "two steps", "-")):
        above.plot(times, motion.thickness_stretch, line, label=name)
        below.plot(times, motion["load"].broadcast_like(motion.stretch), line)
    above.set_ylabel(r"thickness stretch, $\lambda_3$")
    below.set(xlabel=r"time, $\tau$", ylabel="load, $m$", xlim=(0, 9), ylim=(0, 0.8))
    figure.legend(loc="outside upper center", ncols=2)
    figure.savefig("command_shaping.png")

"""How far does a block swing when a field is switched on, and what does warmth change?

It swings past its equilibrium, up to the thickness stretch x with x² + (1 − 2β)x − 2 =
0, where β = m T₀/T and m is the load, and back to where it started. Nothing takes
energy from it, so the orbits are closed and the motion never settles. The warmer the
block, the stiffer it is, and the smaller is its swing.

Figure: Thickness stretch against time and its phase plane at three temperatures: closed
orbits, the larger the colder; the marks are the turning points that the energy gives.

Source: figures 2 and 3 of "Thermal effects on nonlinear oscillations of hard-magnetic
soft actuators"; the turning point follows from the energy at rest.
"""

import numpy as np
import remanent as rm

temperature = np.array([250.0, 350.0, 400.0])
field = rm.Constant(0.16)
motion = rm.simulate(
    rm.Actuator(),
    field,
    times=np.linspace(0, 14, 2001),
    over={"temperature": temperature},
)

beta = 0.16 * 293.0 / temperature
turning_point = beta - 0.5 + np.sqrt((beta - 0.5) ** 2 + 2.0)
largest = motion.thickness_stretch.max("time").values
print("largest thickness stretch", largest, "by the energy", turning_point)

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.6))
    rm.plot.history(motion, ax=left)
    rm.plot.phase(motion, ax=right, legend=False, start=False)
    right.plot(turning_point, 0 * beta, "k|", ms=9, label="turning point by the energy")
    right.legend(handles=right.get_lines()[-1:], loc=(0, 1.02))
    figure.savefig("constant_field.png")

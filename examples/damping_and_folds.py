"""How much damping does it take to remove the jumps of a resonance?

With little damping the branch of forced response folds back over itself: between two
folds three motions exist, and the middle one is a saddle. The folds approach each other
as damping grows, and beyond a cusp there is one motion for each frequency and nothing
jumps.

Figure: Amplitude against the frequency of the drive for four strengths of damping;
three of the curves lean over and have two folds with a dashed saddle between them, the
most damped one has none.

Source: the law is that folds come in pairs; A. H. Nayfeh and D. T. Mook, Nonlinear
Oscillations (Wiley, 1979), chapter 4.
"""

import remanent as rm

damping = [0.04, 0.06, 0.08, 0.12]
body = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.1))
diagram = rm.response_diagram(
    body,
    rm.SineSquared(b=0.4, omega=1.25),
    (1.1, 1.4),
    over={"dissipation.0.eta": damping},
    tolerance=1e-7,
)
folds = (diagram.special_kind == "fold").sum("special").values
print("folds", dict(zip(damping, folds.tolist(), strict=True)))

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 3.0))
    rm.plot.branch(diagram, ax=axes)
    figure.savefig("damping_and_folds.png")

"""How slowly must a magnet pass by, so that a block does not ring afterwards?

The block follows a slow magnet and is at rest when it has gone; a fast one leaves it
ringing. For a field m₀/(1 + τ²/t²) the ringing has the amplitude (π m₀ t/√6) exp(−√6
t), as long as it is small: twice as slow is not twice but exponentially calmer. The
ringing is largest at t = 1/√6; a magnet that passes faster still pushes too briefly.

Figure: Left, thickness stretch while a magnet passes by at three speeds: the fast one
leaves ringing; right, the ringing against the time of passage on a logarithmic axis, on
the linear prediction.

Source: a linear oscillator keeps the Fourier transform of its force at its own
frequency, √6 for the undeformed block.
"""

import numpy as np
import remanent as rm

actuator, peak = rm.Actuator(), 0.02
passage_times = np.array([0.2, 0.4, 0.7, 1.0, 1.5, 2.0])
ringing, motions = [], {}
for t in passage_times:
    times = t * np.sinh(np.linspace(-4.3, 4.3, 121))
    field = rm.Sampled(times - times[0], peak / (1 + (times / t) ** 2))
    after = np.linspace(20 * t, 36 * t, 400)
    seen = np.append(np.linspace(-20 * t, 20 * t, 1200)[:-1], after)
    motion = rm.simulate(actuator, field, times=seen - times[0], tolerance=1e-8)
    late = motion.stretch.values[-400:]
    ringing.append((late.max() - late.min()) / 2)
    motions[t] = seen, motion.thickness_stretch


def linear(t):
    """Amplitude of the ringing after a small load."""
    return np.pi * peak * t / np.sqrt(6) * np.exp(-np.sqrt(6) * t)


print("computed over linear", np.array(ringing) / linear(passage_times))

with rm.plot.style.context():
    figure, (left, right) = rm.plot.style.subplots(1, 2, figsize=(7.0, 2.7))
    for t, line in ((0.2, "-"), (1.0, "--"), (2.0, ":")):
        left.plot(*motions[t], line, label=f"$t = {t:g}$")
    left.set(
        xlabel=r"time, $\tau$", ylabel=r"thickness stretch, $\lambda_3$", xlim=(-4, 7)
    )
    left.legend(loc="upper left")
    fine = np.linspace(0.15, 2.1, 100)
    right.semilogy(fine, linear(fine), color="0.6", lw=2.2, label="linear")
    right.semilogy(
        passage_times, ringing, "o", ms=3.5, color="#0072B2", label="computed"
    )
    right.set(
        xlabel="time of passage, $t$", ylabel=r"ringing of the stretch, $\lambda$"
    )
    right.legend(loc="upper right")
    figure.savefig("passing_magnet.png")

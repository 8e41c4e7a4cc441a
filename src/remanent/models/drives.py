"""Every drive by name: the magnetic load m(tau) of an actuator."""

from remanent.models.chirp import Chirp
from remanent.models.drive import Drive
from remanent.models.piecewise import Ramp, Sampled, Steps
from remanent.models.sines import Sines
from remanent.models.waves import Constant, Sine, SineSquared

__all__ = ["Chirp", "Constant", "Drive", "Ramp", "Sampled", "Sine", "SineSquared", "Sines", "Steps"]

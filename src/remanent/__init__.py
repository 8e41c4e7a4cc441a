"""Nonlinear oscillations of hard-magnetic soft actuators, with an error for every number.

The public names are listed in ``__all__``.  Each is imported when it is first used,
so that ``import remanent`` itself imports neither NumPy nor anything heavier.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from remanent import plots as plot
    from remanent._errors import InputError, InputWarning, IntegrationError, RemanentError
    from remanent.derivation.readable import equations
    from remanent.models.actuator import Actuator
    from remanent.models.dissipation import KelvinVoigt, Rayleigh, Zener
    from remanent.models.drives.chirp import Chirp
    from remanent.models.drives.piecewise import Ramp, Sampled, Steps
    from remanent.models.drives.sines import Sines
    from remanent.models.drives.waves import Constant, Sine, SineSquared
    from remanent.models.heat import Heat
    from remanent.models.magnet import Magnet
    from remanent.models.materials.named import ArrudaBoyce, Gent, MooneyRivlin, NeoHookean, Ogden
    from remanent.models.materials.strain_energy import StrainEnergy
    from remanent.models.temperature_shift import WLF, Arrhenius
    from remanent.results.read_measurements import measurements
    from remanent.results.rescale import rescale
    from remanent.results.si import to_si
    from remanent.studies.control.shape_command import shape_command, shaped_steps
    from remanent.studies.control.step_response import step_response
    from remanent.studies.inference.design import design
    from remanent.studies.inference.fit import fit
    from remanent.studies.inference.logarithmic_decrement import logarithmic_decrement
    from remanent.studies.inference.measure import Measure
    from remanent.studies.inference.sensitivity import sensitivity
    from remanent.studies.inference.uncertainty import uncertainty
    from remanent.studies.motion.crossings import crossings
    from remanent.studies.motion.cycle_losses import cycle_losses
    from remanent.studies.motion.energy_balance import energy_balance
    from remanent.studies.motion.poincare_section import poincare_section
    from remanent.studies.motion.simulate import simulate
    from remanent.studies.orbits.continue_bifurcation import continue_special
    from remanent.studies.orbits.continue_orbit import continue_orbit, response_diagram
    from remanent.studies.orbits.locate_bifurcation import special_point
    from remanent.studies.orbits.manifold_crossing import manifold_crossing
    from remanent.studies.orbits.periodic_orbits import periodic_orbits
    from remanent.studies.orbits.switch_branch import switch_branch
    from remanent.studies.regimes.basins import basins
    from remanent.studies.regimes.bifurcation_diagram import bifurcation_diagram
    from remanent.studies.regimes.classify import classify
    from remanent.studies.regimes.lyapunov import lyapunov
    from remanent.studies.regimes.regime_chart import regime_chart
    from remanent.studies.regimes.symmetry_check import symmetry_check
    from remanent.studies.response.backbone import backbone
    from remanent.studies.response.frequency_response import frequency_response
    from remanent.studies.response.resonances import resonances
    from remanent.studies.statics.equilibria import equilibria
    from remanent.studies.statics.snap_through import snap_through

    __version__: str

__all__ = [
    "WLF",
    "Actuator",
    "Arrhenius",
    "ArrudaBoyce",
    "Chirp",
    "Constant",
    "Gent",
    "Heat",
    "InputError",
    "InputWarning",
    "IntegrationError",
    "KelvinVoigt",
    "Magnet",
    "Measure",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Ramp",
    "Rayleigh",
    "RemanentError",
    "Sampled",
    "Sine",
    "SineSquared",
    "Sines",
    "Steps",
    "StrainEnergy",
    "Zener",
    "__version__",
    "backbone",
    "basins",
    "bifurcation_diagram",
    "classify",
    "continue_orbit",
    "continue_special",
    "crossings",
    "cycle_losses",
    "design",
    "energy_balance",
    "equations",
    "equilibria",
    "fit",
    "frequency_response",
    "logarithmic_decrement",
    "lyapunov",
    "manifold_crossing",
    "measurements",
    "periodic_orbits",
    "plot",
    "poincare_section",
    "regime_chart",
    "rescale",
    "resonances",
    "response_diagram",
    "sensitivity",
    "shape_command",
    "shaped_steps",
    "simulate",
    "snap_through",
    "special_point",
    "step_response",
    "switch_branch",
    "symmetry_check",
    "to_si",
    "uncertainty",
]

#: Where each name is defined; ``plot`` and ``__version__`` are treated apart.
_HOME: Final = {
    "Actuator": "models.actuator",
    "Arrhenius": "models.temperature_shift",
    "ArrudaBoyce": "models.materials.named",
    "Chirp": "models.drives.chirp",
    "Constant": "models.drives.waves",
    "Gent": "models.materials.named",
    "Heat": "models.heat",
    "InputError": "_errors",
    "InputWarning": "_errors",
    "IntegrationError": "_errors",
    "KelvinVoigt": "models.dissipation",
    "Magnet": "models.magnet",
    "Measure": "studies.inference.measure",
    "MooneyRivlin": "models.materials.named",
    "NeoHookean": "models.materials.named",
    "Ogden": "models.materials.named",
    "Ramp": "models.drives.piecewise",
    "Rayleigh": "models.dissipation",
    "RemanentError": "_errors",
    "Sampled": "models.drives.piecewise",
    "Sine": "models.drives.waves",
    "SineSquared": "models.drives.waves",
    "Sines": "models.drives.sines",
    "Steps": "models.drives.piecewise",
    "StrainEnergy": "models.materials.strain_energy",
    "WLF": "models.temperature_shift",
    "Zener": "models.dissipation",
    "backbone": "studies.response.backbone",
    "basins": "studies.regimes.basins",
    "bifurcation_diagram": "studies.regimes.bifurcation_diagram",
    "classify": "studies.regimes.classify",
    "continue_orbit": "studies.orbits.continue_orbit",
    "continue_special": "studies.orbits.continue_bifurcation",
    "crossings": "studies.motion.crossings",
    "cycle_losses": "studies.motion.cycle_losses",
    "design": "studies.inference.design",
    "energy_balance": "studies.motion.energy_balance",
    "equations": "derivation.readable",
    "equilibria": "studies.statics.equilibria",
    "fit": "studies.inference.fit",
    "frequency_response": "studies.response.frequency_response",
    "logarithmic_decrement": "studies.inference.logarithmic_decrement",
    "lyapunov": "studies.regimes.lyapunov",
    "manifold_crossing": "studies.orbits.manifold_crossing",
    "measurements": "results.read_measurements",
    "periodic_orbits": "studies.orbits.periodic_orbits",
    "poincare_section": "studies.motion.poincare_section",
    "regime_chart": "studies.regimes.regime_chart",
    "rescale": "results.rescale",
    "resonances": "studies.response.resonances",
    "response_diagram": "studies.orbits.continue_orbit",
    "sensitivity": "studies.inference.sensitivity",
    "shape_command": "studies.control.shape_command",
    "shaped_steps": "studies.control.shape_command",
    "simulate": "studies.motion.simulate",
    "snap_through": "studies.statics.snap_through",
    "special_point": "studies.orbits.locate_bifurcation",
    "step_response": "studies.control.step_response",
    "switch_branch": "studies.orbits.switch_branch",
    "symmetry_check": "studies.regimes.symmetry_check",
    "to_si": "results.si",
    "uncertainty": "studies.inference.uncertainty",
}

if not TYPE_CHECKING:  # a type checker knows the names above and should refuse all others

    def __getattr__(name: str) -> object:
        if name == "plot":
            value: object = import_module("remanent.plots")
        elif name == "__version__":
            value = import_module("importlib.metadata").version("remanent")
        elif name in _HOME:
            value = getattr(import_module(f"remanent.{_HOME[name]}"), name)
        else:
            raise AttributeError(f"module 'remanent' has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

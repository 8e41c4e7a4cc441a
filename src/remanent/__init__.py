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
    from remanent.models.actuator import Actuator
    from remanent.models.drives import (
        Chirp,
        Constant,
        Ramp,
        Sampled,
        Sine,
        Sines,
        SineSquared,
        Steps,
    )
    from remanent.models.magnetics import Magnet
    from remanent.models.materials import (
        ArrudaBoyce,
        Gent,
        MooneyRivlin,
        NeoHookean,
        Ogden,
        StrainEnergy,
    )
    from remanent.models.shifts import WLF, Arrhenius
    from remanent.models.thermal import Heat
    from remanent.models.viscous import KelvinVoigt, Rayleigh, Zener
    from remanent.results.measured import measurements
    from remanent.results.rescale import rescale
    from remanent.results.si import to_si
    from remanent.studies._measure import Measure
    from remanent.studies.backbone import backbone
    from remanent.studies.balance import energy_balance
    from remanent.studies.basins import basins
    from remanent.studies.bifurcation import bifurcation_diagram
    from remanent.studies.branches import continue_orbit, response_diagram
    from remanent.studies.chart import regime_chart
    from remanent.studies.classify import classify
    from remanent.studies.command import shape_command, shaped_steps
    from remanent.studies.crossings import crossings
    from remanent.studies.decrement import logarithmic_decrement
    from remanent.studies.design import design
    from remanent.studies.equilibria import equilibria
    from remanent.studies.fit import fit
    from remanent.studies.locate import special_point
    from remanent.studies.losses import cycle_losses
    from remanent.studies.lyapunov import lyapunov
    from remanent.studies.orbits import periodic_orbits
    from remanent.studies.resonances import resonances
    from remanent.studies.response import frequency_response
    from remanent.studies.section import poincare_section
    from remanent.studies.sensitivity import sensitivity
    from remanent.studies.separatrix import manifold_crossing
    from remanent.studies.simulate import simulate
    from remanent.studies.snap import snap_through
    from remanent.studies.special import continue_special
    from remanent.studies.step_response import step_response
    from remanent.studies.switch import switch_branch
    from remanent.studies.symmetry import symmetry_check
    from remanent.studies.uncertainty import uncertainty

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
    "Arrhenius": "models.shifts",
    "ArrudaBoyce": "models.materials",
    "Chirp": "models.drives",
    "Constant": "models.drives",
    "Gent": "models.materials",
    "Heat": "models.thermal",
    "InputError": "_errors",
    "InputWarning": "_errors",
    "IntegrationError": "_errors",
    "KelvinVoigt": "models.viscous",
    "Magnet": "models.magnetics",
    "Measure": "studies._measure",
    "MooneyRivlin": "models.materials",
    "NeoHookean": "models.materials",
    "Ogden": "models.materials",
    "Ramp": "models.drives",
    "Rayleigh": "models.viscous",
    "RemanentError": "_errors",
    "Sampled": "models.drives",
    "Sine": "models.drives",
    "SineSquared": "models.drives",
    "Sines": "models.drives",
    "Steps": "models.drives",
    "StrainEnergy": "models.strain_energy",
    "WLF": "models.shifts",
    "Zener": "models.viscous",
    "backbone": "studies.backbone",
    "basins": "studies.basins",
    "bifurcation_diagram": "studies.bifurcation",
    "classify": "studies.classify",
    "continue_orbit": "studies.branches",
    "continue_special": "studies.special",
    "crossings": "studies.crossings",
    "cycle_losses": "studies.losses",
    "design": "studies.design",
    "energy_balance": "studies.balance",
    "equilibria": "studies.equilibria",
    "fit": "studies.fit",
    "frequency_response": "studies.response",
    "logarithmic_decrement": "studies.decrement",
    "lyapunov": "studies.lyapunov",
    "manifold_crossing": "studies.separatrix",
    "measurements": "results.measured",
    "periodic_orbits": "studies.orbits",
    "poincare_section": "studies.section",
    "regime_chart": "studies.chart",
    "rescale": "results.rescale",
    "resonances": "studies.resonances",
    "response_diagram": "studies.branches",
    "sensitivity": "studies.sensitivity",
    "shape_command": "studies.command",
    "shaped_steps": "studies.command",
    "simulate": "studies.simulate",
    "snap_through": "studies.snap",
    "special_point": "studies.locate",
    "step_response": "studies.step_response",
    "switch_branch": "studies.switch",
    "symmetry_check": "studies.symmetry",
    "to_si": "results.si",
    "uncertainty": "studies.uncertainty",
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

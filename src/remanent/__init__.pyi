# The public names, by family, and where each is defined.  This is the only list of them: at
# run time the package reads it and imports a name when it is first used.

from . import plots as plots
from ._errors import (
    InputError as InputError,
    InputWarning as InputWarning,
    RemanentError as RemanentError,
)
from ._status import Status as Status

# A system and its parts.
from .models.actuator import Actuator as Actuator
from .models.dissipation import KelvinVoigt as KelvinVoigt, Rayleigh as Rayleigh, Zener as Zener
from .models.heat import Heat as Heat
from .models.magnet import Magnet as Magnet
from .models.materials.named import (
    ArrudaBoyce as ArrudaBoyce,
    Gent as Gent,
    MooneyRivlin as MooneyRivlin,
    NeoHookean as NeoHookean,
    Ogden as Ogden,
)
from .models.materials.strain_energy import StrainEnergy as StrainEnergy
from .models.temperature_shift import WLF as WLF, Arrhenius as Arrhenius
from .derivation.readable import equations as equations

# Drives.
from .models.drives.chirp import Chirp as Chirp
from .models.drives.piecewise import Ramp as Ramp, Sampled as Sampled, Steps as Steps
from .models.drives.sines import Sines as Sines
from .models.drives.waves import Constant as Constant, Sine as Sine, SineSquared as SineSquared

# One motion.
from .studies.motion.crossings import crossings as crossings
from .studies.motion.cycle_losses import cycle_losses as cycle_losses
from .studies.motion.energy_balance import energy_balance as energy_balance
from .studies.motion.poincare_section import poincare_section as poincare_section
from .studies.motion.simulate import simulate as simulate

# Equilibria.
from .studies.statics.equilibria import equilibria as equilibria
from .studies.statics.snap_through import snap_through as snap_through

# Periodic orbits and their branches.
from .studies.orbits.continue_bifurcation import continue_bifurcation as continue_bifurcation
from .studies.orbits.continue_orbit import continue_orbit as continue_orbit
from .studies.orbits.locate_bifurcation import locate_bifurcation as locate_bifurcation
from .studies.orbits.manifold_crossing import manifold_crossing as manifold_crossing
from .studies.orbits.periodic_orbits import periodic_orbits as periodic_orbits
from .studies.orbits.continue_orbit import response_diagram as response_diagram
from .studies.orbits.switch_branch import switch_branch as switch_branch

# Forced response.
from .studies.response.backbone import backbone as backbone
from .studies.response.frequency_response import frequency_response as frequency_response
from .studies.response.resonances import resonances as resonances

# Regimes of motion.
from .studies.regimes.basins import basins as basins
from .studies.regimes.bifurcation_diagram import bifurcation_diagram as bifurcation_diagram
from .studies.regimes.classify import classify as classify
from .studies.regimes.lyapunov import lyapunov as lyapunov
from .studies.regimes.regime_chart import regime_chart as regime_chart
from .studies.regimes.symmetry_check import symmetry_check as symmetry_check

# Commands.
from .studies.control.shape_command import (
    shape_command as shape_command,
    shape_commands as shape_commands,
)
from .studies.control.step_response import step_response as step_response

# From data to parameters, and back.
from .results.read_measurements import read_measurements as read_measurements
from .studies.inference.design import design as design
from .studies.inference.fit import fit as fit
from .studies.inference.logarithmic_decrement import logarithmic_decrement as logarithmic_decrement
from .studies.inference.measure import Measure as Measure
from .studies.inference.sensitivity import sensitivity as sensitivity
from .studies.inference.uncertainty import uncertainty as uncertainty

# Results.
from .results.files import load as load, save as save
from .results.rescale import rescale as rescale
from .results.si import to_si as to_si

plot = plots
__version__: str
__all__: list[str]

# The public names, by family, and where each is defined.  This is the only list of them: at
# run time the package reads it and imports a name when it is first used, and the reference in
# the documentation is made from it, with a heading for each family.

from . import plots as plots

# Family: The actuator
from .models.actuator import Actuator as Actuator
from .derivation.readable import equations as equations

# Family: One's own system
from .models.own_systems.lagrangian_system import LagrangianSystem as LagrangianSystem
from .models.own_systems.first_order_system import FirstOrderSystem as FirstOrderSystem

# Family: Materials and the magnet
from .models.materials.named import NeoHookean as NeoHookean
from .models.materials.named import Gent as Gent
from .models.materials.named import MooneyRivlin as MooneyRivlin
from .models.materials.named import Ogden as Ogden
from .models.materials.named import ArrudaBoyce as ArrudaBoyce
from .models.materials.yeoh import Yeoh as Yeoh
from .models.materials.strain_energy import StrainEnergy as StrainEnergy
from .models.magnet import Magnet as Magnet

# Family: Dissipation and heat
from .models.dissipation import Rayleigh as Rayleigh
from .models.dissipation import KelvinVoigt as KelvinVoigt
from .models.dissipation import Zener as Zener
from .models.temperature_shift import WLF as WLF
from .models.temperature_shift import Arrhenius as Arrhenius
from .models.heat import Heat as Heat

# Family: Drives
from .models.drives.waves import Constant as Constant
from .models.drives.waves import SineSquared as SineSquared
from .models.drives.waves import Sine as Sine
from .models.drives.sines import Sines as Sines
from .models.drives.loads import Loads as Loads
from .models.drives.piecewise import Steps as Steps
from .models.drives.piecewise import Ramp as Ramp
from .models.drives.chirp import Chirp as Chirp
from .models.drives.piecewise import Sampled as Sampled

# Family: Motion
from .studies.motion.simulate import simulate as simulate
from .studies.motion.rates import rates as rates
from .studies.motion.poincare_section import poincare_section as poincare_section
from .studies.motion.crossings import crossings as crossings
from .studies.motion.energy_balance import energy_balance as energy_balance
from .studies.motion.cycle_losses import cycle_losses as cycle_losses

# Family: Forced response
from .studies.response.frequency_response import frequency_response as frequency_response
from .studies.response.resonances import resonances as resonances
from .studies.response.backbone import backbone as backbone

# Family: Periodic orbits and bifurcations
from .studies.orbits.periodic_orbits import periodic_orbits as periodic_orbits
from .studies.orbits.period_map import period_map as period_map
from .studies.orbits.continue_orbit import continue_orbit as continue_orbit
from .studies.orbits.response_diagram import response_diagram as response_diagram
from .studies.orbits.switch_branch import switch_branch as switch_branch
from .studies.orbits.locate_bifurcation import locate_bifurcation as locate_bifurcation
from .studies.orbits.continue_bifurcation import continue_bifurcation as continue_bifurcation
from .studies.orbits.manifold_crossing import manifold_crossing as manifold_crossing

# Family: Regimes
from .studies.regimes.classify import classify as classify
from .studies.regimes.regime_chart import regime_chart as regime_chart
from .studies.regimes.lyapunov import lyapunov as lyapunov
from .studies.regimes.basins import basins as basins
from .studies.regimes.bifurcation_diagram import bifurcation_diagram as bifurcation_diagram
from .studies.regimes.symmetry_check import symmetry_check as symmetry_check

# Family: Equilibria
from .studies.statics.equilibria import equilibria as equilibria
from .studies.statics.snap_through import snap_through as snap_through

# Family: Commands
from .studies.control.shape_command import shape_command as shape_command
from .studies.control.shape_command import shape_commands as shape_commands
from .studies.control.step_response import step_response as step_response

# Family: From data to parameters, and back
from .results.read_measurements import read_measurements as read_measurements
from .studies.inference.fit import fit as fit
from .studies.inference.logarithmic_decrement import logarithmic_decrement as logarithmic_decrement
from .studies.inference.measure import Measure as Measure
from .studies.inference.sensitivity import sensitivity as sensitivity
from .studies.inference.design import design as design
from .studies.inference.uncertainty import uncertainty as uncertainty

# Family: Studies
from .studies.sweep.sweep import sweep as sweep

# Family: Other tools
from .studies.export.export import export as export

# Family: Results and units
from .results.si import to_si as to_si
from .results.rescale import rescale as rescale
from .results.provenance import read_system as read_system
from .results.provenance import read_drive as read_drive
from .results.files import save as save
from .results.files import load as load

# Family: Status codes
from ._status import Status as Status

# Family: Exceptions
from ._errors import RemanentError as RemanentError
from ._errors import InputError as InputError
from ._errors import InputWarning as InputWarning

plot = plots
__version__: str
__all__: list[str]

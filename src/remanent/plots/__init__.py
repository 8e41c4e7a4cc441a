"""Pictures of results: a dataset in, Matplotlib artists out; nothing is computed here."""

from remanent.plots import balances as _balances
from remanent.plots import bars as _bars
from remanent.plots import basins as _basins
from remanent.plots import branches as _branches
from remanent.plots import curves as _curves
from remanent.plots import energy as _energy
from remanent.plots import equilibria as _equilibria
from remanent.plots import fits as _fits
from remanent.plots import forced as _forced
from remanent.plots import maps as _maps
from remanent.plots import motion as _motion
from remanent.plots import overview as _overview
from remanent.plots import peaks as _peaks
from remanent.plots import steps as _steps
from remanent.plots.checks import checked_picture as _checked

# Pictures that need certain variables are told which functions return them.
bars = _checked(_bars.bars)
basins = _checked(_basins.basins)
branch = _checked(_branches.branch, ("continue_orbit", "response_diagram"))
curve = _checked(_curves.curve)
energy_balance = _checked(_balances.energy_balance, ("energy_balance",))
equilibria = _checked(_equilibria.equilibria, ("equilibria",))
fit = _checked(_fits.fit)
history = _checked(_motion.history, ("simulate",))
landscape = _checked(_energy.landscape, ("equilibria",))
map = _checked(_maps.map)
multipliers = _checked(_branches.multipliers, ("continue_orbit", "response_diagram"))
overview = _checked(_overview.overview)
phase = _checked(_motion.phase, ("simulate",))
resonances = _checked(_peaks.resonances, ("resonances",))
response = _checked(_forced.response, ("frequency_response",))
section = _checked(_motion.section, ("poincare_section",))
step_response = _checked(_steps.step_response, ("simulate",))

__all__ = [
    "bars",
    "basins",
    "branch",
    "curve",
    "energy_balance",
    "equilibria",
    "fit",
    "history",
    "landscape",
    "map",
    "multipliers",
    "overview",
    "phase",
    "resonances",
    "response",
    "section",
    "step_response",
]

"""Pictures of results: a dataset in, Matplotlib artists out; nothing is computed here."""

from remanent.plots.bars import bars
from remanent.plots.basins import basins
from remanent.plots.branches import branch, multipliers
from remanent.plots.curves import curve
from remanent.plots.energy import landscape
from remanent.plots.equilibria import equilibria
from remanent.plots.fits import fit
from remanent.plots.forced import response
from remanent.plots.maps import map
from remanent.plots.motion import history, phase, section

__all__ = [
    "bars",
    "basins",
    "branch",
    "curve",
    "equilibria",
    "fit",
    "history",
    "landscape",
    "map",
    "multipliers",
    "phase",
    "response",
    "section",
]

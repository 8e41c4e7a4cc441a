"""Every picture of the report by name, and which data it is drawn from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Final

import xarray as xr
from matplotlib.figure import Figure

from remanent.plots import style
from remanent.report import dynamics_figures, evidence_figures, figures
from remanent.report.dynamics import JUMP_CASE
from remanent.report.evidence import SECTION_PERIODS
from remanent.report.settings import PRESTRESSES

#: Results by name.
Datasets = Mapping[str, xr.Dataset]


@dataclass(frozen=True)
class Drawing:
    """How a picture is drawn, and the names of the Datasets it needs."""

    draw: Callable[[Datasets], Figure]
    needs: tuple[str, ...]


def _driven(row: int) -> Drawing:
    """Figure 5 or 6, by the row of the prestress."""

    def drawn(data: Datasets) -> Figure:
        at = {"prestress": PRESTRESSES[row]}
        section = data["sections"].sel(at).isel(period=slice(0, SECTION_PERIODS + 1))
        return figures.figure_5_or_6(data["periodic_load"].sel(at), section)

    return Drawing(drawn, ("periodic_load", "sections"))


def _single(function: Callable[[xr.Dataset], Figure], name: str) -> Drawing:
    """A picture of one Dataset."""
    return Drawing(lambda data: function(data[name]), (name,))


#: Pictures by name, those that take longest first.
DRAWINGS: Final[Mapping[str, Drawing]] = MappingProxyType(
    {
        "tolerance": Drawing(
            lambda data: evidence_figures.tolerance_story(
                data["tolerance_sections"], data["tolerance_energy"]
            ),
            ("tolerance_sections", "tolerance_energy"),
        ),
        "figure_5": _driven(0),
        "figure_6": _driven(1),
        "orbits": Drawing(
            lambda data: dynamics_figures.resonance_orbits(
                data["branches"], data["frequency_response"], data["resonance_orbits"]
            ),
            ("branches", "frequency_response", "resonance_orbits"),
        ),
        "jump": Drawing(
            lambda data: dynamics_figures.jump_at_resonance(
                data["branches"].sel(JUMP_CASE),
                data["jump_response"],
                data["jump_sections"],
                data["jump"],
            ),
            ("branches", "jump_response", "jump_sections", "jump"),
        ),
        "chaos": Drawing(
            lambda data: dynamics_figures.chaos(data["chart"], data["chart_cases"]),
            ("chart", "chart_cases"),
        ),
        "valley": _single(evidence_figures.valley, "valley_windows"),
        "laws": _single(evidence_figures.valley, "valley_laws"),
        "figure_3": _single(figures.figure_3, "constant_load"),
        "figure_4": _single(figures.figure_4, "frequency_response"),
        "landscapes": _single(evidence_figures.landscapes, "landscape"),
        "figure_2": _single(figures.figure_2, "constant_load"),
    }
)


def draw(name: str, data: Datasets) -> dict[str, bytes]:
    """Draw a picture; return its files by suffix, as vectors and as points."""
    figure = DRAWINGS[name].draw(data)
    with TemporaryDirectory() as folder:
        vectors = style.save(figure, Path(folder) / "picture.svg").read_bytes()
        figure.set_layout_engine("none")  # it has done its work
        points = style.save(figure, Path(folder) / "picture.png").read_bytes()
    return {".svg": vectors, ".png": points}

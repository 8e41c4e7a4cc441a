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
from remanent.report.evidence import SECTION_DRIVE_PERIODS
from remanent.report.settings import PRESTRESSES

#: Results by name.
DatasetsByName = Mapping[str, xr.Dataset]


@dataclass(frozen=True)
class Drawing:
    """How a picture is drawn, and the names of the Datasets it needs."""

    draw: Callable[[DatasetsByName], Figure]
    dataset_names: tuple[str, ...]


def _figure_5_or_6_drawing(row: int) -> Drawing:
    """Figure 5 or 6, by the row of the prestress."""

    def drawn(data: DatasetsByName) -> Figure:
        at = {"prestress": PRESTRESSES[row]}
        section = data["sections"].sel(at).isel(period=slice(0, SECTION_DRIVE_PERIODS + 1))
        return figures.draw_figure_5_or_6(data["periodic_load"].sel(at), section)

    return Drawing(drawn, ("periodic_load", "sections"))


def _one_dataset_drawing(function: Callable[[xr.Dataset], Figure], name: str) -> Drawing:
    """A picture of one Dataset."""
    return Drawing(lambda data: function(data[name]), (name,))


#: Pictures by name, those that take longest first.
DRAWINGS: Final[Mapping[str, Drawing]] = MappingProxyType(
    {
        "tolerance": Drawing(
            lambda data: evidence_figures.draw_solver_comparison(
                data["tolerance_sections"], data["tolerance_energy"]
            ),
            ("tolerance_sections", "tolerance_energy"),
        ),
        "figure_5": _figure_5_or_6_drawing(0),
        "figure_6": _figure_5_or_6_drawing(1),
        "orbits": Drawing(
            lambda data: dynamics_figures.draw_response_branches(
                data["branches"], data["frequency_response"], data["resonance_orbits"]
            ),
            ("branches", "frequency_response", "resonance_orbits"),
        ),
        "jump": Drawing(
            lambda data: dynamics_figures.draw_jump_at_resonance(
                data["branches"].sel(JUMP_CASE),
                data["jump_response"],
                data["jump_sections"],
                data["jump"],
            ),
            ("branches", "jump_response", "jump_sections", "jump"),
        ),
        "chaos": Drawing(
            lambda data: dynamics_figures.draw_chaos_map(data["chart"], data["chart_cases"]),
            ("chart", "chart_cases"),
        ),
        "valley": _one_dataset_drawing(evidence_figures.draw_misfit_maps, "valley_windows"),
        "laws": _one_dataset_drawing(evidence_figures.draw_misfit_maps, "valley_laws"),
        "figure_3": _one_dataset_drawing(figures.draw_figure_3, "constant_load"),
        "figure_4": _one_dataset_drawing(figures.draw_figure_4, "frequency_response"),
        "landscapes": _one_dataset_drawing(evidence_figures.draw_landscapes, "landscape"),
        "figure_2": _one_dataset_drawing(figures.draw_figure_2, "constant_load"),
    }
)


def draw_files(name: str, data: DatasetsByName) -> dict[str, bytes]:
    """Draw a picture; return its files by suffix, as vectors and as points."""
    figure = DRAWINGS[name].draw(data)
    with TemporaryDirectory() as folder:
        vectors = style.save_figure(figure, Path(folder) / "picture.svg").read_bytes()
        figure.set_layout_engine("none")  # it has done its work
        points = style.save_figure(figure, Path(folder) / "picture.png").read_bytes()
    return {".svg": vectors, ".png": points}

"""Laws of saved pictures: TrueType fonts and fine pixels, whichever call saves them."""

from __future__ import annotations

import io
import re
import zlib
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

import remanent as rm
from remanent import plots
from remanent.plots import style
from tests.unit.plots import synthetic


def pdf_text(data: bytes) -> bytes:
    """A PDF with its compressed streams unpacked."""
    parts = [data]
    for packed in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", data, re.DOTALL):
        try:
            parts.append(zlib.decompress(packed))
        except zlib.error:
            continue
    return b"\n".join(parts)


def saved(figure: Figure, kind: str) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind)
    return buffer.getvalue()


def test_pyplot_saves_truetype_fonts() -> None:
    """As the tutorial does it: no Type 3 font in the file, and the defaults are untouched."""
    before = mpl.rcParams["pdf.fonttype"]
    plots.history(synthetic.constant(6.0, 61).isel(prestress=0))
    buffer = io.BytesIO()
    plt.savefig(buffer, format="pdf")
    text = pdf_text(buffer.getvalue())
    assert b"/TrueType" in text or b"/CIDFontType2" in text
    assert b"/Type3" not in text
    assert mpl.rcParams["pdf.fonttype"] == before


def test_figures_for_several_plots_save_so_too() -> None:
    """A figure by ``style.subplots`` carries the style, also outside of its context."""
    figure, (left, right) = style.subplots(1, 2, figsize=(7.0, 2.5))
    dataset = synthetic.constant(6.0, 61).isel(prestress=0)
    plots.history(dataset, ax=left)
    plots.phase(dataset, ax=right, legend=False)
    assert b"/Type3" not in pdf_text(saved(figure, "pdf"))
    assert left.xaxis.label.get_fontname() == "STIXGeneral"


def test_pixels_are_fine(tmp_path: Path) -> None:
    """300 dots an inch in PNG, unless another number is asked for."""
    axes = plots.section(synthetic.sections(0.0, 1.25, 12))[0].axes
    assert axes is not None
    figure = axes.get_figure(root=True)
    assert figure is not None
    wide = figure.get_figwidth()
    figure.savefig(tmp_path / "usual.png")
    figure.savefig(tmp_path / "coarse.png", dpi=50)
    for name, dots in (("usual.png", 300), ("coarse.png", 50)):
        assert plt.imread(tmp_path / name).shape[1] == int(wide * dots)


@pytest.mark.parametrize("by_pyplot", [True, False])
def test_charts_in_a_pdf_have_600_dots_an_inch(by_pyplot: bool, tmp_path: Path) -> None:
    """The image of the cells has at least 600 columns for each inch of its axes."""
    axes = plots.map(synthetic.regimes()).axes
    assert axes is not None
    figure = axes.get_figure(root=True)
    assert figure is not None
    path = tmp_path / "chart.pdf"
    if by_pyplot:
        plt.savefig(path)
    else:
        style.save_figure(figure, path)
    columns = [int(n) for n in re.findall(rb"/Width (\d+)", pdf_text(path.read_bytes()))]
    inches = axes.get_position().width * figure.get_figwidth()
    assert max(columns) >= 0.99 * 600 * inches


def test_a_section_of_some_hundred_points_is_no_bitmap() -> None:
    """600 points stay vectors in a PDF."""
    dataset = synthetic.sections(0.0, 1.25, 12).isel(period=np.arange(600) % 13)
    axes = plots.section(dataset)[0].axes
    assert axes is not None
    figure = axes.get_figure(root=True)
    assert figure is not None
    assert b"/Subtype /Image" not in pdf_text(saved(figure, "pdf"))


def test_files_say_what_made_them_whether_the_picture_does_or_not() -> None:
    """Without a footer no line stands below the axes; the metadata have its text anyway."""
    dataset = synthetic.constant(6.0, 61).isel(prestress=0)
    for shown in (True, False):
        axes = plots.history(dataset, footer=shown)[0].axes
        assert axes is not None
        figure = axes.get_figure(root=True)
        assert figure is not None
        below = [text.get_text() for text in figure.texts]
        assert any("tolerance" in text for text in below) == shown
        assert b"remanent 0" in saved(figure, "png")
        assert "remanent 0" in saved(figure, "svg").decode()
        assert b"/Subject" in pdf_text(saved(figure, "pdf"))


def test_no_measured_point_is_covered_by_the_curve() -> None:
    """Points lie above what was fitted to them, in whatever style."""
    table = {"time": np.linspace(0.0, 5.0, 21)}
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    run = rm.simulate(body, rm.Constant(0.1), times=table["time"])
    table["thickness_stretch"] = run.thickness_stretch.values
    points, curve = plots.fit(
        rm.fit(body, rm.Constant(0.1), table, {"dissipation.0.eta": 0.12}), footer=False
    )
    assert points.get_zorder() > curve.get_zorder()

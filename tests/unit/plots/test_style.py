"""Laws of the house style."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent import plots
from remanent.plots import footer, style
from remanent.results import provenance
from tests.unit.plots import synthetic


def luminance(colour: tuple[float, ...]) -> float:
    """Relative luminance of sRGB (WCAG 2.1)."""
    rgb = np.array(colour[:3])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ np.array([0.2126, 0.7152, 0.0722]))


@pytest.mark.parametrize(
    "temperatures", [(250, 350, 400), (290, 300, 310), (100, 293, 600), tuple(range(240, 411, 10))]
)
def test_hotter_is_lighter(temperatures: tuple[float, ...]) -> None:
    """Lightness rises strictly with temperature, so grey prints keep the order."""
    found = [luminance(colour) for colour in style.temperature_colours(temperatures)]
    assert (np.diff(found) > 0).all()


def test_the_lightest_colour_can_be_read_on_white() -> None:
    """Every colour of a line has a contrast of at least 2 with white paper."""
    colours = [*style.temperature_colours([240.0, 410.0])]
    colours += [mpl.colors.to_rgba(colour) for colour in style.OKABE_ITO_COLOURS.values()]
    for colour in colours:
        assert 1.05 / (luminance(colour) + 0.05) >= 2.0, colour


def test_a_colour_means_a_temperature() -> None:
    """350 K looks the same alone, and among the published three."""
    (alone,) = style.temperature_colours([350.0])
    assert alone == style.temperature_colours([250.0, 350.0, 400.0])[1]


def test_order_does_not_matter() -> None:
    """Colours follow values, not places."""
    forward = style.temperature_colours([250.0, 350.0, 400.0])
    assert style.temperature_colours([400.0, 350.0, 250.0]) == forward[::-1]


def test_importing_plots_changes_nothing_and_needs_no_pyplot() -> None:
    """Importing costs no pyplot and leaves every default alone."""
    code = (
        "import sys, matplotlib; before = dict(matplotlib.rcParams); import remanent.plots; "
        "assert dict(matplotlib.rcParams) == before; assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_equal_figures_give_equal_files(suffix: str, tmp_path: Path) -> None:
    """No date and no random name enters a picture."""
    files = []
    for name in ("first", "second"):
        axes = plots.history(synthetic.constant(6.0, 61).isel(prestress=0))[0].axes
        assert axes is not None
        figure = axes.get_figure(root=True)
        assert figure is not None
        files.append(style.save_figure(figure, tmp_path / (name + suffix)).read_bytes())
    assert files[0] == files[1]


@pytest.mark.parametrize(
    ("units", "expected"),
    [
        ("1", "speed, $v$"),
        ("rad", "speed, $v$"),
        ("mT", "speed, $v$ (mT)"),
        ("s-1", "speed, $v$ (s$^{-1}$)"),
        ("kJ m-3", "speed, $v$ (kJ m$^{-3}$)"),
    ],
)
def test_labels_say_units(units: str, expected: str) -> None:
    """Dimensionless quantities have no unit on the axis; powers are raised."""
    array = xr.Variable((), 0.0, {"units": units, "long_name": "speed", "symbol": "v"})
    assert style.axis_label(array) == expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [(250.0, "250"), (0.16, "0.16"), (1e-9, "10^{-9}"), (2.5e-12, r"2.5\times 10^{-12}")],
)
def test_numbers_are_typeset(value: float, expected: str) -> None:
    """No ``1e-09`` in a figure."""
    assert style.format_number(value) == expected


def test_a_variable_without_a_symbol_is_named_once() -> None:
    """Its symbol is its name then, which the axis need not repeat."""
    attrs = {"long_name": "inner pressure", "symbol": r"\mathrm{inner pressure}", "units": "kPa"}
    assert style.axis_label(xr.Variable((), 0.0, attrs)) == "inner pressure (kPa)"
    named = attrs | {"symbol": "P"}
    assert style.axis_label(xr.Variable((), 0.0, named)) == "inner pressure, $P$ (kPa)"


def test_footer_says_what_the_picture_does_not() -> None:
    """Parameters, drive, settings, tolerance and version; nothing that was varied."""
    found = footer.footer_text(synthetic.frequency_response(7, 10.0))
    for piece in ("$c = 1$", "$T_0 = 293$ K", "NeoHookean", "SineSquared: $b = 0.4$",
                  r"$\tau_w = 10$", "tolerance $10^{-9}$"):  # fmt: skip
        assert piece in found
    for varied in (r"\omega =", "$T =", "$S ="):
        assert varied not in found


def test_footer_shows_the_selected_value() -> None:
    """A value picked out of a sweep is said, not the one the actuator was built with."""
    found = footer.footer_text(synthetic.constant(6.0, 61).sel(prestress=1.0))
    assert "$S = 1$" in found
    assert "$S = 0$" not in found


def test_footer_shows_parts_that_matter() -> None:
    """A part with values of its own is named with them; a neutral one is not."""
    actuator = rm.Actuator(
        c=0.01, material=rm.Gent(30.0, 0.9), dissipation=(rm.Rayleigh(0.1), rm.Rayleigh(0.2))
    )
    found = footer.footer_text(
        xr.Dataset(attrs=provenance.attributes(actuator, rm.Constant(0.1), None))
    )
    assert "Gent ($J_m = 30$, $f = 0.9$)" in found
    assert r"Rayleigh ($\eta_{0} = 0.1$)" in found
    assert r"Rayleigh ($\eta_{1} = 0.2$)" in found
    assert "Magnet" not in found


def test_footer_survives_anything() -> None:
    """What is no plain data is written as it is, and never run; nothing has to be there."""
    attrs = {"system": "not JSON", "system_text": "x = [1, 2]", "drive_text": "lambda $ m"}
    found = footer.footer_text(xr.Dataset(attrs=attrs))
    assert "x = [1, 2]" in found
    assert r"\$" in found
    assert footer.footer_text(xr.Dataset()) == ""
    assert footer.footer_text(xr.Dataset(attrs={"settings": "duration", "system": "[1]"})) == ""


def test_footer_hides_what_was_varied_on_the_way() -> None:
    """A result distilled from a sweep does not show one value of what was swept."""
    dataset = synthetic.valley()
    found = footer.footer_text(dataset, hide=("drive", "temperature"))
    assert "SineSquared" in footer.footer_text(dataset)
    assert "SineSquared" not in found
    assert "$T = " not in found


def test_footer_fits_the_figure() -> None:
    """Long footers break into lines no wider than the figure."""
    axes = plots.section(synthetic.sections(0.0, 1.25, 12))[0].axes
    assert axes is not None
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    written = figure.findobj(lambda a: getattr(a, "get_text", str)() == figure.get_supxlabel())
    assert written
    assert all(one.get_window_extent().x1 <= figure.bbox.x1 for one in written)

"""The pictures of the pages under explanation: ``python docs/make_explanations.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import remanent as rm

#: Where the pictures are written.
STATIC = Path(__file__).parent / "_static"
#: Colours of Okabe and Ito, blue first.
OKABE_ITO_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")


def two_directions() -> Any:
    """Draw the growth of the difference of the stretches over frequency and load."""
    omega, b = np.linspace(0.5, 2.7, 133), np.linspace(0.1, 1.3, 73)
    ds = rm.symmetry_check(
        rm.Actuator(),
        rm.SineSquared(0.4, 1.0),
        periods=150,
        over={"b": b, "omega": omega},
        tolerance=1e-8,
    )
    figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
    growth = ds.transverse_exponent.where(ds.symmetry != "kept", 0.0)
    drawn = axes.pcolormesh(
        omega, b, growth.clip(0.0), cmap="magma_r", shading="nearest", rasterized=True
    )
    figure.colorbar(drawn, label=r"exponent of $\lambda_1 - \lambda_2$ per unit of $\tau$")
    # Small oscillations of the difference have the natural frequency sqrt(6 θ), whatever c; the
    # load oscillates at 2 omega, so parametric resonance starts from these two.
    for frequency in (6.0**0.5, 0.5 * 6.0**0.5):
        axes.axvline(frequency, color="0.3", linestyle="--", linewidth=0.8)
    axes.set(xlabel=r"drive frequency $\omega$", ylabel=r"root of the peak load $b$")
    note(figure, r"$c = 1$, $S = 0$, $\theta = 1$; from rest, 150 periods of the load")
    return figure


def viscosity() -> Any:
    """Draw responses for several relaxation times, and the energy lost in a period."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.4), layout="constrained")
    omega = np.linspace(0.6, 2.0, 141)
    styles = ("-", "--", "-.", ":")
    for relaxation_time, colour, style in zip(
        (0.03, 0.3, 1.0, 10.0), OKABE_ITO_COLOURS, styles, strict=False
    ):
        body = rm.Actuator(dissipation=rm.Zener(0.5, relaxation_time))
        ds = rm.frequency_response(
            body, rm.SineSquared(0.6, 1.0), omega, duration=400.0, discard=280.0, tolerance=1e-7
        )
        left.plot(omega, ds.amplitude, style, color=colour, label=rf"$t_r = {relaxation_time:g}$")
    left.set(xlabel=r"drive frequency $\omega$", ylabel=r"amplitude $\lambda_3^a$")
    left.legend(frameon=False)
    times = np.geomspace(0.02, 20.0, 41)
    for w, colour, style in zip((0.8, 1.25, 1.8), OKABE_ITO_COLOURS, styles, strict=False):
        ds = rm.cycle_losses(
            rm.Actuator(dissipation=rm.Zener(0.5, 1.0)),
            rm.SineSquared(0.6, w),
            periods=150,
            discard=149,
            over={"dissipation.0.relaxation_time": times},
            tolerance=1e-7,
        )
        right.loglog(
            times, ds.dissipated_energy[:, 0], style, color=colour, label=rf"$\omega = {w:g}$"
        )
    right.set(xlabel=r"relaxation time $t_r$", ylabel=r"loss in a period of the load, over $\mu$")
    right.legend(frameon=False)
    note(figure, r"$b = 0.6$, $\mu_v/\mu = 0.5$, $c = 1$, $S = 0$; settled motion")
    return figure


def heat() -> Any:
    """Draw the temperature of a body that its own damping warms, and its thermoelastic part."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.4), layout="constrained")
    drive, styles = rm.SineSquared(0.8, 1.35), ("-", "--", "-.")
    for exchange, colour, style in zip((0.0, 0.005, 0.05), OKABE_ITO_COLOURS, styles, strict=False):
        body = rm.Actuator(dissipation=rm.Zener(0.5, 0.5), heat=rm.Heat(2e-4, exchange))
        ds = rm.simulate(body, drive, times=np.linspace(0.0, 250.0, 5001), tolerance=1e-8)
        warmth = ds.body_temperature - 293.0
        left.plot(
            ds.time, warmth, style, color=colour, linewidth=0.9, label=f"exchange {exchange:g}"
        )
    late = ds.isel(time=ds.time > 250.0 - 2.0 * drive.period)
    x = late.thickness_stretch.values
    right.plot(
        x, late.body_temperature - 293.0, style, color=colour, label=f"exchange {exchange:g}"
    )
    grid = np.linspace(x.min(), x.max(), 201)
    energy = (2.0 / grid + grid**2 - 3.0) / 2.0
    lowest = float(late.body_temperature.min())
    adiabat = lowest * np.exp(2e-4 * energy)
    right.plot(grid, adiabat - 293.0, color="0.5", linewidth=0.9, label="adiabat")
    left.set(xlabel=r"time $\tau$", ylabel=r"$T - T_\infty$ in K")
    right.set(xlabel=r"thickness stretch $\lambda_3$", ylabel=r"$T - T_\infty$ in K")
    left.legend(frameon=False)
    right.legend(frameon=False)
    note(figure, r"$b = 0.8$, $\omega = 1.35$, $\mu_v/\mu = 0.5$, $t_r = 0.5$, $k = 2\cdot10^{-4}$")
    return figure


def note(figure: Any, text: str) -> None:
    """Write parameters and the version under the picture."""
    figure.supxlabel(
        f"{text}   remanent {rm.__version__}", x=0.01, ha="left", fontsize=6, color="0.4"
    )


if __name__ == "__main__":
    pictures = {"two-directions": two_directions, "viscosity": viscosity, "heat": heat}
    for name, draw in pictures.items():
        draw().savefig(STATIC / f"{name}.png", dpi=160)

"""The pictures and tables of the pages under explanation.

``python docs/make_explanations.py`` makes all of them, and with names after it those alone.
``python docs/make_explanations.py article paper/report.json`` takes what ``remanent paper`` wrote.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from breathing import breathing_frequencies
from scipy.integrate import solve_ivp
from small_pictures import save_picture

import remanent as rm

#: Where the pictures are written.
STATIC = Path(__file__).parent / "_static"
#: Their resolution.
RESOLUTION_DPI = 200
#: Where the tables are written, which pages include.
TABLES = Path(__file__).parent / "results"
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
    growth = ds.transverse_exponent.where(ds.symmetry != "kept")
    drawn = axes.pcolormesh(
        omega, b, growth.clip(0.0), cmap="cividis", shading="nearest", rasterized=True
    )
    figure.colorbar(drawn, label=r"exponent of $\lambda_1 - \lambda_2$ (per unit of $\tau$)")
    # Small oscillations of the difference have the natural frequency sqrt(6 θ), whatever c; the
    # load oscillates at 2 omega, so parametric resonance starts from these two.
    for frequency in (6.0**0.5, 0.5 * 6.0**0.5):
        axes.axvline(frequency, color="0.5", linestyle="--", linewidth=0.8)
    axes.set(xlabel=r"drive frequency, $\omega$", ylabel=r"root of the peak magnetic load, $b$")
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
    left.set(
        xlabel=r"drive frequency, $\omega$", ylabel=r"thickness stretch amplitude, $\lambda_3^a$"
    )
    left.legend()
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
    right.set(xlabel=r"relaxation time, $t_r$", ylabel=r"loss in a period of the load, over $\mu$")
    right.legend()
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
    left.set(xlabel=r"time, $\tau$", ylabel=r"warming, $T - T_\infty$ (K)")
    right.set(xlabel=r"thickness stretch, $\lambda_3$", ylabel=r"warming, $T - T_\infty$ (K)")
    left.legend()
    right.legend()
    note(figure, r"$b = 0.8$, $\omega = 1.35$, $\mu_v/\mu = 0.5$, $t_r = 0.5$, $k = 2\cdot10^{-4}$")
    return figure


def note(figure: Any, text: str) -> None:
    """Write parameters and the version under the picture."""
    figure.supxlabel(
        f"{text}   remanent {rm.__version__}", x=0.01, ha="left", fontsize=6, color="0.4"
    )


def limits() -> Any:
    """Draw the frequency of a block that deforms as it likes beside that of the model."""
    slenderness = np.linspace(0.05, 1.5, 16)
    figure, axes = plt.subplots(figsize=(5.4, 3.6), layout="constrained")
    axes.plot(
        slenderness, [_model_frequency(h) for h in slenderness], color="0.3", label="the model"
    )
    for degree, style, colour in zip((3, 5, 9), (":", "--", "-"), OKABE_ITO_COLOURS, strict=False):
        lowest = [breathing_frequencies(h, degree)[0] for h in slenderness]
        axes.plot(slenderness, lowest, style, color=colour, label=f"polynomials of degree {degree}")
    second = [breathing_frequencies(h, 9)[1] for h in slenderness]
    axes.plot(slenderness, second, "-.", color="0.6", label="the next such motion, degree 9")
    axes.set(xlabel="slenderness, $H/L$", ylabel=r"natural frequency, $\omega_n$", ylim=(0.0, None))
    axes.legend()
    note(figure, r"small free oscillations, no load, $T = T_0$; incompressible, free faces")
    rows = []
    for h in (0.1, 0.5, 1.0):
        model, free = _model_frequency(h), breathing_frequencies(h, 9)[0]
        rows.append((f"{h:g}", f"{model:.4f}", f"{free:.4f}", f"{model / free - 1.0:.1%}"))
    head = ("$H/L$", "the model", "any deformation", "the model is too high by")
    write_table("limits-frequency", head, rows)
    write_table("limits", ("left out", "measured by", "value", "in the package"), neglected())
    return figure


def _model_frequency(slenderness: float) -> float:
    """The natural frequency of the unloaded block."""
    rest = rm.equilibria(rm.Actuator(c=float(slenderness) ** 2), 0.0)
    return float(rest.natural_frequency[0])


def neglected() -> Sequence[Sequence[str]]:
    """How large what the model leaves out is, for the film of the guide on units.

    Numbers of materials are those of silicone rubber with NdFeB, rounded.
    """
    mu, density, half_length, half_thickness = 1e5, 2e3, 5e-3, 0.5e-3
    remanence, vacuum = 0.143, 4e-7 * np.pi
    bulk_modulus, heat_capacity, diffusivity = 1e9, 1.9e3, 1e-7
    conductivity, grain, coercivity, gravity, air = 7e5, 5e-6, 0.9, 9.81, 1.2
    film = rm.Actuator.from_si(
        shear_modulus=f"{mu} Pa", density=f"{density} kg/m^3", half_length=f"{half_length} m",
        half_thickness=f"{half_thickness} m", remanence=f"{remanence} T",
    )  # fmt: skip
    omega = 1.25 / float(film.in_unit(1.0, "s"))  # radians per second
    rows = [
        ("change of volume", r"$\mu/K$", mu / bulk_modulus, ""),
        ("the magnet's own field", r"$B_r^2/(\mu\mu_0)$ over $m$ at 140 mT",
         remanence**2 / (mu * vacuum) / float(film.load("140 mT")), "`own_field=True`"),
        ("loss of remanence", "140 mT over the coercive field", 0.14 / coercivity, ""),
        ("eddy currents in a grain", r"$\mu_0\sigma d^2\omega$",
         vacuum * conductivity * grain**2 * omega, ""),
        ("waves of the field", r"$\omega L/c_0$", omega * half_length / 299792458.0, ""),
        ("heat that motion makes", r"$\mu/(\rho c_p T_0)$",
         mu / (density * heat_capacity * 293.0), "{py:obj}`~remanent.Heat`"),
        ("flow of heat within a period", r"$2\pi D/(\omega H^2)$",
         2.0 * np.pi * diffusivity / (omega * half_thickness**2), ""),
        ("gravity", r"$\rho g L/\mu$", density * gravity * half_length / mu, ""),
        ("air that moves along", r"$\rho_a L/(\rho H)$",
         air * half_length / (density * half_thickness), ""),
    ]  # fmt: skip
    return [(name, by, _rounded(value), where or "–") for name, by, value, where in rows]


def _rounded(value: float) -> str:
    """One or two digits, with a power of ten where the number is small."""
    if value >= 0.01:
        return f"{value:#.2g}"
    digit, _, exponent = f"{value:.0e}".partition("e")
    return rf"${digit}\cdot10^{{{int(exponent)}}}$"


def magnetisation() -> Any:
    """Draw equilibria under both laws of magnetisation, with the magnet's own field and without."""
    loads = np.linspace(-1.0, 1.0, 81)
    shown = (
        ("deformation-gradient", None, "-"), ("deformation-gradient", 0.163, "--"),
        ("rotation", None, "-."), ("rotation", 0.163, ":"),
    )  # fmt: skip
    figure, panels = plt.subplots(1, 2, figsize=(7.4, 3.4), sharey=True, layout="constrained")
    rows = []
    for axes, c, title in zip(
        panels, (0.01, 1.0), ("film, $c = 0.01$", "cube, $c = 1$"), strict=True
    ):
        for (law, own, style), colour in zip(shown, OKABE_ITO_COLOURS, strict=False):
            body = rm.Actuator(c=c, magnet=rm.Magnet(law=law, demagnetisation=own))
            label = law if own is None else f"{law}, own field"
            curve = rm.equilibria(body, over={"m": loads})
            axes.plot(loads, curve.equilibrium_stretch[:, 0], style, color=colour, label=label)
            at = rm.equilibria(body, 0.16)
            values = (at.equilibrium_stretch[0], at.natural_frequency[0])
            rows.append((title, label, *(f"{float(value):.4f}" for value in values)))
        axes.set(xlabel="magnetic load, $m$", title=title)
    panels[0].set_ylabel(r"thickness stretch at equilibrium, $\lambda_3^\mathrm{eq}$")
    panels[1].legend()
    note(figure, r"$S = 0$, $\theta = 1$; own field: $B_r^2/(\mu\mu_0) = 0.163$")
    head = ("block", "law", r"$\lambda_3$ at $m = 0.16$", r"$\omega_n$ there")
    write_table("magnetisation", head, rows)
    return figure


#: Relative tolerances of RK45 for which the story is told, ode45's own first.
RK45_TOLERANCES = (1e-3, 1e-5, 1e-7)


def tolerance() -> Any:
    """Draw a section by RK45 at two tolerances, and converged, and what the energy does."""
    hot, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.25)
    figure, panels = plt.subplots(2, 2, figsize=(6.6, 5.4), layout="constrained")
    converged = rm.poincare_section(hot, drive, periods=1000, every=2, tolerance=1e-8)
    times, rates = converged.period.values * drive.period, rm.rates(hot, drive)
    exact = converged.thickness_stretch.values, converged.thickness_stretch_rate.values
    for axes, relative in zip(panels.flat, (*RK45_TOLERANCES[:2], None), strict=False):
        axes.plot(*exact, ".", color="0.75", markersize=2.5)
        points = exact if relative is None else _as_thickness(*_rk45(rates, times, relative))
        axes.plot(*points, ".", color=OKABE_ITO_COLOURS[0], markersize=1.5)
        title = "converged" if relative is None else f"RK45, relative tolerance {_power(relative)}"
        axes.set(
            xlabel=r"thickness stretch, $\lambda_3$", ylabel=r"rate, $\lambda_3'$", title=title
        )
    write_table(
        "tolerance",
        ("solver", r"energy gained over $\tau = 500$, over that of the oscillation"),
        _draw_drifts(panels[1, 1], hot),
    )
    note(figure, r"$T = 350$ K, $S = 0$; sections $b = 0.4$, $\omega = 1.25$; energy $m = 0.16$")
    return figure


def _power(number: float) -> str:
    """A power of ten as a formula."""
    return rf"$10^{{{np.log10(number):.0f}}}$"


def _draw_drifts(axes: Any, body: rm.Actuator) -> Sequence[Sequence[str]]:
    """Draw how the energy of a free oscillation drifts; return what is left at the end."""
    load, times = rm.Constant(0.16), np.linspace(0.0, 500.0, 1001)
    rest = rm.equilibria(body, load.m)
    depth = float(rest.level) - float(rest.equilibrium_potential[0])
    rows = []
    for relative, style, colour in zip(
        RK45_TOLERANCES, ("-", "--", "-."), OKABE_ITO_COLOURS, strict=False
    ):
        energy = _energy(*_rk45(rm.rates(body, load), times, relative), body, load.m)
        drift = (energy - energy[0]) / depth
        axes.semilogy(times[1:], np.abs(drift[1:]), style, color=colour, label=_power(relative))
        rows.append((f"SciPy's RK45, relative tolerance {relative:g}", f"{drift[-1]:+.1e}"))
    energy = rm.simulate(body, load, times=times, tolerance=1e-8).energy.values
    rows.append(("Remanent, tolerance 1e-08", f"{(energy[-1] - energy[0]) / depth:+.1e}"))
    axes.set(xlabel=r"time, $\tau$", ylabel="share of the energy", title="energy gained or lost")
    axes.legend(title="RK45, relative tolerance")
    return rows


def _as_thickness(x: Any, v: Any) -> tuple[Any, Any]:
    """Thickness stretch and its rate."""
    return x**-2, -2.0 * v * x**-3


def _rk45(rates: Callable[..., Any], times: Any, relative: float) -> Any:
    """Stretch and rate from rest, by the pair of formulas that ode45 uses."""
    solved = solve_ivp(
        rates, (0.0, float(times[-1])), [1.0, 0.0], method="RK45", t_eval=times, rtol=relative,
        atol=1e-3 * relative,
    )  # fmt: skip
    return solved.y


def _energy(x: Any, v: Any, body: rm.Actuator, m: float) -> Any:
    """Kinetic and potential energy of the cube, as on the page about the model."""
    theta = body.temperature / body.reference_temperature
    return (1.0 + 2.0 / x**6) * v**2 / 3.0 + theta * (2.0 * x**2 + x**-4 - 3.0) / 2.0 - m / x**2


def error_bound() -> Any:
    """Draw reported and true errors of one motion over tolerances, and of ten thousand."""
    body, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.25)
    times, asked = np.linspace(0.0, 60.0, 121), np.logspace(-3, -11, 17)
    best = rm.simulate(body, drive, times=times, tolerance=1e-13)
    runs = [rm.simulate(body, drive, times=times, tolerance=float(bound)) for bound in asked]
    true = [
        max(float(abs(run[name] - best[name]).max()) for name in ("stretch", "stretch_rate"))
        for run in runs
    ]
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.4), layout="constrained")
    left.loglog(asked, asked, color="0.6", linewidth=0.9, label="asked")
    left.loglog(asked, [float(r.error) for r in runs], "o", color=OKABE_ITO_COLOURS[0],
                label="reported")  # fmt: skip
    left.loglog(asked, true, "s", color=OKABE_ITO_COLOURS[1], label="true")
    left.set(xlabel=r"tolerance, $\varepsilon$", ylabel="largest error of the state")
    left.legend()
    exponents = np.array(_coverage()["points"], dtype=float)
    right.hist(exponents[:, 1] - exponents[:, 0], bins=60, color=OKABE_ITO_COLOURS[0])
    right.axvline(0.0, color="0.2", linewidth=0.9)
    right.axvline(2.0, color="0.2", linestyle="--", linewidth=0.9)
    right.set(xlabel=r"$\log_{10}$ of reported over true error", ylabel="trajectories")
    note(figure, r"left: $T = 350$ K, $b = 0.4$, $\omega = 1.25$, $\tau \leq 60$")
    (TABLES / "error-bound.md").write_text(coverage_table(), encoding="utf-8")
    return figure


def _coverage() -> Any:
    """What the study of the error bound measured."""
    file = Path(__file__).parents[1] / "benchmarks" / "results" / "coverage.json"
    return json.loads(file.read_text("utf-8"))


def coverage_table() -> str:
    """How many random trajectories are covered, and how closely."""
    total = _coverage()["total"]
    rows = [
        ("met the tolerance to their end", f"{total['ok']:.2%}"),
        ("covered, of these", f"{total['coverage']:.2%}"),
        ("at least, at 95 % confidence", f"{total['coverage_at_least']:.2%}"),
        ("reported over true error, median", f"{total['median_ratio']:.1f}"),
    ]
    return as_table(("random trajectories", f"{total['cases']}"), rows)


def regimes() -> Any:
    """Draw sections of four motions, with the evidence by which they are labelled."""
    hot = rm.Actuator(temperature=350.0)
    damped = hot.replace(dissipation=rm.Rayleigh(0.05))
    cases: Mapping[str, tuple[rm.Actuator, rm.SineSquared, int]] = {
        "damped": (damped, rm.SineSquared(0.4, 1.25), 500),
        "as published": (hot, rm.SineSquared(0.4, 1.25), 500),
        "stronger load": (hot, rm.SineSquared(1.5, 1.1), 500),
        "ten times b": (rm.Actuator(), rm.SineSquared(4.0, 3.0), 2000),
    }
    figure, panels = plt.subplots(2, 2, figsize=(6.6, 5.2), layout="constrained")
    rows = []
    for axes, (name, (body, drive, periods)) in zip(panels.flat, cases.items(), strict=True):
        found = rm.classify(body, drive, periods=periods)
        points = rm.bifurcation_diagram(body, drive, "b", [drive.b], discard=0, keep=periods)
        axes.plot(
            points.thickness_stretch.values[0], points.thickness_stretch_rate.values[0], ".",
            color=OKABE_ITO_COLOURS[0], markersize=1.6, rasterized=True,
        )  # fmt: skip
        title = rf"{name}, $b = {drive.b:g}$, $\omega = {drive.omega:g}$"
        axes.set(
            xlabel=r"thickness stretch, $\lambda_3$", ylabel=r"rate, $\lambda_3'$", title=title
        )
        rows.append(_evidence_row(name, periods, found))
        if found.regime.item() == "undecided":
            longer = rm.classify(body, drive, periods=8 * periods)
            rows.append(_evidence_row(f"{name}, longer", 8 * periods, longer))
    note(figure, "from rest, at phase 0 of every drive period; $S = 0$, $c = 1$")
    head = ("motion", "periods", "regime", "exponent", "digits", "0–1 test", "margin")
    write_table("regimes", head, rows)
    return figure


def _evidence_row(name: str, periods: int, found: Any) -> Sequence[str]:
    """What a label rests on."""
    margin = float(found.margin)
    return (
        name, f"{periods}", f"`{found.regime.item()}`",
        f"{float(found.exponent):+.4f} ± {float(found.exponent_error):.0e}",
        f"{float(found.digits):.1f}", f"{float(found.zero_one):.2f}",
        "–" if np.isnan(margin) else f"{margin:.2f}",
    )  # fmt: skip


#: Verdicts of the audit, in the order in which they are told.
VERDICTS = ("supported", "contradicted", "depends")


def keep_audit(report: Path) -> None:
    """Keep what the audit found as data, and write the tables of the page about the article."""
    summary = json.loads(report.read_text("utf-8"))
    kept = {key: summary[key] for key in ("setting", "resonances", "claims", "jump")}
    text = json.dumps(kept, indent=1, ensure_ascii=False)
    (TABLES / "audit.json").write_text(text + "\n", encoding="utf-8")
    for name, table in audit_tables(kept).items():
        (TABLES / f"{name}.md").write_text(table, encoding="utf-8")


def audit_tables(audit: Mapping[str, Any]) -> dict[str, str]:
    """Lists of claims with their numbers, and a table, by the names of their files."""
    made = {}
    for verdict in VERDICTS:
        entries = (
            f"**{claim['id']}** {claim['claim']}\n: {_plain(claim['evidence'])}\n"
            for claim in audit["claims"]
            if claim["verdict"] == verdict
        )
        made[f"audit-{verdict}"] = "\n".join(entries)
    rows = [
        (f"{r['temperature']:g}", f"{r['prestress']:g}", f"{r['published']:.2f}",
         f"{r['omega']:.4f}", f"{r['difference']:+.4f}")
        for r in audit["resonances"]
    ]  # fmt: skip
    made["audit-resonances"] = as_table(("T, K", "S", "published", "computed", "difference"), rows)
    return made


def _plain(text: str) -> str:
    """Text in which nothing is taken for Markdown."""
    return re.sub(r"([|*_])", r"\\\1", text)


def as_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def write_table(name: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write a table that a page includes."""
    (TABLES / f"{name}.md").write_text(as_table(head, rows), encoding="utf-8")


#: What draws each picture.
PICTURES: Mapping[str, Callable[[], Any]] = {
    "two-directions": two_directions, "viscosity": viscosity, "heat": heat, "limits": limits,
    "magnetisation": magnetisation, "tolerance": tolerance, "error-bound": error_bound,
    "regimes": regimes,
}  # fmt: skip


def main(words: Sequence[str]) -> None:
    """Make the pictures that are named, or all; ``article FILE`` keeps an audit."""
    if words[:1] == ["article"]:
        keep_audit(Path(words[1]))
        return
    for name in words or PICTURES:
        with rm.plot.style.context():
            save_picture(PICTURES[name](), STATIC / f"{name}.png", dpi=RESOLUTION_DPI)


if __name__ == "__main__":
    main(sys.argv[1:])

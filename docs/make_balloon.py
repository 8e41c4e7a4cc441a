"""The pictures of the page on the balloon: ``python docs/make_balloon.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar
from small_pictures import save_picture

import remanent as rm
from remanent.plots import style
from remanent.plots.colours import number_colours

#: Where the pictures are written.
STATIC = Path(__file__).parent / "_static"
#: Their resolution, that of print.
RESOLUTION_DPI = 300
BLUE, ORANGE, GREEN = (style.OKABE_ITO_COLOURS[n] for n in ("blue", "vermillion", "green"))
#: Dashes of what is unstable.
UNSTABLE = (0, (4, 1.6))
FAINT, INK = "0.55", style.INK_COLOUR

BALLOON = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - load**2*stretch**4/2",
    dissipation="damping*stretch_rate**2/2",
    parameters={"pressure": 0.5, "damping": 0.02},
    rest={"stretch": 1.0},
)
FREE = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - load**2*stretch**4/2",
    parameters={"pressure": 0.5},
    rest={"stretch": 1.0},
)
VISCOUS = rm.LagrangianSystem(
    coordinates=("stretch", "viscous_stretch"),
    kinetic="stretch_rate**2/2",
    potential="stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - load**2*stretch**4/2"
    " + modulus*(2*stretch**2/viscous_stretch**2 + viscous_stretch**4/stretch**4 - 3)/2",
    dissipation="6*modulus*relaxation_time*viscous_stretch_rate**2/viscous_stretch**2",
    parameters={"pressure": 0.5, "modulus": 0.5, "relaxation_time": 40.0},
    rest={"stretch": 1.0, "viscous_stretch": 1.0},
)
STATE_BOX = {"stretch": (0.6, 2.2), "stretch_rate": (-3.0, 3.0)}
#: The static voltage of forced motions.
VOLTAGE = 0.3
#: What a relaxed balloon holds without voltage.
LARGEST_PRESSURE = 12.0 / 7.0 ** (7.0 / 6.0)
#: What an elastic one holds that feels it all at once: the largest of 3 W(l)/(l^3 - 1).
STEP_PRESSURE = -float(
    minimize_scalar(
        lambda x: -3.0 * (x**2 + x**-4 / 2.0 - 1.5) / (x**3 - 1.0),
        bounds=(1.5, 2.0), method="bounded", options={"xatol": 1e-10},
    ).fun
)  # fmt: skip


def statics() -> Any:
    """Draw equilibria against pressure and voltage, and the natural frequency."""
    figure, axes = style.subplots(1, 3, figsize=(7.2, 2.75))
    with style.context():
        shades = number_colours(range(4))
        # Denser where the fold is near, at which the frequency vanishes as a root.
        shares = 1.0 - np.linspace(1.0, 0.02, 80) ** 4
        for voltage, shade in zip((0.0, 0.2, 0.4, 0.6), shades, strict=True):
            fold = 7.0 ** (1.0 / 6.0)
            if voltage:
                fold = brentq(lambda x, v=voltage: 7.0 / x**8 - x**-2 - v**2, 1.2, 1.4)
            largest = 4.0 / fold - 16.0 / fold**7
            pressure = largest * shares
            found = rm.equilibria(
                BALLOON, voltage, state_box={"stretch": (0.9, 12.0)}, over={"pressure": pressure}
            )
            name = f"$V = {voltage:g}$"
            draw_rest(axes[0], found, pressure, shade, name)
            axes[0].plot(fold, largest, "o", color=shade, markerfacecolor="white", markersize=4)
            stable = found.where(found.stability == "stable")
            axes[2].plot(stable.stretch[:, 0], stable.natural_frequency[:, 0], color=shade)
        for pressure, shade in zip((0.0, 0.4, 0.8, 1.1), shades, strict=True):
            fold = brentq(
                lambda x, p=pressure: 4.0 / x - 16.0 / x**7 - p,
                4.0 ** (1.0 / 6.0) - 1e-9, 7.0 ** (1.0 / 6.0),
            )  # fmt: skip
            pull_in = (7.0 / fold**8 - fold**-2) ** 0.5
            voltage = pull_in * shares
            found = rm.equilibria(
                BALLOON.replace(parameters={"pressure": pressure}),
                state_box={"stretch": (0.9, 12.0)}, over={"m": voltage},
            )  # fmt: skip
            draw_rest(axes[1], found, voltage, shade, f"$P = {pressure:g}$")
            axes[1].plot(fold, pull_in, "o", color=shade, markerfacecolor="white", markersize=4)
        axes[0].set(xlabel=r"stretch, $\lambda$", ylabel="pressure, $P$", xlim=(1.0, 2.6))
        axes[1].set(xlabel=r"stretch, $\lambda$", ylabel="voltage, $V$", xlim=(1.0, 2.6))
        axes[2].set(xlabel=r"stretch, $\lambda$", ylabel=r"natural frequency, $\omega_0$")
        axes[2].set(xlim=(1.0, 1.4))
        for ax in axes:
            ax.set_ylim(bottom=0.0)
        for k in (0, 1):
            axes[k].legend(loc="upper right", fontsize=7.0, handlelength=1.2)
        for ax, letter in zip(axes, "abc", strict=True):
            style.set_panel_title(ax, letter, "colours as in (a)" if letter == "c" else "")
    return figure


def draw_rest(ax: Any, found: Any, value: Any, colour: Any, name: str) -> None:
    """Draw stable equilibria solid and unstable ones dashed, against a load."""
    for kind, line, label in (("stable", "-", name), ("unstable", UNSTABLE, None)):
        for k in range(found.sizes["equilibrium"]):
            here = found.stretch[:, k].where(found.stability[:, k] == kind)
            ax.plot(here, value, linestyle=line, color=colour, label=label if k == 0 else None)


def rest_state() -> tuple[float, float]:
    """The stretch at rest under the static voltage, and its natural frequency."""
    found = rm.equilibria(FREE, VOLTAGE, state_box={"stretch": (0.8, 1.5)})
    return float(found.stretch[0]), float(found.natural_frequency[0])


def resonances() -> Any:
    """Draw the three resonances with their jumps, and two motions at each."""
    stretch, natural = rest_state()
    turning = np.linspace(stretch + 1e-3, 1.75, 60)
    free = rm.backbone(FREE, turning, m=VOLTAGE)
    # Order, amplitude of the voltage, range, frequency of the motions below, highest amplitude.
    cases = (
        ("superharmonic", 0.5, 0.17, (0.45, 0.53), 0.485, 0.26),
        ("harmonic", 1.0, 0.024, (0.86, 1.06), 0.93, 0.40),
        ("subharmonic", 2.0, 0.35, (1.86, 2.04), 1.93, 0.32),
    )
    figure, axes = style.subplots(2, 3, figsize=(7.2, 4.7), height_ratios=(1.25, 1.0))
    with style.context():
        for column, (kind, order, share, limits, shown, top) in enumerate(cases):
            above, below = axes[:, column]
            load = rm.Sine(share * VOLTAGE, limits[1] * natural, mean=VOLTAGE)
            branches = forced_branches(load, limits, (stretch, natural))
            above.plot(
                order * free.frequency / natural, free.amplitude, ":", color=FAINT, linewidth=1.2,
                label="free oscillation",
            )  # fmt: skip
            for branch in branches:
                draw_branch(above, branch, natural)
            draw_sweeps(above, load, limits, natural, 8000 if order == 2.0 else 1500)
            above.set(xlim=limits, ylim=(0.0, top), xlabel=r"frequency, $\omega/\omega_0$")
            above.axvline(shown, color=FAINT, linewidth=0.6, zorder=0)
            style.set_panel_title(above, "abc"[column], f"{kind}, $a = {share:g}$")
            draw_motions(below, branches, load.replace(omega=shown * natural), shown * natural)
            style.set_panel_title(below, "def"[column], rf"$\omega = {shown:g}\,\omega_0$")
        axes[0, 0].set_ylabel(r"amplitude, $(\lambda_{\max} - \lambda_{\min})/2$")
        axes[1, 0].set_ylabel(r"stretch, $\lambda$")
        named: dict[str, Any] = {}
        for ax in axes.ravel():
            named |= dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
        figure.legend(
            named.values(), named.keys(), loc="outside lower center", ncols=5, handlelength=1.9
        )
    return figure


def forced_branches(load: Any, limits: Any, rest: tuple[float, float]) -> list[Any]:
    """The branch of the period of the load, and those of twice the period that start on it."""
    stretch, natural = rest
    scaled = (limits[0] * natural, limits[1] * natural)
    first = rm.continue_orbit(
        BALLOON, load, "omega", scaled, initial=(stretch, 0.0), state_box=STATE_BOX
    )
    doublings = np.flatnonzero(first.special_kind == "period doubling")
    return [first, *(rm.switch_branch(first, int(k), state_box=STATE_BOX) for k in doublings)]


def draw_branch(ax: Any, branch: Any, natural: float) -> None:
    """Draw what is stable solid and what is not dashed, with special points."""
    period = int(branch.attrs["orbit_period"])
    colour, name = ((BLUE, "period 1"), (GREEN, "period 2"))[period - 1]
    stable = (branch.stability == "stable").values
    ratio, amplitude = branch.omega.values / natural, branch.amplitude.values
    # A point beside a change belongs to both pieces, which leaves no gap.
    touching = stable | np.roll(stable, 1) | np.roll(stable, -1)
    for there, line, label in ((touching, "-", "stable"), (~stable, UNSTABLE, "unstable")):
        if there.any():
            ax.plot(ratio, np.where(there, amplitude, np.nan), linestyle=line, color=colour,
                    label=f"{label}, {name}")  # fmt: skip
    for k, kind in enumerate(branch.special_kind.values):
        if period == 2 and kind == "period doubling":
            continue  # Where the branch starts: it is marked on that of period 1.
        place = float(branch.special_omega[k])
        distance = np.hypot(
            branch.omega.values - place, branch.stretch.values - float(branch.special_stretch[k])
        )
        ax.plot(
            place / natural, amplitude[np.argmin(distance)], "o" if kind == "fold" else "s",
            color=colour, markerfacecolor="white", markersize=4, zorder=5, label=kind,
            linestyle="none",
        )  # fmt: skip


def draw_sweeps(ax: Any, load: Any, limits: Any, natural: float, discard: int) -> None:
    """Draw the amplitude of settled motion as the frequency goes slowly up, then down."""
    omega = np.linspace(*limits, 161) * natural
    swept = rm.bifurcation_diagram(
        BALLOON, load, "omega", omega, direction="both", discard=discard, keep=1,
        initial=(rest_state()[0], 0.0), tolerance=1e-8,
    ).isel(period=-1)  # fmt: skip
    shown = omega[::4]
    for direction, marker, face in (("up", "^", "white"), ("down", "v", INK)):
        states = swept.sel(sweep=direction).sel(omega=shown)
        starts = np.stack([states.stretch, states.stretch_rate], axis=1)
        amplitude = [
            settled_amplitude(load.replace(omega=w), w, start)
            for w, start in zip(shown, starts, strict=True)
        ]
        ax.plot(shown / natural, amplitude, marker, color=INK, markersize=2.8,
                markerfacecolor=face, markeredgewidth=0.6, label=f"swept {direction}")  # fmt: skip


def settled_amplitude(load: Any, omega: float, start: Any) -> float:
    """Half the range of the stretch in two drive periods."""
    if not np.isfinite(start).all():
        return float("nan")
    times = np.linspace(0.0, 4.0 * np.pi / omega, 257)
    return float(np.ptp(rm.simulate(BALLOON, load, times=times, initial=start).stretch.values) / 2)


def draw_motions(ax: Any, branches: list[Any], load: Any, omega: float) -> None:
    """Draw two drive periods of the largest and of the smallest stable orbit at a frequency."""
    found = []
    for branch in branches:
        difference = branch.omega.values - omega
        for k in np.flatnonzero(difference[:-1] * difference[1:] <= 0.0):
            if branch.stability[k] == "stable":
                state = [float(branch.stretch[k]), float(branch.stretch_rate[k])]
                found.append((float(branch.amplitude[k]), state, branch.attrs["orbit_period"]))
    _, large, period = max(found)
    _, small, _ = min(found)
    begin, times = 800.0 * np.pi / omega, np.linspace(0.0, 4.0 * np.pi / omega, 257)
    lines = (
        (large, "-", GREEN if period == 2 else BLUE, None),
        (small, "-.", INK, "smaller orbit"),
    )
    for start, line, colour, label in lines:
        settled = rm.simulate(BALLOON, load, times=begin + times, initial=start, tolerance=1e-8)
        ax.plot(times * omega / (2.0 * np.pi), settled.stretch, linestyle=line, color=colour,
                label=label)  # fmt: skip
    ax.set(xlim=(0.0, 2.0), xlabel=r"time, $\omega\tau/2\pi$")


def viscosity() -> Any:
    """Draw response for several relaxation times, creep under pressure, and times to burst."""
    figure, axes = style.subplots(1, 3, figsize=(7.2, 3.0))
    with style.context():
        draw_damped_responses(axes[0])
        draw_creep(axes[1])
        draw_burst_times(axes[2])
        for ax, letter in zip(axes, "abc", strict=True):
            ax.legend(loc="best", fontsize=7.0, handlelength=1.5)
            style.set_panel_title(ax, letter, "")
    return figure


def draw_damped_responses(ax: Any) -> None:
    """Draw branches of forced response, relaxed and stiff natural frequencies as lines."""
    stretch, natural = rest_state()
    times = (0.07, 0.2, 1.0, 3.0)
    box = {"stretch": (0.7, 1.9), "stretch_rate": (-2.0, 2.0), "viscous_stretch": (0.7, 1.9)}
    load = rm.Sine(0.06 * VOLTAGE, 0.75 * natural, mean=VOLTAGE)
    for time, colour in zip(times, number_colours(range(4)), strict=True):
        body = VISCOUS.replace(parameters={"modulus": 0.1, "relaxation_time": time})
        branch = rm.continue_orbit(
            body, load, "omega", (0.75 * natural, 1.3 * natural),
            initial=(stretch, 0.0, stretch), state_box=box,
        )  # fmt: skip
        stable = (branch.stability == "stable").values
        touching = stable | np.roll(stable, 1) | np.roll(stable, -1)
        ratio, amplitude = branch.omega / natural, branch.amplitude
        ax.plot(ratio, amplitude.where(~stable), linestyle=UNSTABLE, color=colour)
        ax.plot(ratio, amplitude.where(touching), color=colour, label=rf"$t_r = {time:g}$")
    stiff = (natural**2 + 12.0 * 0.1 / stretch**2) ** 0.5
    for place in (1.0, stiff / natural):
        ax.axvline(place, color=FAINT, linewidth=0.6, zorder=0)
    ax.set(xlabel=r"frequency, $\omega/\omega_0$", ylabel="amplitude", xlim=(0.8, 1.2))
    ax.set_ylim(bottom=0.0)


def draw_creep(ax: Any) -> None:
    """Draw creep from where pressure and both springs are at rest at once, held or burst."""
    pressures = np.array([1.0, 1.2, 1.26, 1.35, 1.5])
    # The dashpot stays at first: the elastic balloon, stiffer by its spring.
    stiff = {"pressure": pressures / 1.5}
    fast = rm.equilibria(FREE, 0.0, state_box={"stretch": (0.9, 1.38)}, over=stiff).stretch
    for pressure, start, colour in zip(
        pressures, fast[:, 0], number_colours(range(5)), strict=True
    ):
        body = VISCOUS.replace(parameters={"pressure": pressure, "relaxation_time": 40.0})
        motion = rm.simulate(
            body, rm.Constant(0.0), times=np.linspace(0.0, 880.0, 2201),
            initial=(float(start), 0.0, 1.0),
        )  # fmt: skip
        ax.plot(motion.time / 40.0, motion.stretch, color=colour, label=f"$P = {pressure:g}$")
    ax.set(xlabel=r"time, $\tau/t_r$", ylabel=r"stretch, $\lambda$", xlim=(0, 22), ylim=(1.0, 2.4))


def draw_burst_times(ax: Any) -> None:
    """Draw the time from a step of pressure to burst, and that of creep without inertia."""
    pressure = LARGEST_PRESSURE * np.geomspace(1.004, 1.4, 16)
    for time, marker, face in ((10.0, "o", "white"), (40.0, "D", INK)):
        body = VISCOUS.replace(parameters={"relaxation_time": time})
        bursts = [
            rm.crossings(
                body.replace(parameters={"pressure": p}), rm.Constant(0.0), "stretch", 3.0,
                duration=20.0 + 1.5 * time * creep_time(p, 0.5), direction="up", tolerance=1e-7,
            ).crossing_time.values
            for p in pressure
        ]  # fmt: skip
        first = [b[0] / time if b.size else np.nan for b in bursts]
        ax.semilogy(pressure, first, marker, color=INK, markerfacecolor=face, markersize=3.2,
                    markeredgewidth=0.6, label=rf"step, $t_r = {time:g}$")  # fmt: skip
    smooth = LARGEST_PRESSURE * np.linspace(1.003, 1.49, 80)
    ax.semilogy(smooth, [creep_time(p, 0.5) for p in smooth], color=BLUE, label="no inertia")
    marks = {
        r"$P_{\max}$": LARGEST_PRESSURE,
        r"$(1 + \mu_v)P_{\rm step}$": 1.5 * STEP_PRESSURE,
        r"$(1 + \mu_v)P_{\max}$": 1.5 * LARGEST_PRESSURE,
    }
    for name, place in marks.items():
        ax.axvline(place, color=FAINT, linewidth=0.6, zorder=0)
        ax.annotate(
            name, (place, 0.98), xycoords=("data", "axes fraction"), rotation=90, fontsize=7.0,
            ha="right", va="top", xytext=(-1.5, 0), textcoords="offset points",
        )  # fmt: skip
    ax.set(xlabel="pressure, $P$", ylabel=r"time to burst, $\tau/t_r$", xlim=(1.15, 1.9))


def creep_time(pressure: float, modulus: float) -> float:
    """Time of creep without inertia until the stretch cannot follow, over the relaxation time."""

    def excess(stretch: float, xi: float) -> float:
        branch = modulus * (xi**-2 / stretch - xi**4 / stretch**7)
        return float(2.0 * (1.0 / stretch - stretch**-7 + branch) - pressure)

    def top(xi: float) -> float:
        return float((7.0 * (1.0 + modulus * xi**4) / (1.0 + modulus * xi**-2)) ** (1.0 / 6.0))

    def integrand(u: float) -> float:
        xi = end - u * u  # The square keeps the integrand smooth at the end.
        x = brentq(excess, 0.9, top(xi), args=(xi,))
        return 12.0 * u / (xi * ((x / xi) ** 2 - (xi / x) ** 4))

    end = brentq(lambda xi: excess(top(xi), xi), 1.0, 3.0)
    return float(quad(integrand, 1e-6, (end - 1.0) ** 0.5, limit=200)[0])


if __name__ == "__main__":
    pictures = {
        "balloon-statics": statics,
        "balloon-resonances": resonances,
        "balloon-viscosity": viscosity,
    }
    for name, draw in pictures.items():
        with style.context():  # ticks are chosen when a figure is saved
            save_picture(draw(), STATIC / f"{name}.png", dpi=RESOLUTION_DPI)

"""A balloon of a dielectric elastomer, written as energies, against closed forms and SciPy.

The problem is that of J. Zhu, S. Cai and Z. Suo, Polymer International 59 (2010) 378.  The
equations of motion are derived here once more by hand; nothing of the package is used in what its
results are compared with.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar, root

import remanent as rm
from remanent._typing import FloatArray

#: The potential per reference volume of the wall and unit of the shear modulus; `load` is the
#: voltage, Phi/H over the root of mu/epsilon.
ENERGY = "stretch**2 + stretch**-4/2 - pressure*stretch**3/3 - load**2*stretch**4/2"
REST = {"stretch": 1.0}
FREE = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential=ENERGY,
    parameters={"pressure": 0.5},
    rest=REST,
)
BALLOON = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/2",
    potential=ENERGY,
    dissipation="damping*stretch_rate**2/2",
    parameters={"pressure": 0.5, "damping": 0.05},
    rest=REST,
)
BOX = {"stretch": (0.5, 6.0)}
#: Where forced motions are looked for: short of the unstable equilibrium.
STATE_BOX = {"stretch": (0.7, 2.2), "stretch_rate": (-2.0, 2.0)}
#: The static voltage of forced motions, and with it the stretch and its natural frequency.
VOLTAGE = 0.3


def acceleration(stretch: Any, rate: Any, pressure: Any, voltage: Any, damping: Any) -> Any:
    """stretch'' = P l^2 + 2 V^2 l^3 - 2 l + 2 l^-5 - c l', by hand."""
    push = pressure * stretch**2 + 2.0 * voltage**2 * stretch**3
    return push - 2.0 * stretch + 2.0 * stretch**-5 - damping * rate


def potential(stretch: Any, pressure: float, voltage: float) -> Any:
    """The potential by hand."""
    elastic = stretch**2 + stretch**-4 / 2.0
    return elastic - pressure * stretch**3 / 3.0 - voltage**2 * stretch**4 / 2.0


def pressure_at_rest(stretch: Any, voltage: Any) -> Any:
    """P(l) = 2/l - 2/l^7 - 2 V^2 l."""
    return 2.0 / stretch - 2.0 / stretch**7 - 2.0 * voltage**2 * stretch


def squared_frequency(stretch: Any, pressure: Any, voltage: Any) -> Any:
    """2 + 10/l^6 - 2 P l - 6 V^2 l^2."""
    return 2.0 + 10.0 / stretch**6 - 2.0 * pressure * stretch - 6.0 * voltage**2 * stretch**2


STRETCH = float(brentq(lambda x: pressure_at_rest(x, VOLTAGE) - 0.5, 1.0, 1.2))
OMEGA_0 = float(squared_frequency(STRETCH, 0.5, VOLTAGE) ** 0.5)


def drive(share: float, ratio: float) -> rm.Sine:
    """The voltage V_0 (1 + a sin omega tau), a = `share`, omega = `ratio` omega_0."""
    return rm.Sine(share * VOLTAGE, ratio * OMEGA_0, mean=VOLTAGE)


def period_of(ratio: Any) -> Any:
    """2 pi/omega."""
    return 2.0 * np.pi / (np.asarray(ratio) * OMEGA_0)


def forced_rates(s: float, y: FloatArray, share: float, ratio: Any, damping: float) -> FloatArray:
    """Rates per drive period of stretches and their rates (2 x case,); `s` counts periods."""
    stretch, rate = y.reshape(2, -1)
    voltage = VOLTAGE * (1.0 + share * np.sin(2.0 * np.pi * s))
    period = period_of(ratio)
    force = acceleration(stretch, rate, 0.5, voltage, damping)
    return np.concatenate([period * rate, period * force])


def variational_rates(
    s: float, y: FloatArray, share: float, ratio: float, damping: float
) -> FloatArray:
    """The same of one state, followed by its Jacobian by the start, row by row (6,)."""
    voltage = VOLTAGE * (1.0 + share * np.sin(2.0 * np.pi * s))
    slopes = np.array([[0.0, 1.0], [-squared_frequency(y[0], 0.5, voltage), -damping]])
    jacobian = period_of(ratio) * slopes @ y[2:].reshape(2, 2)
    return np.concatenate([forced_rates(s, y[:2], share, ratio, damping), jacobian.ravel()])


def independent_map(
    state: Any, share: float, ratio: float, damping: float, periods: int = 1
) -> tuple[FloatArray, FloatArray]:
    """The state after some drive periods and its Jacobian, by DOP853."""
    start = np.array([*state, 1.0, 0.0, 0.0, 1.0])
    end = solve_ivp(
        variational_rates, (0.0, periods), start, method="DOP853", rtol=1e-12, atol=1e-13,
        args=(share, ratio, damping),
    ).y[:, -1]  # fmt: skip
    return end[:2], end[2:].reshape(2, 2)


def independent_orbit(
    guess: Any, share: float, ratio: float, damping: float, periods: int = 1
) -> tuple[FloatArray, Any]:
    """The fixed point of the independent map near a guess, and its multipliers."""

    def residual(state: FloatArray) -> tuple[FloatArray, FloatArray]:
        image, jacobian = independent_map(state, share, ratio, damping, periods)
        return image - state, jacobian - np.eye(2)

    found = root(residual, guess, jac=True, tol=1e-13)
    point = np.asarray(found.x)
    return point, np.linalg.eigvals(independent_map(point, share, ratio, damping, periods)[1])


def test_rest_and_small_oscillations_are_closed_forms() -> None:
    """A balloon rests at P = 2/l - 2/l^7 - 2 V^2 l, omega^2 = 2 + 10/l^6 - 2 P l - 6 V^2 l^2.

    Both within errors.  Stable where omega^2 > 0: on the rising part of P(l), in all pairs of
    stretch and voltage.
    """
    rng = np.random.default_rng(1)
    stretch, voltage = rng.uniform(1.02, 1.6, 12), rng.uniform(0.0, 0.6, 12)
    pressure = pressure_at_rest(stretch, voltage)
    keep = pressure > 0.0
    stretch, voltage, pressure = stretch[keep], voltage[keep], pressure[keep]
    over = {k: xr.DataArray(v, dims="case") for k, v in (("pressure", pressure), ("m", voltage))}
    found = rm.equilibria(FREE, state_box={"stretch": (0.5, 12.0)}, over=over)
    assert (found.status == rm.Status.OK).all()
    near = np.nanargmin(np.abs(found.stretch.values - stretch[:, None]), axis=1)
    here = found.isel(equilibrium=xr.DataArray(near, dims="case"))
    squared = squared_frequency(stretch, pressure, voltage)
    off = np.abs(here.stretch.values - stretch)
    # The pressure itself is rounded, which moves rest by as much over its stiffness.
    rounding = 1e-15 * stretch**2 / np.abs(squared)
    assert (off <= here.stretch_error.values + 2.0 * rounding).all()
    assert set(here.stability.values[squared > 0.0]) == {"stable"}
    assert set(here.stability.values[squared < 0.0]) == {"unstable"}
    stable = squared > 0.0
    error = np.abs(here.natural_frequency.values[stable] - squared[stable] ** 0.5)
    assert (error <= here.natural_frequency_error.values[stable] + 1e-13).all()


@pytest.mark.parametrize("stretch", [4.0 ** (1.0 / 6.0), 1.3, 1.34, 7.0 ** (1.0 / 6.0)])
def test_nothing_holds_beyond_the_largest_pressure_and_the_pull_in_voltage(stretch: float) -> None:
    """A balloon loses its rest at V^2 = 7/l^8 - 1/l^2, P = 4/l - 16/l^7.

    Two equilibria below, none above.  From P = 0, V = 0.6874 at l = 4^(1/6) to V = 0,
    P = 1.2395 at l = 7^(1/6).
    """
    voltage = max(7.0 / stretch**8 - 1.0 / stretch**2, 0.0) ** 0.5
    pressure = 4.0 / stretch - 16.0 / stretch**7
    held = FREE.replace(parameters={"pressure": pressure})
    by_field = {"pressure": pressure, "m": voltage}
    for name in [n for n, value in by_field.items() if value > 1e-3]:
        sides = [by_field[name] - 1e-6, by_field[name] + 1e-6]
        found = rm.equilibria(held, voltage, state_box=BOX, over={name: sides})
        assert (found.status == rm.Status.OK).all()
        assert np.isfinite(found.stretch).sum("equilibrium").values.tolist() == [2, 0]
        low, high = found.stretch.values[0]
        assert low < stretch < high
        assert high - low < 0.01
        assert found.stability.values[0].tolist() == ["stable", "unstable"]


def test_a_step_of_pressure_bursts_the_balloon_below_the_largest_that_it_holds() -> None:
    """A pressure P that comes at once bursts a balloon beyond 1.1121, a slow one beyond 1.2395.

    It goes over the unstable equilibrium if P > P_step, the largest value of
    3 (l^2 + l^-4/2 - 3/2)/(l^3 - 1), where the energy suffices.
    """
    top = minimize_scalar(
        lambda x: 3.0 * (1.5 - x**2 - x**-4 / 2.0) / (x**3 - 1.0), bounds=(1.5, 2.0),
        method="bounded", options={"xatol": 1e-9},
    )  # fmt: skip
    sides = [-float(top.fun) - 1e-5, -float(top.fun) + 1e-5]
    passed = rm.crossings(
        FREE, rm.Constant(0.0), "stretch", 2.5, duration=25.0, over={"pressure": sides}
    )
    assert passed.crossings.values.tolist() == [0, 1]
    assert sides[1] < 4.0 / 7.0 ** (1.0 / 6.0) - 16.0 / 7.0 ** (7.0 / 6.0)


def test_free_oscillations_keep_their_energy_and_have_the_frequency_of_a_quadrature() -> None:
    """Free oscillations of a balloon keep their energy and have the frequency of a quadrature.

    The energy is that by hand and constant; pi/omega is an integral between turning points.
    """
    start = np.array([1.15, 1.4, 1.8, 2.1])
    motion = rm.simulate(FREE, rm.Constant(VOLTAGE), duration=60.0, over={"initial.stretch": start})
    energy = motion.stretch_rate**2 / 2.0 + potential(motion.stretch, 0.5, VOLTAGE)
    drift = np.abs(energy - potential(start, 0.5, VOLTAGE)[:, None]).max("time")
    assert (drift <= 3.0 * motion.energy_error).all()
    found = rm.backbone(FREE, start, m=VOLTAGE)
    for k, upper in enumerate(start):
        level = potential(upper, 0.5, VOLTAGE)
        lower = brentq(lambda x, e=level: potential(x, 0.5, VOLTAGE) - e, 0.3, STRETCH, xtol=1e-15)
        middle, half = (upper + lower) / 2.0, (upper - lower) / 2.0

        # The substitution takes the roots at both ends out of the integrand.
        def integrand(angle: float, e: float = level, m: float = middle, h: float = half) -> float:
            speed = 2.0 * (e - potential(m + h * np.sin(angle), 0.5, VOLTAGE))
            return float(h * np.cos(angle) / speed**0.5)

        time, left = quad(integrand, -np.pi / 2, np.pi / 2, epsabs=1e-10, epsrel=1e-10, limit=200)
        frequency, slack = np.pi / time, np.pi / time**2 * left
        assert abs(float(found.frequency[k]) - frequency) <= (
            float(found.frequency_error[k]) + slack + 1e-9
        )
    # Softer with amplitude: the frequency falls from that of small oscillations.
    assert (np.diff(found.frequency.values) < 0.0).all()
    assert float(found.frequency[0]) < OMEGA_0


@pytest.mark.parametrize(("share", "ratio"), [(0.25, 0.49), (0.05, 0.97), (0.6, 1.95)])
def test_forced_motion_is_that_of_dop853(share: float, ratio: float) -> None:
    """The forced motion of a balloon is that of DOP853 over fifteen periods, within both errors.

    It starts from the state of rest without load.
    """
    load = drive(share, ratio)
    count = np.linspace(0.0, 15.0, 61)
    motion = rm.simulate(BALLOON, load, times=count * period_of(ratio), tolerance=1e-10)
    other = solve_ivp(
        forced_rates, (0.0, 15.0), [1.0, 0.0], method="DOP853", t_eval=count, rtol=1e-12,
        atol=1e-13, args=(share, ratio, 0.05),
    ).y  # fmt: skip
    off = max(
        np.abs(motion.stretch.values - other[0]).max(),
        np.abs(motion.stretch_rate.values - other[1]).max(),
    )
    assert off <= float(motion.error) + 1e-10
    assert float(motion.error) < 1e-9


def test_small_forced_oscillations_have_the_amplitude_of_the_linear_balloon() -> None:
    """A balloon under a voltage that varies a little has the amplitude of the linear equation.

    4 a V^2 l^3/sqrt((omega_0^2 - omega^2)^2 + c^2 omega^2), up to the square of a.
    """
    ratios, shares = (0.7, 1.0, 1.3), (1e-3, 5e-4)
    for ratio in ratios:
        omega = ratio * OMEGA_0
        size = np.hypot(OMEGA_0**2 - omega**2, 0.05 * omega)
        departures = []
        for share in shares:
            orbit = rm.periodic_orbits(
                BALLOON, drive(share, ratio),
                state_box={"stretch": (1.0, 1.15), "stretch_rate": (-0.2, 0.2)},
            )  # fmt: skip
            assert int(orbit.orbits) == 1
            linear = 4.0 * share * VOLTAGE**2 * STRETCH**3 / size
            departures.append(float(orbit.amplitude[0]) / linear - 1.0)
        assert abs(departures[1]) < 2e-4
        assert departures[0] / departures[1] == pytest.approx(4.0, rel=0.05)


def test_orbits_of_both_branches_are_those_of_dop853() -> None:
    """At 0.92 omega_0 a balloon has two stable orbits and a saddle, those of DOP853.

    The multipliers, too; their product is exp(-c T).
    """
    load = drive(0.06, 0.92)
    box = {"stretch": (0.8, 1.6), "stretch_rate": (-1.0, 1.0)}
    found = rm.periodic_orbits(BALLOON, load, state_box=box)
    assert sorted(found.stability.values.tolist()) == ["saddle", "stable", "stable"]
    assert int(found.status) == int(rm.Status.OK)
    for k in range(3):
        ours = found.isel(orbit=k)
        point, multipliers = independent_orbit(ours.initial.values, 0.06, 0.92, 0.05)
        assert np.abs(ours.initial.values - point).max() <= float(ours.error) + 1e-10
        theirs = sorted(multipliers, key=lambda z: (-abs(z), -z.imag))
        error = float(np.max(ours.multipliers_error))
        assert np.abs(np.sort_complex(ours.multipliers.values) - np.sort_complex(theirs)).max() <= (
            error + 1e-9
        )
        product = np.prod(multipliers)
        assert product == pytest.approx(np.exp(-0.05 * period_of(0.92)), rel=1e-9)


def test_jumps_of_slow_sweeps_are_at_the_folds() -> None:
    """Slow sweeps of a balloon by DOP853 jump at the folds.

    A sweep keeps its branch short of the fold and has left it just beyond.  At the folds the
    independent map has the multiplier 1.
    """
    branch = rm.continue_orbit(
        BALLOON, drive(0.06, 1.05), "omega", (0.8 * OMEGA_0, 1.05 * OMEGA_0),
        initial=(STRETCH, 0.0), state_box=STATE_BOX,
    )  # fmt: skip
    assert branch.special_kind.values.tolist() == ["fold", "fold"]
    folds = branch.special_omega.values / OMEGA_0
    states = np.stack([branch[f"special_{n}"].values for n in ("stretch", "stretch_rate")], axis=1)
    order = np.argsort(folds)
    down, up = folds[order]
    for ratio, state in zip(folds[order], states[order], strict=True):
        image, jacobian = independent_map(state, 0.06, ratio, 0.05)
        assert np.abs(image - state).max() < 1e-9
        assert np.abs(np.linalg.eigvals(jacobian) - 1.0).min() < 1e-5
    # From the lower branch up, and from the upper branch down, to both sides of each fold.
    inside, outside = np.array([up - 1e-3, down + 1e-3]), np.array([up + 1e-3, down - 1e-3])
    starts = [orbit_near(branch, ratio, lower) for ratio, lower in zip(inside, (1, 0), strict=True)]
    for ratios, is_small in ((inside, [True, False]), (outside, [False, True])):
        swept = solve_ivp(
            forced_rates, (0.0, 150.0), np.transpose(starts).ravel(), method="DOP853", rtol=1e-8,
            atol=1e-9, args=(0.06, ratios, 0.05), t_eval=np.linspace(149.0, 150.0, 65),
        ).y[:2]  # fmt: skip
        amplitude = np.ptp(swept, axis=1) / 2.0
        assert ((amplitude < 0.14) == is_small).all()


def orbit_near(branch: xr.Dataset, ratio: float, lower: int) -> list[float]:
    """A stable state on the branch near a frequency, of the lower or of the upper orbit."""
    stable = branch.stability.values == "stable"
    side = (branch.amplitude.values < 0.14) == bool(lower)
    distance = np.where(stable & side, np.abs(branch.omega.values / OMEGA_0 - ratio), np.inf)
    k = int(np.argmin(distance))
    return [float(branch.stretch[k]), float(branch.stretch_rate[k])]


def test_the_subharmonic_starts_at_two_doublings_near_twice_the_natural_frequency() -> None:
    """The subharmonic of a balloon starts at two doublings near twice its natural frequency.

    There the independent map has the multiplier -1; the doubled orbits return after two periods.
    One branch is stable, the other is not; both bend to lower frequencies, as a soft balloon's do.
    """
    balloon = BALLOON.replace(parameters={"damping": 0.02})
    low, high = 1.8 * OMEGA_0, 2.1 * OMEGA_0
    forced = rm.continue_orbit(
        balloon, drive(0.3, 2.1), "omega", (low, high), initial=(STRETCH, 0.0), state_box=STATE_BOX
    )
    assert forced.special_kind.values.tolist() == ["period doubling"] * 2
    ratios = forced.special_omega.values / OMEGA_0
    assert (np.abs(ratios - 2.0) < 0.02).all()
    for k, ratio in enumerate(ratios):
        state = [float(forced[f"special_{n}"][k]) for n in ("stretch", "stretch_rate")]
        _, multipliers = independent_orbit(state, 0.3, ratio, 0.02)
        assert np.abs(multipliers + 1.0).min() < 1e-6
    kinds = []
    for k in range(2):
        doubled = rm.switch_branch(forced, k, state_box=STATE_BOX)
        assert float(doubled.omega.max()) <= forced.special_omega.values[k] + 1e-9
        j = int(np.argmin(np.abs(doubled.omega.values / OMEGA_0 - 1.9)))
        ratio = float(doubled.omega[j]) / OMEGA_0
        guess = [float(doubled.stretch[j]), float(doubled.stretch_rate[j])]
        point, multipliers = independent_orbit(guess, 0.3, ratio, 0.02, periods=2)
        assert np.abs(point - guess).max() < 1e-8
        once, _ = independent_map(point, 0.3, ratio, 0.02)
        assert np.abs(once - point).max() > 0.1
        expected = "stable" if np.abs(multipliers).max() < 1.0 else "saddle"
        assert str(doubled.stability[j].values) == expected
        kinds.append(expected)
    assert sorted(kinds) == ["saddle", "stable"]


def test_the_superharmonic_answers_at_twice_the_frequency_of_the_voltage() -> None:
    """Near half its natural frequency a balloon answers at twice the frequency of the voltage.

    There are a small orbit, and a large one that moves twice a period.
    """
    balloon = BALLOON.replace(parameters={"damping": 0.02})
    branch = rm.continue_orbit(
        balloon, drive(0.17, 0.55), "omega", (0.44 * OMEGA_0, 0.55 * OMEGA_0),
        initial=(STRETCH, 0.0), state_box=STATE_BOX,
    )  # fmt: skip
    assert branch.special_kind.values.tolist() == ["fold", "fold"]
    peak = int(np.argmax(branch.amplitude.values))
    ratio = float(branch.omega[peak]) / OMEGA_0
    state = [float(branch.stretch[peak]), float(branch.stretch_rate[peak])]
    point, _ = independent_orbit(state, 0.17, ratio, 0.02)
    assert np.abs(point - state).max() < 1e-8
    load = drive(0.17, ratio)
    times = np.arange(64) / 64.0 * period_of(ratio)
    motion = rm.simulate(balloon, load, times=times, initial=point)
    harmonics = np.abs(np.fft.rfft(motion.stretch.values))[1:]
    assert np.argmax(harmonics) == 1
    assert harmonics[1] > 3.0 * harmonics[0]

"""Exponents, regimes, basins, charts and diagrams of actuators."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


def test_exponents_of_an_undamped_actuator_are_a_pair() -> None:
    """Their sum is what M(start)/M(end) leaves over, and tends to 0 as the run grows."""
    ds = rm.lyapunov(rm.Actuator(), rm.SineSquared(2.0, 0.85), periods=400, count=2)
    assert ds.exponent.dims == ("exponent_number",)
    length = 0.9 * 400 * float(ds.drive_period)
    assert abs(float(ds.exponent.sum())) < np.log(3.0) / length
    assert ds.exponent_history.dims == ("period", "exponent_number")


def test_exponents_at_rest_are_those_of_the_equilibrium() -> None:
    """A load of nothing: -3 eta/(2 M) and the pair's real part; M = 3 at c = 1."""
    eta = 0.2
    ds = rm.lyapunov(
        rm.Actuator(dissipation=rm.Rayleigh(eta)), rm.SineSquared(0.0, 1.0), periods=400, count=2
    )
    exact = -3.0 * eta / (2.0 * 3.0)
    np.testing.assert_allclose(ds.exponent, exact, atol=3e-3)
    assert float(ds.exponent.mean()) == pytest.approx(exact, abs=1e-8)


def test_an_overdamped_equilibrium_has_two_exponents() -> None:
    """M s^2 + 3 eta s + 18 = 0 at rest, with real roots: 1 % and better."""
    eta = 8.0
    body = rm.Actuator(dissipation=rm.Rayleigh(eta))
    ds = rm.lyapunov(body, rm.SineSquared(0.0, 2.0), periods=200, count=2)
    np.testing.assert_allclose(ds.exponent, np.sort(np.roots([3.0, 3.0 * eta, 18.0]))[::-1],
                               rtol=1e-6)  # fmt: skip


def test_one_exponent_at_rest_is_known_although_the_state_needs_no_steps() -> None:
    """The state stands still at any step; the tangent, judged where steps matter, does not."""
    eta = 8.0
    body = rm.Actuator(dissipation=rm.Rayleigh(eta))
    ds = rm.lyapunov(body, rm.SineSquared(0.0, 2.0), periods=400)
    exact = float(np.roots([3.0, 3.0 * eta, 18.0]).max())
    assert abs(float(ds.exponent) - exact) <= float(ds.exponent_error) + 1e-12
    assert float(ds.exponent_error) < 1e-6


def test_a_sea_is_chaotic_and_an_island_is_not() -> None:
    """A strong load: the exponent is told with its errors; by the same rules, a torus is not.

    What a single chaotic run shows depends on its rounding; eight of them together do not.
    """
    body = rm.Actuator(c=0.2, prestress=1.0)
    starts = np.array([1.0, *np.linspace(0.99, 1.01, 8)])
    over = {
        "b": xr.DataArray([0.3] + [1.9] * 8, dims="case"),
        "initial.stretch": xr.DataArray(starts, dims="case"),
    }
    found = rm.classify(body, rm.SineSquared(0.4, 1.0), periods=600, over=over)
    torus, sea = found.isel(case=0), found.isel(case=slice(1, None))
    assert found.regime.dims == ("case",)
    assert torus.regime.item() == "quasi-periodic"
    assert set(sea.regime.values.tolist()) <= {"chaotic", "undecided"}
    assert (sea.regime == "chaotic").sum() >= 5
    assert float(sea.exponent.mean()) > 3.0 * float((sea.exponent_error**2).mean() ** 0.5) / 8**0.5
    assert abs(float(torus.zero_one)) < 0.2
    assert float(sea.zero_one.median()) > 0.3
    assert float(torus.digits) > 3.4 > float(sea.digits.median())
    assert (sea.horizon < 600 * sea.drive_period).all()


def test_the_rotation_number_of_small_motion_is_a_ratio_of_frequencies() -> None:
    """omega_n over the load's 2 omega, of an undriven actuator near rest; modulo 1."""
    ds = rm.classify(rm.Actuator(), rm.SineSquared(0.0, 1.7), periods=400, initial=(1.001, 0.0))
    assert ds.regime.item() == "quasi-periodic"
    assert float(ds.rotation_number) == pytest.approx(np.sqrt(6.0) / 3.4, abs=1e-5)


def test_labels_do_not_depend_on_company() -> None:
    """Determinism: alone and among others, equal to the bit."""
    omega = np.linspace(0.8, 2.0, 9)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.02))
    whole = rm.classify(body, DRIVE, periods=150, over={"omega": omega})
    alone = rm.classify(body, DRIVE.replace(omega=omega[4]), periods=150)
    for name in alone.data_vars:
        np.testing.assert_array_equal(whole[name][4], alone[name])


def test_two_attractors_and_who_goes_there() -> None:
    """Two stable equilibria beyond the cusp (S/theta inside the wedge): two basins."""
    body = rm.Actuator(prestress=2.2, c=0.2, dissipation=rm.Rayleigh(0.5))
    drive = rm.Sine(0.02, 3.0, mean=2.3)
    grid = {"stretch": np.linspace(0.6, 2.4, 10), "stretch_rate": np.zeros(1)}
    ds = rm.basins(body, drive, grid, periods=150)
    assert ds.regime.dims == ("stretch", "stretch_rate")
    assert (ds.regime == "periodic").all()
    assert ds.sizes["attractor"] == 2
    assert float(ds.fraction.sum()) == 1.0
    assert float(ds.fraction[0]) >= float(ds.fraction[1])
    share = float(ds.fraction[0])
    assert float(ds.fraction_error[0]) == pytest.approx(np.sqrt(share * (1 - share) / 10))
    assert set(np.unique(ds.basin)) == {0, 1}
    for k in range(2):  # the point of the attractor is what motions there end near
        again = rm.classify(body, drive, periods=150, initial=ds.attractor_state.values[k])
        assert again.period.item() == ds.attractor_period.values[k]


def test_undamped_starts_have_a_rotation_number() -> None:
    """Motion without dissipation has no attractors; its islands are told by their turning."""
    ds = rm.basins(rm.Actuator(), DRIVE, {"stretch": [1.05, 1.1]}, periods=300)
    assert "basin" not in ds
    assert ds.rotation_number.notnull().all()


def test_a_sweep_shows_hysteresis() -> None:
    """Up and down differ where two motions coexist, and each continues the one before."""
    omega = np.linspace(1.0, 1.25, 11)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.02))
    ds = rm.bifurcation_diagram(
        body, rm.SineSquared(0.5, 1.0), "omega", omega, direction="both", discard=300, keep=3
    )
    assert ds.stretch.dims == ("sweep", "omega", "period")
    apart = np.abs(ds.stretch.sel(sweep="up") - ds.stretch.sel(sweep="down")).max("period")
    assert float(apart.max()) > 0.05
    assert float(apart.min()) < 1e-3
    np.testing.assert_allclose(ds.thickness_stretch, ds.stretch**-2.0, rtol=1e-14)
    up = rm.bifurcation_diagram(body, rm.SineSquared(0.5, 1.0), "omega", omega, discard=300, keep=3)
    assert up.stretch.dims == ("omega", "period")
    np.testing.assert_array_equal(up.stretch, ds.stretch.sel(sweep="up"))


def test_bad_arguments_say_what_to_do() -> None:
    """Bad input: the message names the argument that was passed."""
    with pytest.raises(rm.InputError, match="`periods`"):
        rm.lyapunov(DAMPED, DRIVE, periods=0)
    with pytest.raises(rm.InputError, match="at most 2"):
        rm.lyapunov(DAMPED, DRIVE, periods=10, count=3)
    with pytest.raises(rm.InputError, match="`drive` must have a period"):
        rm.classify(DAMPED, rm.Constant(0.1), periods=200)
    with pytest.raises(rm.InputError, match="at least 100"):
        rm.classify(DAMPED, DRIVE, periods=10)
    with pytest.raises(rm.InputError, match="two axes"):
        rm.regime_chart(DAMPED, DRIVE, {"omega": [1.0, 2.0]}, periods=200)
    with pytest.raises(rm.InputError, match="grid"):
        rm.basins(DAMPED, DRIVE, {}, periods=200)
    with pytest.raises(rm.InputError, match="omgea"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omgea", [1.0, 2.0])
    with pytest.raises(rm.InputError, match="`grid` must name state variables"):
        rm.basins(DAMPED, DRIVE, {"strech": [1.0]}, periods=200)
    with pytest.raises(rm.InputError, match=r"^`grid\['stretch'\]` must be sorted"):
        rm.basins(DAMPED, DRIVE, {"stretch": [1.1, 1.0]}, periods=200)
    with pytest.raises(rm.InputError, match="`over` must have dimensions that the grid"):
        rm.basins(DAMPED, DRIVE, {"stretch": [1.0]}, over={"initial.stretch": [1.0]})
    with pytest.raises(rm.InputError, match=r"^`values` must be sorted"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omega", [2.0, 1.0])
    with pytest.raises(rm.InputError, match="`over` must not vary omega"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omega", [1.0, 2.0], over={"omega": [1.0]})
    with pytest.raises(rm.InputError, match="`rng` must"):
        rm.classify(DAMPED, DRIVE, periods=200, rng=-1)
    with pytest.raises(rm.InputError, match="direction"):
        rm.bifurcation_diagram(DAMPED, DRIVE, "omega", [1.0, 2.0], direction="left")


def test_an_invalid_point_does_not_stop_the_rest() -> None:
    """A failure is a status, then NaN, at its own point only."""
    over = {"omega": xr.DataArray([-1.0, 1.25], dims="case")}
    for verb in (rm.lyapunov, rm.classify):
        ds = verb(DAMPED, DRIVE, periods=120, over=over)
        assert ds.status.values.tolist() == [4, 1]
        assert np.isnan(ds.exponent[0])
        assert np.isfinite(ds.exponent[1])
    ds = rm.classify(DAMPED, DRIVE, periods=120, over={"omega": xr.DataArray([-1.0], dims="case")})
    assert ds.status.values.tolist() == [4]


def test_slightly_damped_motion_is_sorted_by_the_orbits_it_is_on_the_way_to() -> None:
    """Far from settled after 200 periods, it ends on the stable orbits and on no others."""
    body, drive = (
        rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.01)),
        rm.SineSquared(0.4, 1.2),
    )
    orbits = rm.periodic_orbits(body, drive)
    stable = orbits.initial.values[orbits.stability.values == "stable"]
    ds = rm.basins(
        body, drive, {"stretch": [0.62, 1.0, 1.1], "stretch_rate": [0.0, 0.15]},
        periods=200, tolerance=1e-7,
    )  # fmt: skip
    assert ds.attractor.size == 2
    assert (ds.basin.values >= 0).any(axis=1).all()
    for state in ds.attractor_state.values:
        assert np.abs(stable - state).max(axis=1).min() < 1e-7


def test_basins_over_a_field_are_the_single_ones() -> None:
    """Determinism: each set of parameters has the attractors that it has alone."""
    body, drive = rm.Actuator(prestress=2.2, c=0.2), rm.Sine(0.02, 3.0, mean=2.3)
    grid = {"stretch": np.linspace(0.6, 2.4, 10)}
    etas, means = [0.0, 0.5], [0.2, 2.3]
    over = {"dissipation.0.eta": etas, "mean": means}
    damped = body.replace(dissipation=rm.Rayleigh(0.1))
    ds = rm.basins(damped, drive, grid, periods=100, over=over)
    assert ds.basin.dims == ("dissipation.0.eta", "mean", "stretch")
    assert (ds.basin[0] == -1).all()  # without dissipation there are no attractors
    assert ds.fraction[0].isnull().all()
    for k, mean in enumerate(means):
        alone = rm.basins(
            body.replace(dissipation=rm.Rayleigh(0.5)), rm.Sine(0.02, 3.0, mean=mean), grid,
            periods=100,
        )  # fmt: skip
        here, count = ds.isel({"dissipation.0.eta": 1, "mean": k}), alone.sizes["attractor"]
        for name in alone.data_vars:
            own = here[name]
            if "attractor" in own.dims:
                own = own.isel(attractor=slice(count))
            np.testing.assert_array_equal(own, alone[name], err_msg=str(name))
        assert here.fraction[count:].isnull().all()
    assert {ds.fraction[1, k].count().item() for k in range(2)} == {1, 2}


def test_sweeps_over_a_field_are_the_single_ones() -> None:
    """Determinism: each set of parameters is swept as it is alone, both ways."""
    values, temperatures = [0.2, 0.3, 0.4], [280.0, 320.0]
    options: dict[str, Any] = {"direction": "both", "discard": 30, "keep": 3}
    ds = rm.bifurcation_diagram(
        DAMPED, DRIVE, "b", values, over={"temperature": temperatures}, **options
    )
    assert ds.stretch.dims == ("temperature", "sweep", "b", "period")
    for temperature in temperatures:
        body = DAMPED.replace(temperature=temperature)
        alone = rm.bifurcation_diagram(body, DRIVE, "b", values, **options)
        for name in alone.data_vars:
            here = ds[name].sel(temperature=temperature)
            np.testing.assert_array_equal(here, alone[name], err_msg=str(name))


def test_random_frequencies_follow_from_the_seed_alone() -> None:
    """Determinism: None is one seed, a generator is not advanced, and no other number moves."""
    generator = np.random.default_rng(5)
    before = generator.bit_generator.state
    runs = [
        rm.classify(rm.Actuator(), DRIVE, periods=150, rng=rng) for rng in (None, 0, generator, 1)
    ]
    assert generator.bit_generator.state == before
    xr.testing.assert_identical(runs[0], runs[1])
    xr.testing.assert_identical(
        runs[2], rm.classify(rm.Actuator(), DRIVE, periods=150, rng=generator)
    )
    assert len({float(run.zero_one) for run in runs}) == 3
    rest = [run.drop_vars("zero_one") for run in runs]
    assert all(run.equals(rest[0]) for run in rest)


def test_progress_is_told_up_to_the_end() -> None:
    """Shares grow and the last of them is 1, for every verb of long runs."""
    over = {"omega": [1.25, 1.3]}
    calls: dict[str, Any] = {
        "lyapunov": lambda f: rm.lyapunov(DAMPED, DRIVE, periods=100, over=over, progress=f),
        "classify": lambda f: rm.classify(DAMPED, DRIVE, periods=100, over=over, progress=f),
        "symmetry_check": lambda f: rm.symmetry_check(
            DAMPED, DRIVE, periods=50, over=over, progress=f
        ),
        "bifurcation_diagram": lambda f: rm.bifurcation_diagram(
            DAMPED, DRIVE, "b", [0.3, 0.4], discard=10, keep=1, progress=f
        ),
    }
    for name, call in calls.items():
        shares: list[float] = []
        call(shares.append)
        assert shares == sorted(shares), name
        assert shares[-1] == 1.0, name

"""Attractors, and which starts go there."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


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
    centre, half = (share + 0.05) / 1.1, np.sqrt(share * (1 - share) / 10 + 0.0025) / 1.1
    wilson = max(abs(centre + half - share), abs(centre - half - share))
    assert float(ds.fraction_error[0]) == pytest.approx(wilson)
    assert set(np.unique(ds.basin)) == {0, 1}
    for k in range(2):  # the point of the attractor is what motions there end near
        again = rm.classify(body, drive, periods=150, initial=ds.attractor_state.values[k])
        assert again.period.item() == ds.attractor_period.values[k]


def test_undamped_starts_have_a_rotation_number() -> None:
    """Motion without dissipation has no attractors; its islands are told by their turning."""
    ds = rm.basins(rm.Actuator(), DRIVE, {"stretch": [1.05, 1.1]}, periods=300)
    assert "basin" not in ds
    assert ds.rotation_number.notnull().all()


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
    assert ds.attractor_state.shape == (2, 2)
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
        assert {"basin", "fraction"} <= set(alone.data_vars)
        for name in alone.data_vars:
            own = here[name]
            if "attractor" in own.dims:
                own = own.isel(attractor=slice(count))
            np.testing.assert_array_equal(own, alone[name], err_msg=str(name))
        assert here.fraction[count:].isnull().all()
    assert {ds.fraction[1, k].count().item() for k in range(2)} == {1, 2}


def test_bad_arguments_say_what_to_do() -> None:
    """Bad input: the message names the argument that was passed."""
    with pytest.raises(rm.InputError, match="grid"):
        rm.basins(DAMPED, DRIVE, {}, periods=200)
    with pytest.raises(rm.InputError, match="`grid` must name state variables"):
        rm.basins(DAMPED, DRIVE, {"strech": [1.0]}, periods=200)
    with pytest.raises(rm.InputError, match=r"^`grid\['stretch'\]` must be sorted"):
        rm.basins(DAMPED, DRIVE, {"stretch": [1.1, 1.0]}, periods=200)
    with pytest.raises(rm.InputError, match="`over` must have dimensions that the grid"):
        rm.basins(DAMPED, DRIVE, {"stretch": [1.0]}, over={"initial.stretch": [1.0]})

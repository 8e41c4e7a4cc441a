"""Two directions: where they move as one, where they part, and at what frequencies."""

from __future__ import annotations

import math

import numpy as np
import pytest

import remanent as rm


def body(
    load: float | tuple[float, float] = 0.0, theta: float = 1.0, c: float = 1.0
) -> rm.Actuator:
    return rm.Actuator(temperature=300.0 * theta, reference_temperature=300.0, prestress=load, c=c)


def test_symmetry_is_lost_where_it_is_known_to_be() -> None:
    """The smallest beta = m/theta is 3/2^(2/3), at l3 = 2^(1/3), S/theta = 2^(5/6)."""
    theta, beta, load = 1.3, 3.0 / 2.0 ** (2.0 / 3.0), 2.0 ** (5.0 / 6.0)
    at = rm.equilibria(body(theta * load, theta), theta * beta)
    k = int(np.argmin(abs(at.equilibrium_stretch.values - 2.0 ** (1.0 / 3.0))))
    assert float(at.equilibrium_stretch[k]) == pytest.approx(2.0 ** (1.0 / 3.0), abs=1e-6)
    assert float(at.transverse_stiffness[k]) == pytest.approx(0.0, abs=1e-6)
    grid = theta * np.linspace(1.5, 2.1, 61)
    below = rm.equilibria(body(0.0, theta), 0.999 * theta * beta, over={"prestress": grid})
    above = rm.equilibria(body(0.0, theta), 1.001 * theta * beta, over={"prestress": grid})
    assert float(below.transverse_stiffness.min()) > 0.0
    assert float(above.transverse_stiffness.min()) < 0.0


@pytest.mark.parametrize(("theta", "S", "m"), [(1.0, 0.0, 0.16), (1.4, 0.7, -0.5), (0.8, 1.0, 0.9)])
def test_frequency_of_parting_stretches(theta: float, S: float, m: float) -> None:
    """w_a^2 = 3 [theta (1 + l^-6) - m l^-4] = 3 (2 theta - S/l) at an equilibrium."""
    at = rm.equilibria(body(S, theta, c=0.3), m)
    x = at.stretch.values
    expected = 3.0 * (theta * (1.0 + x**-6) - m * x**-4)
    assert at.transverse_stiffness.values == pytest.approx(expected, rel=1e-12)
    assert at.transverse_stiffness.values == pytest.approx(3.0 * (2.0 * theta - S / x), rel=1e-10)
    both = rm.equilibria(body((S, S), theta, c=0.3), m)
    modes = sorted([float(at.natural_frequency[0]), math.sqrt(float(expected[0]))])
    assert both.natural_frequency.values[0] == pytest.approx(modes, rel=1e-9)


def test_without_load_both_modes_of_a_cube_have_one_frequency() -> None:
    """w_a^2 = 6 theta whatever m at S = 0; for c = 1 and m = 0 the other mode has it too."""
    at = rm.equilibria(body((0.0, 0.0), 1.2), 0.0)
    assert at.natural_frequency.values == pytest.approx(math.sqrt(7.2), rel=1e-9)
    for m in (-1.0, 0.5, 2.0):
        found = rm.equilibria(body(0.0, 1.2), m).transverse_stiffness.values
        assert found == pytest.approx([7.2], rel=1e-10)


def test_unequal_equilibria_appear_in_pairs() -> None:
    """Beyond the loss of symmetry two stable mirror images surround an unstable one."""
    at = rm.equilibria(body((2.1, 2.1)), 2.5)
    assert at.stretch_1.values == pytest.approx(at.stretch_2.values[::-1], rel=1e-9)
    assert at.stability.values.tolist() == ["stable", "unstable", "stable"]
    one = rm.equilibria(body(2.1), 2.5)
    assert one.transverse_stiffness.values.min() < 0.0


HARD: dict[str, tuple[rm.Actuator, float, int]] = {
    "cusp": (body((2.1, 2.1)), 2.5, 3),
    "unequal loads": (body((3.2, 2.9)), 4.0, 5),
    "strong m": (body((5.0, 5.0)), 10.0, 7),
    "compressed": (body((8.0, -2.0)), 5.0, 1),
    "film": (rm.Actuator(prestress=(2.3, 2.0), edges=(1.0, 3.0), c=1e-3), 2.7, 3),
    "Gent": (rm.Actuator(prestress=(5.0, 5.0), material=rm.Gent(20.0)), 10.0, 7),
    "Gent, pulled": (rm.Actuator(prestress=(100.0, 100.0), material=rm.Gent(1.0)), 0.0, 1),
    "Gent, sheared": (rm.Actuator(prestress=(3.0, -3.0), material=rm.Gent(0.2)), 20.0, 1),
    "Gent, stiff": (rm.Actuator(prestress=(1.0, 0.0), material=rm.Gent(1e-3)), 3.0, 1),
    "own field": (
        rm.Actuator(prestress=(2.0, 2.0), magnet=rm.Magnet(demagnetisation=3.0)), 2.5, 7
    ),
    "Ogden": (
        rm.Actuator(
            prestress=(2.5, 2.5), material=rm.Ogden([1.0, 0.1, -0.1], [1.3, 5.0, -2.0])
        ), 3.0, 3,
    ),
}  # fmt: skip


@pytest.mark.parametrize(("actuator", "m", "count"), HARD.values(), ids=HARD.keys())
def test_indices_of_all_equilibria_add_up_to_one(
    actuator: rm.Actuator, m: float, count: int
) -> None:
    """The potential grows without bound at the edge of the stretches there are.

    So the degree of its gradient is 1 (Poincare and Hopf): minima and maxima count 1, saddles
    -1.  An equilibrium that is missed by itself breaks this; the counts are those that
    3 x 3 times as many cells give.

    Law: Complete searches.
    """
    at = rm.equilibria(actuator, m)
    falling = 2 - np.isfinite(at.natural_frequency.values).sum(axis=-1)
    assert int(((-1) ** falling).sum()) == 1
    assert at.sizes["equilibrium"] == count
    stable = at.stability.values == "stable"
    assert (stable == (falling == 0)).all()
    assert stable[np.argmin(at.equilibrium_potential.values)]


DRIVE = rm.SineSquared(1.1, 2.45)


def grown(drive: rm.SineSquared, periods: int, actuator: rm.Actuator) -> float:
    """Logarithm of the growth of a small difference, from two slightly unequal stretches."""
    small = 1e-7
    ds = rm.poincare_section(
        actuator.replace(prestress=(0.0, 0.0)),
        drive,
        periods=periods,
        initial=(1.0 + small, 0.0, 1.0 - small, 0.0),
        tolerance=1e-12,
    )
    difference = ds.stretch_1 - ds.stretch_2, ds.stretch_1_rate - ds.stretch_2_rate
    size = np.hypot(*(d.values for d in difference)) / (2.0 * small)
    return float(np.log(size.max()))


def test_symmetry_check_sees_what_two_stretches_do() -> None:
    """A difference of 1e-7 grows in the model of two coordinates as it says."""
    lost = rm.symmetry_check(body(), DRIVE, periods=200)
    kept = rm.symmetry_check(body(), rm.SineSquared(0.1, 1.0), periods=200)
    assert str(kept.symmetry.values) == "kept"
    assert str(lost.symmetry.values) == "lost"
    short = rm.symmetry_check(body(), DRIVE, periods=50)
    seen = grown(DRIVE, 50, body())
    assert 2.0 < seen <= float(short.transverse_growth) + 1e-3


@pytest.mark.slow
def test_multipliers_of_a_difference_are_those_of_two_coordinates() -> None:
    """At a periodic orbit: the four multipliers are those of one coordinate and these."""
    drive, actuator = rm.SineSquared(0.4, 1.6), body().replace(dissipation=rm.Rayleigh(0.1))
    one = rm.periodic_orbits(actuator, drive)
    start = one.initial.values[0]
    apart = rm.symmetry_check(actuator, drive, periods=50, initial=start).transverse_multipliers
    both = rm.continue_orbit(
        actuator.replace(prestress=(0.0, 0.0)), drive, "omega", (1.59, 1.61),
        initial=(*start, *start), max_points=2,
    )  # fmt: skip
    there = both.isel(point=int(abs(both.omega.values.ravel() - 1.6).argmin()))
    exact = np.sort_complex(np.concatenate([one.multipliers.values[0], apart.values]))
    found = np.sort_complex(there.multipliers.values.ravel())
    assert abs(found - exact).max() < 1e-6


def test_a_damped_orbit_keeps_its_symmetry() -> None:
    """With damping the transverse exponent is negative, and equal stretches stay equal."""
    damped = body().replace(dissipation=rm.Zener(0.5, 1.0))
    ds = rm.symmetry_check(damped, rm.SineSquared(0.4, 1.25), periods=100)
    assert str(ds.symmetry.values) == "kept"
    assert float(ds.transverse_exponent) < 0.0

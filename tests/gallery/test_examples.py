"""What each example of the gallery answers is so: a law, an exact or a published value.

A test bears the name of its example.  The examples run as they stand, but for the pixels of
their figures, which `test_pictures` draws.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from docs.make_gallery import PARTS

Run = Callable[[str], Any]


def test_constant_field(example: Run) -> None:
    """The largest stretch is the turning point by the energy; sampled, a little below it."""
    found = example("constant_field")
    short_of = found.turning_point - found.largest
    assert np.all(short_of > 0)
    assert np.all(short_of < 1e-6)


def test_published_resonances(example: Run) -> None:
    """The six resonances of [Thermal] come out within 0.01."""
    found = example("published_resonances")
    assert found.result.resonance.values == pytest.approx(np.array(found.published), abs=0.01)


@pytest.mark.slow
def test_tolerance(example: Run) -> None:
    """The section is a closed curve; most points of ode45's method lie away from it."""
    found = example("tolerance")
    assert found.regime == "quasi-periodic"
    curve = np.stack([found.section.thickness_stretch, found.section.thickness_stretch_rate], -1)
    loose = np.stack([found.thick, found.rate], -1)
    gaps = np.linalg.norm(curve[:, None] - curve[None], axis=-1) + np.eye(len(curve))
    away = np.linalg.norm(loose[:, None] - curve[None], axis=-1).min(axis=1)
    assert np.median(away) > 2 * gaps.min(axis=1).max()


def test_isothermal(example: Run) -> None:
    """Temperature scales out: responses in scaled variables are the isothermal one."""
    found = example("isothermal")
    assert found.isothermal.max() > 0.5
    assert found.difference < 1e-9


def test_film_in_si(example: Run) -> None:
    """A weak field finds half the natural frequency in hertz; strong ones lie below."""
    resonance = example("film_in_si").in_si.resonance
    natural_hertz = np.sqrt(18 * 100e3 / (2000 * 0.005**2 * 1.02)) / (2 * np.pi)
    assert resonance.attrs["units"] == "Hz"
    assert resonance.values[0] == pytest.approx(natural_hertz / 2, rel=0.002)
    assert np.all(np.diff(resonance.values) < 0)


@pytest.mark.slow
def test_passing_magnet(example: Run) -> None:
    """What is left ringing is the Fourier transform of the field at the natural frequency."""
    found = example("passing_magnet")
    assert np.array(found.ringing) == pytest.approx(found.linear(found.passage_times), rel=0.04)
    assert found.ringing[-1] < found.ringing[0] / 5


def test_warm_magnet(example: Run) -> None:
    """The stretch at rest solves x³ − βx² − 1 = 0 at every temperature and coefficient."""
    found = example("warm_magnet")
    assert abs(found.thick**3 - found.beta * found.thick**2 - 1).max() < 1e-13
    drop = found.thick[:, found.temperature == 293.0].ravel() - found.thick[:, -1]
    weaker = found.coefficients.index(-0.001)
    assert drop[weaker] / drop[-1] == pytest.approx(1.28, abs=0.005)


def test_energy_balance(example: Run) -> None:
    """Work = stored + lost; in the last quarter all but two per cent of it is lost."""
    energy = example("energy_balance").energy
    assert float(abs(energy.balance).max()) < float(energy.balance_error) < 1e-8
    late = energy.isel(time=slice(3 * energy.sizes["time"] // 4, None))
    lost = late.dissipated_energy[-1] - late.dissipated_energy[0]
    assert float(lost / (late.drive_work[-1] - late.drive_work[0])) == pytest.approx(1, abs=0.02)


@pytest.mark.slow
def test_damping_and_folds(example: Run) -> None:
    """Folds come in pairs, and beyond a cusp there are none."""
    assert example("damping_and_folds").folds.tolist() == [2, 2, 2, 0]


@pytest.mark.slow
def test_hysteresis(example: Run) -> None:
    """Up and down differ between the two folds, to a step of the sweep."""
    found = example("hysteresis")
    step = found.omega[1] - found.omega[0]
    assert found.differs[[0, -1]] == pytest.approx(found.folds, abs=1.01 * step)


@pytest.mark.slow
def test_basins(example: Run) -> None:
    """Two attractors, the stable orbits that another search finds, share the plane."""
    found = example("basins")
    attractors = found.ends.attractor_state.transpose("attractor", ...).values
    order = np.argsort(attractors[:, 0])
    assert attractors[order] == pytest.approx(found.stable, abs=1e-4)
    assert float(found.ends.fraction.sum()) == pytest.approx(1, abs=0.002)


def test_period_doubling(example: Run) -> None:
    """At the first of two doublings a multiplier is −1, and the new branch starts there."""
    found = example("period_doubling")
    assert found.kinds.tolist() == ["period doubling"] * 2
    assert abs(found.multipliers + 1).min() < 1e-6
    assert float(found.doubled.omega[0]) == pytest.approx(found.places[0], abs=1e-6)


@pytest.mark.slow
def test_backbone(example: Run) -> None:
    """Free oscillations start from √6 and tend to √3; forced peaks lie on their line."""
    found = example("backbone")
    frequency = found.free.frequency.values
    assert frequency[0] == pytest.approx(6**0.5, rel=1e-6)
    assert frequency[-1] == pytest.approx(3**0.5, rel=0.01)
    assert np.all(np.diff(frequency) < 0)
    for k in range(found.forced.sizes["b"]):
        curve = found.forced.isel(b=k)
        amplitude = curve.amplitude.values.ravel()
        top = np.nanargmax(amplitude)
        own = np.interp(amplitude[top], found.free.amplitude, frequency)
        assert 2 * curve.omega.values.ravel()[top] == pytest.approx(own, rel=0.01)


@pytest.mark.slow
def test_viscoelastic_resonances(example: Run) -> None:
    """Peaks at a half, once and twice the frequency of free oscillations, to 5 per cent.

    Half of this is the spring of the slow viscous branch, which the free oscillation lacks.
    """
    found = example("viscoelastic_resonances")
    ratios = [ratio for peaks in found.marks for _, _, ratio in peaks]
    assert ratios == pytest.approx([0.5, 1, 2], rel=0.05)


def test_viscous_loss(example: Run) -> None:
    """The loss is that of linear viscoelasticity, to the square of the small amplitude."""
    found = example("viscous_loss")
    assert found.loss == pytest.approx(found.linear, rel=0.01)
    assert 0 < np.argmax(found.loss) < len(found.loss) - 1


def test_self_heating(example: Run) -> None:
    """What a period dissipates is given off in a period."""
    found = example("self_heating")
    assert found.mean_rise == pytest.approx(found.predicted, rel=0.002)
    assert found.predicted > 0.5


@pytest.mark.slow
def test_limiting_chains(example: Run) -> None:
    """Chains are never longer than their limit, and endless ones are neo-Hookean."""
    found = example("limiting_chains")
    assert found.difference < 1e-7
    for jm, chain in found.chains.items():
        shortest, longest = chain.minimum.values, chain.maximum.values
        for thick in (shortest, longest):
            assert np.all(2 / thick + thick**2 - 3 < jm)
        assert chain.frequency.values[-1] > chain.frequency.values[0]
    assert np.all(np.diff(found.free.frequency.values) < 0)


@pytest.mark.slow
def test_unequal_stretches(example: Run) -> None:
    """Equal stretches are unstable between the two roots of λ⁶ − 2λ² + 1 = 0, S = 2λ.

    A large square is stable from the fold at λ² = (√21 − 1)/2 on.
    """
    found = example("unequal_stretches")
    golden = 2 * ((5**0.5 - 1) / 2) ** 0.5
    assert found.lost[[0, -1]] == pytest.approx([golden, 2], abs=0.005)
    fold = ((21**0.5 - 1) / 2) ** 0.5
    large = found.is_equal & found.stable & (found.found.stretch_1 > 1)
    first = found.pull[large.any("equilibrium")][0]
    assert first == pytest.approx(fold - fold**-5 + 2 * fold**-3, abs=0.005)


def test_two_shapes(example: Run) -> None:
    """Folds lie on the edges of the wedge, and none is on the other side of the cusp."""
    found = example("two_shapes")
    assert found.found.fold_m.values == pytest.approx(found.exact, abs=1e-12)
    assert float(found.found.fold_m.min()) > found.cusp == pytest.approx(1.8420, abs=5e-5)


def test_command_shaping(example: Run) -> None:
    """Both loads are those of the closed forms, and nothing is left ringing."""
    found = example("command_shaping")
    assert found.command.loads == pytest.approx(found.exact, abs=1e-10)
    assert found.residual < 1e-9
    assert float(found.plain.thickness_stretch.max()) - found.target > 0.3


@pytest.mark.slow
def test_ring_down(example: Run) -> None:
    """Both true values lie in the intervals of the fit."""
    found = example("ring_down")
    low, high = found.found.profile_interval.transpose("bound", ...).values
    true = np.array(list(found.truth.values()))
    assert np.all((low < true) & (true < high))
    assert np.all((high - low) / true < 0.05)


def test_uncertain_step(example: Run) -> None:
    """In the first swing quantiles of the motion are motions under quantiles of the load."""
    found = example("uncertain_step")
    assert found.difference[:, found.times <= 1].max() < 1e-3
    assert found.difference[:, found.times > 8].max() > 1e-2


def test_sobol(example: Run) -> None:
    """First indices are those of a product, within three standard errors."""
    found = example("sobol")
    error = found.found.first_index_error.values
    assert abs(found.found.first_index.values - found.exact) == pytest.approx(
        np.zeros(2), abs=3 * error.max()
    )
    assert found.exact.sum() == pytest.approx(1, abs=0.01)


def test_duffing_exact(example: Run) -> None:
    """True errors lie below the stated ones, which lie below the tolerances."""
    found = example("duffing_exact")
    assert np.all(found.true.max(axis=1) < found.stated)
    assert np.all(found.stated < found.tolerances)


def test_pendulum(example: Run) -> None:
    """The period is 4K(sin² θ₀/2)."""
    found = example("pendulum")
    assert found.period == pytest.approx(found.exact, rel=1e-9)


def test_van_der_pol(example: Run) -> None:
    """The period is 2π (1 + μ²/16), to fourth order."""
    found = example("van_der_pol")
    small = found.values[0]
    assert found.period[0] == pytest.approx(2 * np.pi * (1 + small**2 / 16), abs=small**4)
    assert np.all(np.diff(found.period) > 0)


@pytest.mark.slow
def test_melnikov(example: Run) -> None:
    """No cell below Melnikov's line is chaotic; many above it are."""
    found = example("melnikov")
    is_below = found.force[:, None] < found.threshold
    assert not np.any(found.is_chaotic & is_below)
    assert found.is_chaotic.sum() > 20


@pytest.mark.slow
def test_lorenz(example: Run) -> None:
    """The largest exponent is the published one, the second zero, within three errors."""
    spectrum = example("lorenz").spectrum
    difference = abs(spectrum.exponent.values - [0.9056, 0.0])
    assert np.all(difference < 3 * spectrum.exponent_error.values)
    assert float(spectrum.exponent_error.max()) < 0.03


def test_balloon_burst(example: Run) -> None:
    """The fold is that of P = 2/λ − 2/λ⁷; only the larger step bursts the balloon."""
    found = example("balloon_burst")
    assert found.slow == pytest.approx(12 / 7 ** (7 / 6), abs=1e-12)
    assert found.sudden == pytest.approx(1.1121, abs=5e-5)
    reached = found.runs.stretch.max("time").values
    assert np.all(reached[:2] < 2)
    assert reached[2] > 3


@pytest.mark.slow
def test_study(example: Run) -> None:
    """A study that is done is read again, and holds what the verb gives, bit for bit."""
    found = example("study")
    assert found.again.identical(found.first)
    assert np.array_equal(found.again.amplitude, found.direct.amplitude, equal_nan=True)


def test_another_tool(example: Run) -> None:
    """SciPy's motion of the exported equations is ours, to our tolerance."""
    found = example("another_tool")
    assert found.difference.max() < 1e-11
    assert np.ptp(found.ours.stretch.values) > 0.1


def test_every_example_has_a_test() -> None:
    """Law: each example of the gallery is run by the test of its name."""
    names = [name for part in PARTS.values() for name in part]
    missing = [name for name in names if f"test_{name}" not in globals()]
    assert not missing
    assert len(names) >= 20

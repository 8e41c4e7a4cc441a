"""What every verb must say of every kind of body; a new kind joins `BODIES`.

Each law joins two verbs, or a verb and the equations, so that neither can be wrong alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.lines import Line2D

import remanent as rm
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.codegen import reference
from remanent.codegen.field import vector_field_for
from remanent.results import provenance
from tests.repetitions import fast_and_slow

DRIVE = rm.SineSquared(0.4, 1.25)
PERIOD = np.pi / 1.25
SOLID = rm.StrainEnergy("(I1 - 3)/2 + a*(I1 - 3)**2", {"a": 0.05})
#: Damped bodies, each with one thing that the body of [Thermal] has not.
QUICK = {
    "two directions": rm.Actuator(prestress=(0.3, -0.2), dissipation=rm.Rayleigh(0.2)),
    "relaxing": rm.Actuator(dissipation=rm.Zener(0.5, 0.7)),
}
SLOW = {
    "warm": rm.Actuator(
        heat=rm.Heat(2e-3, exchange=0.2), magnet=rm.Magnet(-1e-3), dissipation=rm.Rayleigh(0.2)
    ),
    "fluid": rm.Actuator(dissipation=rm.KelvinVoigt(0.1)),
    "Gent": rm.Actuator(material=rm.Gent(3.0), dissipation=rm.Rayleigh(0.2)),
    "own field": rm.Actuator(magnet=rm.Magnet(demagnetisation=0.16), dissipation=rm.Rayleigh(0.2)),
    "unequal edges": rm.Actuator(edges=(1.0, 1.3), dissipation=rm.Rayleigh(0.2)),
    "formula": rm.Actuator(material=SOLID, dissipation=rm.Rayleigh(0.2)),
    "Prony series": rm.Actuator(
        dissipation=[rm.Zener(0.5, 0.7), rm.Zener(0.3, 5.0, rm.WLF(8.0, 200.0))]
    ),
    "relaxing, two directions": rm.Actuator(prestress=(0.3, 0.1), dissipation=rm.Zener(0.5, 0.7)),
    "warm, two directions": rm.Actuator(
        prestress=(0.3, 0.1), heat=rm.Heat(2e-3, exchange=0.2), dissipation=rm.KelvinVoigt(0.1)
    ),
}
BODIES = QUICK | SLOW

every = pytest.mark.parametrize("name", fast_and_slow(list(BODIES), QUICK))


@cache
def orbit(name: str) -> xr.Dataset:
    """The only orbit of a damped body under a load that is not strong."""
    found = rm.periodic_orbits(BODIES[name], DRIVE)
    assert found.stability.values.tolist() == ["stable"]
    return found.isel(orbit=0)


@cache
def mean_trace(name: str) -> float:
    """Mean divergence of the flow along the orbit: complex steps, trapezoidal rule."""
    body, phase = BODIES[name], np.arange(256) / 256
    field = vector_field_for(body, DRIVE)
    own = {
        n: np.full(256, v) for n, v in (body.parameter_values() | DRIVE.parameter_values()).items()
    }
    p = np.column_stack([own[n] for n in field.parameter_names])
    u = DRIVE.load_schedule(own, np.full(256, PERIOD)).waveforms_at_phase(phase)
    path = rm.simulate(
        body, DRIVE, times=phase * PERIOD, initial=orbit(name).initial, tolerance=1e-11
    )
    total = 0.0
    for k in range(len(field.state_names)):
        y: Any = np.column_stack([path[n].values for n in field.state_names]).astype(complex)
        y[:, k] += 1e-30j
        rate: Any = reference.evaluate_rates(field, phase, y, p, u)[:, k]
        total += float(rate.imag.mean()) / 1e-30
    return total


@cache
def at_rest(name: str) -> xr.Dataset:
    """The equilibria of a body under a small constant load."""
    return rm.equilibria(BODIES[name], 0.16)


@every
def test_orbits_close_when_they_are_simulated(name: str) -> None:
    """The fixed point of the map over a period is where three periods of the motion end."""
    start = orbit(name).initial.values
    path = rm.poincare_section(BODIES[name], DRIVE, periods=3, initial=start)
    points = np.column_stack([path[str(n)].values for n in orbit(name).state.values])
    assert abs(points - start).max() <= 1e-8


@every
def test_product_of_multipliers_is_that_of_the_divergence(name: str) -> None:
    """Liouville's formula: with internal variables and temperatures too."""
    product = np.prod(orbit(name).multipliers.values)
    assert abs(product.imag) <= 1e-9
    assert product.real == pytest.approx(np.exp(mean_trace(name) * PERIOD), rel=1e-7)


@every
def test_lyapunov_exponents_add_up_to_the_divergence(name: str) -> None:
    """Exponents: their sum is the mean divergence, the largest that of the multipliers."""
    count = orbit(name).sizes["state"]
    ds = rm.lyapunov(
        BODIES[name], DRIVE, periods=300, count=count, initial=orbit(name).initial.values
    )
    assert float(ds.exponent.sum()) == pytest.approx(mean_trace(name), rel=0.01)
    largest = np.log(abs(orbit(name).multipliers.values).max()) / PERIOD
    assert float(ds.exponent[0]) == pytest.approx(largest, rel=0.03)


@every
def test_branches_pass_through_what_is_left_after_transients(name: str) -> None:
    """An amplitude on the branch, at a frequency of its own, is that of a long run from rest."""
    start = orbit(name).initial.values
    branch = rm.continue_orbit(BODIES[name], DRIVE, "omega", (1.2, 1.3), initial=start)
    assert set(branch.stability.values.tolist()) == {"stable"}
    np.testing.assert_allclose(branch.omega[[0, -1]], (1.2, 1.3), rtol=1e-12)
    some = branch.isel(point=[0, branch.sizes["point"] // 2, -1])
    response = rm.frequency_response(
        BODIES[name], DRIVE, some.omega.values, duration=400.0, discard=385.0, resonance_width=0.1
    )
    np.testing.assert_allclose(response.amplitude, some.amplitude, atol=1e-6)


@every
def test_motion_ends_on_the_orbit(name: str) -> None:
    """Basins, with the regimes they are made of, and a sweep end at the orbit that was found."""
    first = str(orbit(name).state.values[0])
    ds = rm.basins(BODIES[name], DRIVE, {first: [0.9, 1.1]}, periods=200)
    assert set(ds.regime.values.tolist()) == {"periodic"}
    assert (ds.basin.values == 0).all()
    assert ds.attractor_period.values.tolist() == [1]
    start = orbit(name).initial.values
    np.testing.assert_allclose(ds.attractor_state.values[0], start, rtol=1e-6, atol=1e-6)
    sweep = rm.bifurcation_diagram(BODIES[name], DRIVE, "b", [0.3, 0.4], discard=200, keep=2)
    ends = np.array([sweep[str(n)].values[-1] for n in orbit(name).state.values])
    np.testing.assert_allclose(ends, np.tile(start, (2, 1)).T, rtol=1e-6, atol=1e-6)


@every
def test_small_loads_are_followed_with_their_own_period(name: str) -> None:
    """Damped motion under a weak load is periodic with the load's period."""
    over = {"b": [0.05, 0.1], "omega": [1.5, 2.0]}
    ds = rm.regime_chart(BODIES[name], DRIVE, over, periods=200)
    assert set(ds.regime.values.ravel().tolist()) == {"periodic"}
    assert (ds.period.values == 1).all()


@every
def test_what_a_cycle_takes_in_is_lost_in_it(name: str) -> None:
    """Work of the load over a closed orbit is dissipated, or flows off as heat besides."""
    ds = rm.cycle_losses(BODIES[name], DRIVE, periods=2, initial=orbit(name).initial.values)
    surplus = (ds.drive_work - ds.dissipated_energy).values
    assert (ds.dissipated_energy.values > 1e-4).all()
    if BODIES[name].heat is None:
        assert abs(surplus).max() <= 1e-8
    else:
        assert (surplus > 1e-8).all()
        assert (surplus < 1e-2 * ds.dissipated_energy.values).all()


@every
def test_motion_under_a_constant_load_comes_to_rest_at_an_equilibrium(name: str) -> None:
    """The zero of the forces is where the motion is after 400 units of tau."""
    at = at_rest(name)
    path = rm.simulate(BODIES[name], rm.Constant(0.16), times=[0.0, 400.0], tolerance=1e-8)
    assert at.stability.values.tolist() == ["stable"]
    end = float(path.thickness_stretch[-1])
    assert end == pytest.approx(float(at.equilibrium_stretch[0]), abs=1e-6)


@every
def test_a_crossing_is_where_the_simulated_motion_first_passes_the_level(name: str) -> None:
    """Halfway to rest: before it the motion is on the side of the start, at it on the level,
    and it moves in the direction that is told."""
    load, level = rm.Constant(0.16), 0.5 * (1.0 + float(at_rest(name).equilibrium_stretch[0]))
    ds = rm.crossings(BODIES[name], load, "thickness_stretch", level, duration=20.0)
    first = float(ds.crossing_time[0])
    path = rm.simulate(BODIES[name], load, times=np.linspace(0.0, first, 201))
    distance = path.thickness_stretch.values - level
    assert abs(distance[-1]) <= 1e-8
    assert (np.sign(distance[:-1]) == np.sign(1.0 - level)).all()
    assert np.sign(path.thickness_stretch_rate.values[-1]) == int(ds.direction[0])


@pytest.mark.parametrize(
    "name",
    ["relaxing", *(pytest.param(n, marks=pytest.mark.slow) for n in ("Gent", "warm", "own field"))],
)
def test_equal_directions_are_one(name: str) -> None:
    """Two coordinates with equal loads respond, rest and vibrate as one coordinate does."""
    one, omega = BODIES[name].replace(prestress=0.1), [1.0, 1.25, 1.5]
    two = one.replace(prestress=(0.1, 0.1))
    responses = [
        rm.frequency_response(body, DRIVE, omega, duration=40.0, resonance_width=0.1)
        for body in (one, two)
    ]
    np.testing.assert_allclose(responses[1].amplitude, responses[0].amplitude, atol=1e-8)
    here, there = (rm.equilibria(body, 0.16) for body in (one, two))
    assert float(there.stretch_1[0]) == pytest.approx(float(here.stretch[0]), rel=1e-12)
    modes = sorted([float(here.natural_frequency[0]), float(here.transverse_stiffness[0]) ** 0.5])
    np.testing.assert_allclose(there.natural_frequency[0], modes, rtol=1e-9)


def block(size: float, **parts: Any) -> rm.Actuator:
    """A block `size` times as large under the same stresses: the same motion, in slower time."""
    return rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length=f"{5 * size} mm",
        half_thickness=f"{2 * size} mm", force=f"{0.4 * size**2} N", remanence="143 mT", **parts,
    )  # fmt: skip


DAMPED: dict[str, Any] = {"dissipation": rm.Rayleigh(0.2)}
OMEGA = np.linspace(1.2, 1.3, 3)
#: Every verb whose numbers have units, with the parts of the block it is asked of.
PHYSICAL: dict[str, tuple[Callable[[rm.Actuator], xr.Dataset], dict[str, Any]]] = {
    "simulate": (lambda a: rm.simulate(a, DRIVE, duration=5.0), DAMPED),
    "poincare_section": (lambda a: rm.poincare_section(a, DRIVE, periods=3), DAMPED),
    "frequency_response": (lambda a: rm.frequency_response(a, DRIVE, OMEGA, duration=20), DAMPED),
    "equilibria": (lambda a: rm.equilibria(a, over={"m": [0.0, 0.1]}), DAMPED),
    "lyapunov": (lambda a: rm.lyapunov(a, DRIVE, periods=100), DAMPED),
    "classify": (lambda a: rm.classify(a, DRIVE, periods=100), DAMPED),
    "basins": (lambda a: rm.basins(a, DRIVE, {"stretch": [0.9, 1.1]}, periods=100), DAMPED),
    "bifurcation_diagram": (
        lambda a: rm.bifurcation_diagram(a, DRIVE, "b", [0.3, 0.4], discard=50, keep=2), DAMPED,
    ),
    "periodic_orbits": (
        lambda a: rm.periodic_orbits(a, DRIVE, over={"omega": [1.25, 1.3]}), DAMPED,
    ),
    "continue_orbit": (lambda a: rm.continue_orbit(a, DRIVE, "omega", (1.2, 1.3)), DAMPED),
    "response_diagram": (lambda a: rm.response_diagram(a, DRIVE, (1.2, 1.3), slices=1), DAMPED),
    "resonances": (lambda a: rm.resonances(a, DRIVE, (1.1, 1.6), slices=1), DAMPED),
    "crossings": (lambda a: rm.crossings(a, DRIVE, "stretch", 1.0, duration=5.0), DAMPED),
    "energy_balance": (lambda a: rm.energy_balance(a, DRIVE, duration=5.0), DAMPED),
    "cycle_losses": (lambda a: rm.cycle_losses(a, DRIVE, periods=2), DAMPED),
    "symmetry_check": (lambda a: rm.symmetry_check(a, DRIVE, periods=50), DAMPED),
    "shape_commands": (lambda a: rm.shape_commands(a, 0.8), {}),
    "step_response": (lambda a: rm.step_response(a, rm.Constant(0.2), duration=5.0), DAMPED),
    "backbone": (lambda a: rm.backbone(a, [1.1, 1.2]), {}),
    "snap_through": (lambda a: rm.snap_through(a, "m", (0.0, 4.0)), {}),
}  # fmt: skip
#: What a unit of the result becomes where lengths, and so the unit of time, are doubled.
DOUBLED = {"ms": 2.0, "Hz": 0.5, "s-1": 0.5, "s-2": 0.25, "Pa s": 2.0}


@pytest.mark.parametrize(("verb", "parts"), PHYSICAL.values(), ids=PHYSICAL.keys())
def test_a_result_outlives_the_session(
    verb: Callable[[rm.Actuator], xr.Dataset], parts: dict[str, Any], tmp_path: Path
) -> None:
    """A file gives back the result, and the result the system and the drive that made it."""
    body = block(1.0, **parts)
    result = verb(body)
    for ending in (".nc", ".mat"):
        loaded = rm.load(rm.save(result, tmp_path / f"result{ending}"))
        xr.testing.assert_identical(loaded, result)
        rebuilt = provenance.read_system(loaded)
        assert rebuilt == body
        assert rebuilt.scales == body.scales
        if "drive_text" in loaded.attrs:
            assert repr(provenance.read_drive(loaded)) == loaded.attrs["drive_text"]


@pytest.mark.parametrize(("verb", "parts"), PHYSICAL.values(), ids=PHYSICAL.keys())
def test_a_block_twice_as_large_moves_at_half_the_speed(
    verb: Callable[[rm.Actuator], xr.Dataset], parts: dict[str, Any]
) -> None:
    """Every verb's result knows its scales, and its units say how it depends on them."""
    small, large = (rm.to_si(verb(block(size, **parts))) for size in (1.0, 2.0))
    compared = 0
    for name, one in small.variables.items():
        factor: Any = DOUBLED.get(one.attrs["units"], 1.0)
        if one.attrs["units"] == "mixed":  # states, whose rates have a unit of their own
            factor = [DOUBLED.get(unit, 1.0) for unit in small.state_unit.values]
        if one.dtype.kind in "fc" and "error" not in str(name) and name != "residual":
            np.testing.assert_allclose(
                large[name].values, factor * one.values, rtol=1e-6, atol=1e-9, err_msg=str(name)
            )
            compared += 1
    assert compared > 2


#: What a section is drawn in.
OBSERVED = ("thickness_stretch", "thickness_stretch_rate")


def points(artists: Sequence[Any]) -> FloatArray:
    """The points that lines and marks are drawn at, array (point, 2)."""
    rows = [
        a.get_xydata() if isinstance(a, Line2D) else np.asarray(a.get_offsets()) for a in artists
    ]
    plt.close("all")
    return np.concatenate(rows)


def pairs(*columns: Any) -> FloatArray:
    """Values of two variables, array (point, 2)."""
    return np.column_stack([np.ravel(column) for column in columns]).astype(float)


@pytest.mark.parametrize("name", ["two directions", "warm"])
def test_pictures_of_motions_are_drawn_at_the_values_of_the_result(name: str) -> None:
    """Histories, phase portraits and sections: nothing is left out, added or moved."""
    body, first = BODIES[name], str(orbit(name).state.values[0])
    run = rm.simulate(body, DRIVE, duration=3.0)
    section = rm.poincare_section(body, DRIVE, periods=4)
    rate = f"{first}_rate"
    for drawn, expected in (
        (points(rm.plot.history(run, first)), pairs(run.time, run[first])),
        (points(rm.plot.phase(run, first, rate)), pairs(run[first], run[rate])),
        (points(rm.plot.section(section)), pairs(*(section[n] for n in OBSERVED))),
    ):
        np.testing.assert_array_equal(drawn, expected)


@pytest.mark.parametrize("name", ["two directions", "warm"])
def test_pictures_of_branches_are_drawn_at_the_values_of_the_result(name: str) -> None:
    """Every point of a response and of a branch is there, and every multiplier by its size."""
    body = BODIES[name]
    response = rm.frequency_response(body, DRIVE, OMEGA, duration=20.0)
    branch = rm.continue_orbit(body, DRIVE, "omega", (1.24, 1.26), initial=orbit(name).initial)
    curve = points(rm.plot.response(response))
    peak = pairs(response.resonance, response.resonance_amplitude)
    peak = peak[np.isfinite(peak).all(axis=1)]  # there is none where the range ends at the largest
    missing = {*map(tuple, pairs(OMEGA, response.amplitude)), *map(tuple, peak)}
    assert missing <= set(map(tuple, curve))
    along = pairs(branch.omega, branch.amplitude)
    np.testing.assert_array_equal(points(rm.plot.branch(branch)), along)
    sizes = abs(branch.multipliers)
    drawn = points(rm.plot.multipliers(branch))
    for k in range(branch.sizes["multiplier"]):
        column = pairs(branch.omega, sizes.isel(multiplier=k))
        assert set(map(tuple, column)) <= set(map(tuple, drawn))


@pytest.mark.parametrize("name", ["two directions", "warm"])
def test_pictures_of_grids_give_each_label_a_colour(name: str) -> None:
    """A cell for every point, and equal colours where, and only where, labels are equal."""
    body, first = BODIES[name], str(orbit(name).state.values[0])
    over = {"b": [0.1, 0.2], "omega": [1.5, 2.0]}
    grid = {first: [0.9, 1.1], f"{first}_rate": [0.0, 0.2]}
    chart = rm.regime_chart(body, DRIVE, over, periods=100)
    chart["regime"][0, 0], chart["period"][0, 0] = "escaped", 0
    ends = rm.basins(body, DRIVE, grid, periods=100)
    ends["basin"][0, 0] = -1
    for mesh in (rm.plot.map(chart), rm.plot.basins(ends)):
        colours = np.asarray(mesh.get_array()).reshape(4, -1)
        different = np.unique(colours, axis=0, return_inverse=True)[1].ravel()
        assert sorted(np.bincount(different).tolist()) == [1, 3]
    plt.close("all")


TWO, HEATED = rm.Actuator(prestress=(0.0, 0.1)), rm.Actuator(heat=rm.Heat(1e-3))
LOSSY = rm.Actuator(dissipation=rm.Zener(0.5, 1.0))
STRETCHES: FloatArray = np.array([1.1, 1.2])
#: Where a verb has no meaning, and what makes it have one.
REFUSED: dict[str, tuple[Callable[[rm.Actuator], object], rm.Actuator, str]] = {
    "backbone, damped": (lambda a: rm.backbone(a, STRETCHES), LOSSY, "dissipation=()"),
    "backbone, warm": (lambda a: rm.backbone(a, STRETCHES), HEATED, "heat=None"),
    "backbone, two": (lambda a: rm.backbone(a, STRETCHES), TWO, "one number as prestress"),
    "snap, damped": (lambda a: rm.snap_through(a, "m", (0, 4)), LOSSY, "dissipation=()"),
    "snap, two": (lambda a: rm.snap_through(a, "m", (0, 4)), TWO, "one number as prestress"),
    "resonances, two": (lambda a: rm.resonances(a, DRIVE, (1.0, 1.5)), TWO, "response_diagram"),
    "symmetry, two": (lambda a: rm.symmetry_check(a, DRIVE), TWO, "one number as prestress"),
    "orbits, adiabatic": (lambda a: rm.periodic_orbits(a, DRIVE), HEATED, "heat=None"),
    "branch, adiabatic": (
        lambda a: rm.continue_orbit(a, DRIVE, "omega", (1.0, 1.5)), HEATED, "heat=None",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("verb", "body", "remedy"), REFUSED.values(), ids=REFUSED.keys())
def test_what_has_no_meaning_is_refused_with_a_way_out(
    verb: Callable[[rm.Actuator], object], body: rm.Actuator, remedy: str
) -> None:
    """The message is about the system, and names a change with which the verb has a meaning."""
    with pytest.raises(InputError, match=r"^`(actuator|system)` must .*; got .*\. ") as caught:
        verb(body)
    assert remedy in str(caught.value)


def test_a_search_that_fails_says_so() -> None:
    """Newton's method leaves the states that a material with a limit has."""
    with pytest.raises(InputError, match="`saddle` must be near a saddle orbit"):
        rm.manifold_crossing(
            rm.Actuator(material=rm.Gent(3.0)), DRIVE, "omega", (1.0, 1.4), saddle=(1.0, 0.0)
        )


def test_thresholds_of_a_material_with_a_limit_tend_to_those_without() -> None:
    """And are found without a warning, though its forces have poles."""
    limited, plain = (
        rm.snap_through(rm.Actuator(prestress=2.2, material=solid), "m", (1.0, 4.0), initial=2.0)
        for solid in (rm.Gent(1e7), rm.NeoHookean())
    )
    for name in ("fold_m", "snap_m"):
        assert plain[name].size
        np.testing.assert_allclose(limited[name], plain[name], rtol=1e-5)
    assert not rm.snap_through(rm.Actuator(material=rm.Gent(3.0)), "m", (0.0, 4.0)).snap_m.size

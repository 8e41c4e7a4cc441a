"""Whatever the numbers: finite results, a documented status, or a message.

Six hundred cases with the fast profile, more than ten thousand with the nightly one.

Law: Any numbers.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import remanent as rm

#: Numbers of every size: ordinary, denormal, at the edge of the range, and none at all.
EDGES = [0.0, -0.0, 5e-324, 1e-308, 1e-300, 1e300, 1e308, -1e308, -5e-324]
EDGES += [float("nan"), float("inf"), float("-inf")]
ORDINARY = st.floats(-3.0, 3.0)
WILD = st.one_of(ORDINARY, ORDINARY, st.sampled_from(EDGES), st.floats())
SIZE = st.one_of(st.floats(0.01, 3.0), st.floats(0.01, 3.0), st.sampled_from(EDGES), st.floats())
#: Shares, usually of everything; small coefficients, usually none; tolerances, usually loose.
SHARE = st.one_of(st.just(1.0), st.floats(0.0, 1.0), st.sampled_from(EDGES))
SLIGHT = st.one_of(st.just(0.0), st.floats(-2e-3, 2e-3), st.sampled_from(EDGES))
TOLERANCE = st.one_of(st.just(1e-6), st.sampled_from([1e-3, 1e-12, *EDGES]), st.floats())
#: Nothing may take longer, in seconds.
CAP = 20.0
#: But for millions of periods of a load, in a run to its end: 7e-6 s each, or thrice that.
CAP_OF_A_PERIOD = 2e-5


@st.composite
def drives(draw: st.DrawFn) -> Any:
    """Any drive, or the arguments it refuses."""
    kind = draw(st.integers(0, 6))
    a, b, c, d = (draw(WILD) for _ in range(4))
    w, t = draw(SIZE), draw(SIZE)
    makers: list[Callable[[], Any]] = [
        lambda: rm.Constant(a),
        lambda: rm.SineSquared(a, w, b),
        lambda: rm.Sine(a, w, b, c),
        lambda: rm.Steps([0.0, t, 2.0 * t], [a, b, c]),
        lambda: rm.Ramp([0.0, t, 2.0 * t], [a, b, c]),
        lambda: rm.Sampled([0.0, t, 2.0 * t, 100.0], [a, b, c, d]),
        lambda: rm.Chirp(a, w, t, 3.0, b, c),
    ]
    return makers[kind]


@st.composite
def solids(draw: st.DrawFn) -> Any:
    """Any material, or the arguments it refuses; half of them neo-Hookean."""
    a, b, c, share = draw(SIZE), draw(SIZE), draw(WILD), draw(SHARE)
    makers: list[Callable[[], Any]] = [
        lambda: rm.Gent(a, share),
        lambda: rm.MooneyRivlin(a, b, share),
        lambda: rm.Ogden([a, b], [c, -2.0], share),
        lambda: rm.ArrudaBoyce(1.0 + a, share),
        lambda: rm.StrainEnergy("a*(I1 - 3) - b*log(4 - I2)", {"a": a, "b": b}, share),
    ]
    plain: list[Callable[[], Any]] = [lambda: rm.NeoHookean(entropic_fraction=share)]
    return draw(st.sampled_from(makers + len(makers) * plain))


@st.composite
def bodies(draw: st.DrawFn) -> Any:
    """Any actuator, or the arguments it refuses."""
    c, T, T0, S, eta = draw(SIZE), draw(SIZE), draw(SIZE), draw(WILD), draw(SIZE)
    solid, weakening = draw(solids()), draw(SLIGHT)
    damped, law = draw(st.booleans()), draw(st.sampled_from(["deformation-gradient", "rotation"]))
    return lambda: rm.Actuator(
        c=c,
        temperature=300.0 * T,
        reference_temperature=300.0 * T0,
        prestress=S,
        material=solid(),
        dissipation=rm.Rayleigh(eta) if damped else (),
        magnet=rm.Magnet(weakening, law=law),
    )


def judged(ds: xr.Dataset) -> None:
    """Status ok means finite; any other documented status means NaN where it says."""
    status = int(ds.status)
    assert 1 <= status <= 7
    names = [n for n in ("stretch", "stretch_rate", "thickness_stretch", "amplitude") if n in ds]
    values = np.concatenate([np.ravel(ds[name].values) for name in names])
    assert not np.isinf(values).any()
    if status == 1:
        assert np.isfinite(values).all()
        error = ds["amplitude_error" if "amplitude_error" in ds else "error"]
        assert np.isfinite(error.values).all()


def attempted(call: Callable[[], xr.Dataset]) -> None:
    """Nothing but InputError, no warning but ours, and soon."""
    begun = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rm.InputWarning)
        try:
            ds = call()
        except rm.InputError:
            return
        finally:
            assert time.perf_counter() - begun < CAP
    judged(ds)


#: Cases of each of the six tests: six hundred together, or twelve thousand.
FEW, MANY = 100, 2000
fuzzed = settings(max_examples=MANY if settings().max_examples > FEW else FEW)


@fuzzed
@given(body=bodies(), drive=drives(), duration=SIZE, stretch=SIZE, rate=WILD, tolerance=TOLERANCE)
def test_simulate(
    body: Any, drive: Any, duration: float, stretch: float, rate: float, tolerance: float
) -> None:
    """Any actuator, any drive, any initial state, any duration, any tolerance."""
    attempted(
        lambda: rm.simulate(
            body(), drive(), duration=duration, initial=(stretch, rate), tolerance=tolerance
        )
    )


@fuzzed
@given(body=bodies(), drive=drives(), times=st.lists(SIZE, min_size=1, max_size=5))
def test_times(body: Any, drive: Any, times: list[float]) -> None:
    """Any instants, in or out of order."""
    attempted(lambda: rm.simulate(body(), drive(), times=times, tolerance=1e-6))
    attempted(lambda: rm.simulate(body(), drive(), times=sorted(set(times)), tolerance=1e-6))


@fuzzed
@given(
    body=bodies(), b=WILD, omega=SIZE, periods=st.integers(-1, 40), phase=WILD,
    every=st.integers(-1, 5),
)  # fmt: skip
def test_poincare_section(
    body: Any, b: float, omega: float, periods: int, phase: float, every: int
) -> None:
    """Any period, any phase, any stride."""
    attempted(
        lambda: rm.poincare_section(
            body(), rm.SineSquared(b, omega), periods=periods, section_phase=phase, every=every,
            tolerance=1e-6,
        )
    )  # fmt: skip


@pytest.mark.slow
@fuzzed
@given(body=bodies(), m=WILD, omega=SIZE, duration=SIZE, discard=WILD)
def test_frequency_response(
    body: Any, m: float, omega: float, duration: float, discard: float
) -> None:
    """Any frequency, any window."""
    attempted(
        lambda: rm.frequency_response(
            body(), rm.Sine(m, 1.0), [omega], duration=duration, discard=discard, tolerance=1e-6
        ).squeeze("omega")
    )


#: Fields that a sweep may give any values.
VARIED = ("c", "temperature", "reference_temperature", "prestress", "material.entropic_fraction",
          "magnet.temperature_coefficient", "b", "omega", "phase", "initial.stretch",
          "initial.stretch_rate")  # fmt: skip


@fuzzed
@given(
    name=st.sampled_from(VARIED), other=st.sampled_from(VARIED),
    values=st.lists(st.tuples(WILD, WILD), min_size=1, max_size=4), duration=st.floats(0.1, 30.0),
)  # fmt: skip
def test_sweeps(name: str, other: str, values: list[tuple[float, float]], duration: float) -> None:
    """Any values of any two fields: each point has its status, and disturbs no sound one."""
    columns = zip((name, other), np.array(values).T, strict=True)
    over = {field: xr.DataArray([*column, SOUND[field]], dims="case") for field, column in columns}
    body, drive = rm.Actuator(), rm.SineSquared(0.4, 1.25)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rm.InputWarning)
        begun = time.perf_counter()
        ds = rm.simulate(body, drive, duration=duration, over=over, tolerance=1e-6)
        seconds = time.perf_counter() - begun
    omega = np.broadcast_to(over.get("omega", drive.omega), ds.status.shape)
    followed = duration * np.abs(omega)[ds.status.values == 1].sum() / np.pi
    assert seconds < CAP + CAP_OF_A_PERIOD * followed
    for k in range(ds.sizes["case"]):
        judged(ds.isel(case=k))
    alone = rm.simulate(body, drive, duration=duration, tolerance=1e-6)
    np.testing.assert_array_equal(ds.stretch.values[-1], alone.stretch.values)


#: Of a point that is computed whatever stands beside it: the defaults.
SOUND = {
    **rm.Actuator().parameter_values(), **rm.SineSquared(0.4, 1.25).parameter_values(),
    "initial.stretch": 1.0, "initial.stretch_rate": 0.0,
}  # fmt: skip


@fuzzed
@given(body=bodies(), m=WILD)
def test_equilibria(body: Any, m: float) -> None:
    """Any load: equilibria between the ends of the search, perhaps none."""

    def call() -> xr.Dataset:
        ds = rm.equilibria(body(), m)
        found = ds.stretch.values
        assert ((found >= 0.05) & (found <= 20.0)).all()
        return xr.Dataset({"status": ds.status, "stretch": ds.stretch, "error": 0.0})

    attempted(call)

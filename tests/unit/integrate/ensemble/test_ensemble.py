"""What an ensemble promises: bits that depend on nothing, statuses that mean something."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from remanent._load_schedule import LoadSchedule
from remanent._status import Status
from remanent.integrate.ensemble.best_attempts import BestAttempts
from remanent.integrate.ensemble.counts import counts_of_double_steps, cycle_counts
from remanent.integrate.ensemble.ensemble import integrate, integrate_without_error_bound
from remanent.integrate.ensemble.pool import (
    KernelPool,
    PendingTrajectories,
    divide_into_chunks,
)
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.integrate.ensemble.resolution import (
    MAX_RESOLUTION,
    choose_method,
    estimate_resolutions_from_beginnings,
    initial_resolution,
    round_up_resolution,
)
from remanent.integrate.ensemble.work_sizes import DEFAULT_WORK_SIZES, WorkSizes
from remanent.integrate.events import find_crossings
from remanent.integrate.kernel.options import KernelOptions
from tests.unit.integrate.handmade import SINE, Oscillator, Q, V, problem

DRIVEN = Oscillator(-sp.sin(Q) + sp.Symbol("a") * SINE, {"a": 0.0})
STIFF = Oscillator(-400 * sp.sin(Q) + SINE, {})
RUNAWAY = Oscillator(Q**3, {})
POLE = Oscillator(1 / Q, {})


def driven(count: int = 24) -> Problem:
    """Pendulums from quiet to wild, under a periodic load, of different durations."""
    rng = np.random.default_rng(5)
    start = np.column_stack([rng.uniform(-3.0, 3.0, count), rng.uniform(-1.0, 1.0, count)])
    duration = rng.uniform(40.0, 120.0, count)
    return problem(DRIVEN, start, duration, period=3.0, a=np.linspace(0.0, 2.0, count))


def crowd(count: int) -> Problem:
    """Pendulums whose periods, resolutions and durations all differ."""
    rng = np.random.default_rng(15)
    start = np.column_stack([rng.uniform(-3.0, 3.0, count), rng.uniform(-1.0, 1.0, count)])
    period, load = rng.uniform(1.0, 9.0, count), rng.uniform(0.0, 2.0, count)
    everybody = problem(DRIVEN, start, rng.uniform(5.0, 60.0, count), period=1.0, a=load)
    return replace(
        everybody, load_schedule=replace(everybody.load_schedule, piece_lengths=period[None])
    )


def subset(whole: Problem, which: np.ndarray) -> Problem:
    load_schedule = replace(
        whole.load_schedule, piece_lengths=whole.load_schedule.piece_lengths[:, which]
    )
    return Problem(
        whole.field,
        load_schedule,
        whole.parameters[which],
        whole.initial_states[which],
        whole.duration[which],
        whole.invalid[which],
    )


def requests(whole: Problem) -> list[Request]:
    times = np.linspace(0.0, 1.0, 31) * whole.duration[:, None]
    return [Request(times=times), Request(strobe_cycles=3), Request(wants_extremes=True)]


def columns(outcome: Outcome, rows: np.ndarray | slice = slice(None)) -> list[np.ndarray]:
    """Everything that an outcome says, of some trajectories; nothing beyond the horizon."""
    names = ("maximum", "minimum", "error", "horizon", "status", "resolution")
    return [getattr(outcome, name)[rows] for name in names]


def seen(outcome: Outcome, times: np.ndarray, rows: np.ndarray | slice = slice(None)) -> np.ndarray:
    assert outcome.states is not None
    beyond = times > outcome.horizon[:, None]
    return np.where(beyond[:, :, None], np.nan, outcome.states)[rows]


def assert_same(a: list[np.ndarray], b: list[np.ndarray]) -> None:
    for x, y in zip(a, b, strict=True):
        np.testing.assert_array_equal(x, y)


def assert_same_states(
    outcome: Outcome,
    reference: Outcome,
    problem: Problem,
    request: Request,
    rows: np.ndarray | slice = slice(None),
) -> None:
    """The states of the run of each trajectory, up to its horizon."""
    if outcome.states is None or reference.states is None:
        assert outcome.states is reference.states
        return
    count = outcome.states.shape[1]
    if request.times is not None:
        times = request.times[rows]
    else:
        times = (
            request.strobe_cycles
            * problem.load_schedule.piece_lengths[0][:, None]
            * np.arange(count)
        )
    end = np.minimum(outcome.horizon, problem.duration)
    inside = times <= end[:, None]
    assert np.isfinite(outcome.states[inside]).all()
    np.testing.assert_array_equal(outcome.states[inside], reference.states[rows, :count][inside])


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(0, id="times", marks=pytest.mark.slow),
        pytest.param(1, id="strobe"),
        pytest.param(2, id="extremes"),
    ],
)
def test_bits_do_not_depend_on_the_company(kind: int) -> None:
    """Alone, in any order, and in parts of any size: the same bits (law: Determinism)."""
    whole = driven()
    request = requests(whole)[kind]
    reference = integrate(whole, request, tolerance=1e-9)
    assert {Status.OK, Status.HORIZON} <= set(reference.status.tolist())
    order = np.random.default_rng(6).permutation(whole.duration.size)
    for which in (order, order[:7], order[:1], order[-17:]):
        times = None if request.times is None else request.times[which]
        found = integrate(subset(whole, which), replace(request, times=times), tolerance=1e-9)
        assert_same(columns(found), columns(reference, which))
        if times is not None and request.times is not None:
            np.testing.assert_array_equal(seen(found, times), seen(reference, request.times, which))
        elif found.states is not None and reference.states is not None:
            count = found.states.shape[1]
            at = 3.0 * 3.0 * np.arange(reference.states.shape[1])[None, :]
            a = np.where((at[:, :count] > found.horizon[:, None])[..., None], 0, found.states)
            b = np.where((at > reference.horizon[:, None])[..., None], 0, reference.states)
            np.testing.assert_array_equal(a, b[which][:, :count])


@pytest.mark.parametrize("workers", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 5))])
def test_bits_do_not_depend_on_the_threads(workers: int) -> None:
    """One worker or many: the same bits."""
    whole = driven()
    request = requests(whole)[0]
    reference = integrate(whole, request, tolerance=1e-9, workers=3)
    found = integrate(whole, request, tolerance=1e-9, workers=workers)
    assert_same(columns(found), columns(reference))
    assert request.times is not None
    np.testing.assert_array_equal(seen(found, request.times), seen(reference, request.times))


@pytest.mark.parametrize("kind", [0, 1, 2], ids=["times", "strobe", "extremes"])
@pytest.mark.parametrize(
    "sizes",
    [
        pytest.param(WorkSizes(fine_steps_per_chunk=1), id="chunks"),
        pytest.param(WorkSizes(samples_per_block=13), id="samples"),
        pytest.param(
            WorkSizes(min_fine_steps_per_segment=64, max_fine_steps_per_segment=64), id="segments"
        ),
        pytest.param(
            WorkSizes(min_fine_steps_per_segment=300, max_fine_steps_per_segment=300),
            id="longer-segments",
        ),
    ],
)
def test_bits_do_not_depend_on_work_sizes(sizes: WorkSizes, kind: int) -> None:
    """Chunks, segments and blocks of samples of any size: the same bits."""
    everybody = crowd(12)
    request = requests(everybody)[kind]
    reference = integrate(everybody, request, tolerance=1e-9)
    again = integrate(everybody, request, tolerance=1e-9, sizes=sizes)
    assert_same(columns(again), columns(reference))
    assert_same_states(again, reference, everybody, request)


@pytest.fixture(scope="module")
def large() -> Problem:
    """So many trajectories that the default sizes cut their runs into many kernel calls."""
    return crowd(4096)


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(0, id="times", marks=pytest.mark.slow),
        pytest.param(1, id="strobe", marks=pytest.mark.slow),
        pytest.param(2, id="extremes", marks=pytest.mark.slow),
    ],
)
def test_bits_do_not_depend_on_thousands_of_others(large: Problem, kind: int) -> None:
    """Alone, among 8, among 4096, and there with other sizes and workers: the same bits.

    Law: Determinism.
    """
    request = requests(large)[kind]
    reference = integrate(large, request, tolerance=1e-8)
    assert np.unique(reference.resolution).size > 4
    sizes = WorkSizes(
        fine_steps_per_chunk=2.0**19, recorded_fine_steps_per_segment=2**15, samples_per_block=1000
    )
    again = integrate(large, request, tolerance=1e-8, workers=3, sizes=sizes)
    assert_same(columns(again), columns(reference))
    assert_same_states(again, reference, large, request)
    rows = np.random.default_rng(9).permutation(4096)[:13]
    for part in (rows[:8], *rows[8:, None]):
        times = None if request.times is None else request.times[part]
        few = subset(large, part)
        outcome = integrate(few, replace(request, times=times), tolerance=1e-8)
        assert_same(columns(outcome), columns(reference, part))
        assert_same_states(outcome, reference, few, request, part)


@pytest.mark.slow
def test_crossings_do_not_depend_on_thousands_of_others(large: Problem) -> None:
    """Times, states and directions alone, among 8, and among 4096 (law: Determinism)."""
    passages, _ = find_crossings(large, "position", 0.3, tolerance=1e-8)
    rows = np.random.default_rng(10).permutation(4096)[:13]
    for part in (rows[:8], *rows[8:, None]):
        few, _ = find_crossings(subset(large, part), "position", 0.3, tolerance=1e-8, workers=1)
        for k, row in enumerate(part):
            mine, reference = few.trajectory == k, passages.trajectory == row
            for name in ("time", "states", "direction"):
                np.testing.assert_array_equal(
                    getattr(few, name)[mine], getattr(passages, name)[reference]
                )


def test_times_at_the_ends_of_cycles_are_all_reached() -> None:
    """A state for every time within rounding of the end of a cycle, wherever a run is cut."""
    count = 8
    turns = np.arange(1, 400)
    everybody = crowd(count)
    period = everybody.load_schedule.piece_lengths[0]
    everybody = replace(
        everybody, duration=400 * period, initial_states=0.1 * everybody.initial_states
    )
    ends = period[:, None] * turns
    grids = [np.nextafter(ends, 0.0), ends, np.nextafter(ends, np.inf)]
    times = np.stack(grids, axis=-1).reshape(count, -1)
    for sizes in (
        WorkSizes(),
        WorkSizes(min_fine_steps_per_segment=64, max_fine_steps_per_segment=64),
    ):
        outcome = integrate(everybody, Request(times=times), tolerance=1e-6, sizes=sizes)
        assert outcome.states is not None
        reached = times <= outcome.horizon[:, None]
        assert reached.any(axis=1).all()
        np.testing.assert_array_equal(np.isfinite(outcome.states).all(axis=2), reached)


def test_states_beyond_the_horizon_are_not_given() -> None:
    """NaN after the horizon, numbers before it, and the bound met up to it."""
    whole = driven()
    request = requests(whole)[0]
    outcome = integrate(whole, request, tolerance=1e-9)
    short = outcome.status == Status.HORIZON
    assert short.any()
    assert request.times is not None
    assert outcome.states is not None
    before = request.times <= outcome.horizon[:, None]
    assert np.isfinite(outcome.states[before]).all()
    assert np.isnan(outcome.states[request.times > outcome.horizon[:, None] * (1 + 1e-9)]).all()
    assert (outcome.error <= 1e-9).all()
    assert (outcome.horizon[short] < whole.duration[short]).all()


def test_extremes_of_the_second_half_meet_a_tolerance_if_they_meet_a_tighter_one() -> None:
    """Turning points are compared from there on only, and the horizon lies at the first of them.

    That it stays there, attempt after attempt, says nothing of the motion.
    """
    whole = crowd(200)
    request = Request(wants_extremes=True, extremes_begin=0.5 * whole.duration)
    loose, tight = (integrate(whole, request, tolerance=t).status for t in (1e-7, 1e-8))
    met = tight == Status.OK
    assert met.sum() > 190
    assert (loose[met] == Status.OK).all()


def test_an_invalid_trajectory_is_not_computed_and_disturbs_nobody() -> None:
    """Its status is invalid, its numbers NaN; the others keep every bit."""
    whole = driven(10)
    request = requests(whole)[0]
    reference = integrate(whole, request, tolerance=1e-9)
    invalid = np.zeros(10, dtype=np.bool_)
    invalid[4] = True
    found = integrate(replace(whole, invalid=invalid), request, tolerance=1e-9)
    assert found.status[4] == Status.INVALID
    assert found.states is not None
    assert np.isnan(found.states[4]).all()
    assert np.isnan(found.error[4])
    others = ~invalid
    assert_same(columns(found, others), columns(reference, others))


def test_a_motion_that_runs_off_to_infinity_has_escaped() -> None:
    """q'' = q**3 from (1, 1/sqrt 2) is 1/(1 - t/sqrt 2): escaped at t = sqrt 2."""
    asked = problem(RUNAWAY, (1.0, 2.0**-0.5), 5.0)
    times = np.linspace(0.0, 5.0, 101)[None]
    outcome = integrate(asked, Request(times=times), tolerance=1e-6)
    assert outcome.status[0] in (Status.ESCAPED, Status.HORIZON, Status.MAX_STEPS)
    assert 1.2 < outcome.horizon[0] < 2.0**0.5
    assert outcome.states is not None
    before = times[0] <= outcome.horizon[0]
    exact = 1.0 / (1.0 - times[0][before] / 2.0**0.5)
    assert (np.abs(outcome.states[0, before, 0] - exact) <= 2.0 * outcome.error[0]).all()
    assert np.isnan(outcome.states[0, ~before]).all()


def test_a_start_on_a_pole_is_singular() -> None:
    """q'' = 1/q from q = 0 has no derivative to begin with."""
    outcome = integrate(problem(POLE, (0.0, 0.0), 1.0), Request(), tolerance=1e-6)
    assert outcome.status[0] == Status.SINGULAR


def test_too_coarse_a_limit_is_reported() -> None:
    """With a largest resolution that is too small the status is max-steps, not ok."""
    asked = problem(DRIVEN, (3.1, 0.5), 30.0, period=3.0, a=1.2)
    outcome = integrate(asked, Request(), tolerance=1e-9, max_resolution=16)
    assert outcome.status[0] == Status.MAX_STEPS


def test_absurdly_long_runs_are_not_begun() -> None:
    """They would take more steps than anybody waits for: max-steps at once."""
    asked = problem(DRIVEN, [(1.0, 0.0)] * 2, [1e300, 10.0])
    outcome = integrate(asked, Request(), tolerance=1e-6)
    assert outcome.status.tolist() == [Status.MAX_STEPS, Status.OK]


@pytest.mark.parametrize(("period", "affordable"), [(1.6e5, True), (1.7e5, False)])
def test_a_cycle_is_refused_where_no_steps_resolve_it(period: float, affordable: bool) -> None:
    """16 times 2^14 double steps, of which four are needed in 2.5, last for 163840."""
    asked = problem(Oscillator(-Q, {}), (1.0, 0.0), 1.0, period=period)
    best = BestAttempts.before_first_attempt(asked, Request())
    pending = best.without_unaffordable(PendingTrajectories(np.array([0]), np.array([8])))
    assert (pending.indices.size == 1) == affordable


@pytest.mark.filterwarnings("error")
def test_the_longest_cycle_there_is_gives_a_status_and_no_warning() -> None:
    """Neither its steps nor those of its beginning are counted beyond what numbers hold."""
    asked = problem(Oscillator(-Q, {}), (1.0, 0.0), 1e308, period=1.7e308)
    outcome = integrate(asked, Request(wants_extremes=True), tolerance=1e-6)
    assert outcome.status[0] == Status.MAX_STEPS


def test_a_piece_may_be_empty() -> None:
    """Pieces of length zero, for some trajectories only, change nothing."""
    start = np.array([[1.0, 0.0], [1.0, 0.0]])
    whole = problem(DRIVEN, start, 10.0)
    lengths = np.array([[10.0, 4.0], [0.0, 6.0]])
    cut = replace(
        whole,
        load_schedule=LoadSchedule(lengths, False, {}, whole.load_schedule.waveforms_at_phase),
    )
    times = np.tile(np.linspace(0.0, 10.0, 21), (2, 1))
    states = integrate(cut, Request(times=times), tolerance=1e-10).states
    assert states is not None
    np.testing.assert_allclose(states[0], states[1], rtol=0, atol=2e-10)


def test_progress_rises_to_one() -> None:
    """Shares of finished trajectories, ascending, the last of them 1."""
    shares: list[float] = []
    integrate(driven(10), Request(strobe_cycles=1), tolerance=1e-9, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_progress_rises_to_one_with_runs_shorter_than_a_period() -> None:
    """Runs that end early in the first period are integrated apart; their progress counts too."""
    whole = driven(10)
    lengths = np.where(np.arange(10) < 3, 1e4, whole.load_schedule.piece_lengths)
    cut = replace(whole, load_schedule=replace(whole.load_schedule, piece_lengths=lengths))
    for find in (
        lambda report: integrate(cut, Request(), tolerance=1e-9, progress=report),
        lambda report: find_crossings(cut, "q", 0.0, tolerance=1e-9, progress=report),
    ):
        shares: list[float] = []
        find(shares.append)
        assert shares == sorted(shares)
        assert shares[0] <= 0.3
        assert shares[-1] == 1.0


def test_an_interrupted_run_stops() -> None:
    """What `progress` raises comes through, at once."""

    def interrupt(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        integrate(driven(10), Request(strobe_cycles=1), tolerance=1e-9, progress=interrupt)


@pytest.mark.parametrize("period", [3.0, 60.0])
def test_a_long_run_begins_with_about_the_steps_that_it_needs(period: float) -> None:
    """Oscillations by the dozen in a period: the first resolution loses the motion at once."""
    start = np.array([[0.5, 0.0], [1.0, 0.0], [2.0, 0.0]])
    asked = problem(STIFF, start, 300.0, period=period)
    request, tolerance = Request(wants_extremes=True), 1e-7
    needed = integrate(asked, request, tolerance=tolerance)
    assert (needed.status == Status.OK).all()
    method = choose_method(request, tolerance)
    first = initial_resolution(tolerance, method)
    assert (needed.resolution > 4 * first).all()
    options = KernelOptions(follows_extremes=True, own_steps="going on")
    with KernelPool(asked, method, options, tolerance) as pool:
        begun = estimate_resolutions_from_beginnings(
            pool, asked, request, PendingTrajectories(np.arange(3), np.full(3, first)), method,
            most=MAX_RESOLUTION,
        )  # fmt: skip
    assert (begun.resolution >= 0.6 * needed.resolution).all()
    assert (begun.resolution <= 1.5 * needed.resolution).all()


def test_a_run_that_is_told_its_resolution_begins_with_it() -> None:
    """One that is too fine is kept, one that is too coarse refined; 0 says nothing, as before.

    Of runs that end early in their first period the resolution is another, and is not taken over.
    """
    slow = replace(crowd(48), duration=np.where(np.arange(48) < 6, 0.1, crowd(48).duration))
    asked = Request(wants_extremes=True)
    needed = integrate(slow, asked, tolerance=1e-8)
    told = np.where(np.arange(48) % 3 == 0, 0, 2 * needed.resolution)
    finer = integrate(slow, asked, tolerance=1e-8, first_resolution=told)
    ok = needed.status == Status.OK
    same = (told == 0) | (np.arange(48) < 6)
    np.testing.assert_array_equal(finer.maximum[same], needed.maximum[same])
    np.testing.assert_array_equal(finer.resolution[ok & ~same], told[ok & ~same])
    coarser = integrate(slow, asked, tolerance=1e-8, first_resolution=np.full(48, 8))
    for other in (finer, coarser):
        assert (other.status == needed.status).all()
        off = np.abs(other.maximum - needed.maximum)[ok]
        assert (off <= (other.error + needed.error)[ok]).all()


def test_resolutions_are_rounded_up() -> None:
    """Never below what is wanted, at most half as much again, and each its own rung."""
    wanted = np.geomspace(4.0, 1e4, 1001)
    rungs = round_up_resolution(wanted)
    assert (rungs >= wanted).all()
    assert (rungs <= 1.5 * wanted).all()
    assert np.array_equal(round_up_resolution(rungs), rungs)


@pytest.mark.parametrize("status", Status)
def test_meanings_of_statuses(status: Status) -> None:
    """One word each, as in the flag meanings of results."""
    assert status.meaning.replace("-", "").isalpha()
    assert Status[status.meaning.upper().replace("-", "_")] == status


def test_velocity_is_the_rate_of_position() -> None:
    """The helper's own field: a free line moves uniformly."""
    free = Oscillator(0 * Q * V, {})
    times = np.linspace(0.0, 5.0, 11)[None]
    states = integrate(problem(free, (1.0, 2.0), 5.0), Request(times=times), tolerance=1e-9).states
    assert states is not None
    np.testing.assert_allclose(states[0, :, 0], 1.0 + 2.0 * times[0], rtol=0, atol=1e-13)


def test_trajectories_that_are_run_together_take_as_many_steps() -> None:
    """Runs of different lengths at two resolutions: each in one chunk, with others of its steps."""
    rng = np.random.default_rng(9)
    asked = problem(RUNAWAY, np.zeros((60, 2)), rng.uniform(0.5, 4.0, 60))
    resolution = rng.choice([8, 16], 60)
    pending = PendingTrajectories(np.arange(60), resolution)
    chunks = [*divide_into_chunks(asked, pending, 4, 2, DEFAULT_WORK_SIZES)]
    assert sorted(np.concatenate([chunk.indices for chunk in chunks]).tolist()) == [*range(60)]
    for chunk in chunks:
        assert isinstance(chunk.resolution, int)
        assert (resolution[chunk.indices] == chunk.resolution).all()
        steps = counts_of_double_steps(asked.load_schedule, chunk.resolution, chunk.indices)
        assert np.ptp(steps) == 0


def test_groups_are_filled_with_trajectories_of_several_resolutions() -> None:
    """Groups of one resolution are whole; the rest share groups by the steps they take in all."""
    rng = np.random.default_rng(11)
    whole = driven()
    count = whole.duration.size
    pending = PendingTrajectories(np.arange(count), rng.choice([6, 12, 24, 48, 96, 8192], count))
    chunks = [*divide_into_chunks(whole, pending, 4, 2, DEFAULT_WORK_SIZES, mixes=True)]
    assert sorted(np.concatenate([chunk.indices for chunk in chunks]).tolist()) == [*range(count)]
    mixed = [chunk for chunk in chunks if isinstance(chunk.resolution, np.ndarray)]
    assert mixed
    steps = [chunk.resolution * cycle_counts(whole, chunk.indices) for chunk in mixed]
    for chunk, of_chunk, following in zip(mixed, steps, [*steps[1:], np.zeros(1)], strict=True):
        np.testing.assert_array_equal(pending.resolution[chunk.indices], chunk.resolution)
        assert of_chunk.min() >= following.max()
        # As few steps as start a piece, or tables that are long, are not mixed.
        assert np.isin(chunk.resolution, [12, 24, 48, 96]).all()
    assert all(chunk.indices.size == 4 for chunk in mixed[:-1])
    for chunk in chunks:
        if isinstance(chunk.resolution, int):
            assert (pending.resolution[chunk.indices] == chunk.resolution).all()
            if chunk.resolution in (12, 24, 48, 96):  # whole groups, or all of one that is shared
                assert chunk.indices.size % 4 == 0 or chunk is chunks[-1]


@pytest.mark.parametrize("kind", [0, 2], ids=["times", "extremes"])
def test_a_run_without_a_bound_is_the_finer_of_two(kind: int) -> None:
    """At one resolution for all: the numbers of a run that carries its error, and none for it."""
    whole = driven()
    request = requests(whole)[kind]
    bounded = integrate(whole, request, tolerance=1e-9)
    alone = integrate_without_error_bound(whole, request, resolution=1024)
    assert np.isnan(alone.error).all()
    known = bounded.status == Status.OK
    assert known.sum() > 12
    assert (alone.status[known] == Status.OK).all()
    for name in ("states",) if request.times is not None else ("maximum", "minimum"):
        found, expected = (getattr(outcome, name)[known] for outcome in (alone, bounded))
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)

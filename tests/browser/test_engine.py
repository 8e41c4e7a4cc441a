"""The engine of the page agrees with the package, and its stated error covers the true one."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, Route

import remanent as rm
from remanent.integrate.methods.runge_kutta import default_method
from remanent.page import model as page_model_module
from remanent.page.model import PageModel, page_model
from tests.browser.engine_cases import Case, random_case

ASSETS = Path(page_model_module.__file__).with_name("assets")
ORIGIN = "http://page.test/"
#: Instants at which a motion is compared.
INSTANTS = 200
#: Share of instants, and of motions, at which the stated error has to cover the true one.
COVERAGE = 0.99
#: What runs in the page: a motion, thinned out to some instants.
RUN = """
async ([url, options, count]) => {
  const field = await import(url);
  const { integrate } = await import("/engine/motion.js");
  const { messageOf } = await import("/engine/messages.js");
  const motion = integrate(field, options);
  const last = motion.t.length - 1;
  const rows = [...new Set(Array.from({ length: count }, (_, k) =>
    Math.round((last * (k + 1)) / count)))];
  const chosen = (column) => rows.map((row) => column[row]);
  return {
    t: chosen(motion.t), y: motion.y.map(chosen), error: chosen(motion.error),
    observables: motion.observables.map(chosen), scales: [...motion.scales],
    status: motion.status, message: messageOf(motion, (t) => `τ = ${t.toPrecision(4)}`),
    determinedUntil: motion.determinedUntil,
    end: motion.t[last], steps: motion.stepsPerPeriod, milliseconds: motion.milliseconds,
  };
}
"""


class Laboratory:
    """A page that has the engine and nothing else, at an address that no network has."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._fields: dict[str, str] = {}
        page.route("**/*", self._answer)
        page.goto(ORIGIN)

    def run(self, model: PageModel, options: dict[str, Any], count: int = INSTANTS) -> Any:
        """A motion as the page computes it."""
        self._fields[model.id] = model.field_source
        return self._page.evaluate(RUN, [f"/fields/{model.id}.js", options, count])

    def evaluate(self, script: str, argument: Any = None) -> Any:
        """What a script in the page gives."""
        return self._page.evaluate(script, argument)

    def _answer(self, route: Route) -> None:
        path = route.request.url.removeprefix(ORIGIN)
        if path.startswith("fields/"):
            text = self._fields[Path(path).stem]
        elif path.startswith("engine/"):
            text = (ASSETS / path).read_text(encoding="utf-8")
        else:
            route.fulfill(body="<!doctype html><title>engine</title>", content_type="text/html")
            return
        route.fulfill(body=text, content_type="text/javascript")


@pytest.fixture
def laboratory(browser: Browser) -> Iterator[Laboratory]:
    page = browser.new_page()
    yield Laboratory(page)
    page.close()


def run_in_page(laboratory: Laboratory, case: Case) -> dict[str, Any]:
    """A case as the page computes it."""
    model = page_model(case.system, case.drive, case.initial)
    length = {"duration": case.duration} if case.periods is None else {"periods": case.periods}
    found: dict[str, Any] = laboratory.run(
        model, {"initial": model.description["initial"], **length}
    )
    return found


def run_in_package(case: Case, seen: dict[str, Any]) -> Any:
    """The same by the package, at the same instants."""
    names = [*case.initial]
    system, drive = case.system, case.drive
    start = None
    if names:
        start = page_model(system, drive, case.initial).description["initial"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rm.InputWarning)
        return rm.simulate(system, drive, times=seen["t"], initial=start, tolerance=1e-9)


def excess(case: Case, seen: dict[str, Any]) -> np.ndarray[Any, Any]:
    """At each instant the difference over both errors; NaN where the package knows nothing."""
    exact = run_in_package(case, seen)
    names = [one["name"] for one in page_model(case.system, case.drive).description["state"]]
    stated, own = np.array(seen["error"]), float(np.nanmax(exact["error"]))
    shares = [
        np.abs(np.array(seen["y"][k]) - exact[name].values) / (stated * seen["scales"][k] + own)
        for k, name in enumerate(names)
    ]
    return np.asarray(np.max(shares, axis=0))


def require_agreement(laboratory: Laboratory, seed: int, count: int) -> None:
    """Random motions agree within both errors, at 99 % of instants and in 99 % of cases."""
    rng = np.random.default_rng(seed)
    compared = covered = wrong = 0
    worst: list[str] = []
    for _ in range(count):
        case = random_case(rng)
        seen = run_in_page(laboratory, case)
        assert np.isfinite(seen["y"]).all()
        assert np.isfinite(seen["observables"]).all(), case.kind
        found = excess(case, seen)
        known = np.isfinite(found)
        compared += int(known.sum())
        covered += int((found[known] <= 1.0).sum())
        if (found[known] > 1.0).any():
            wrong += 1
            worst.append(f"{case.kind}: {found[known].max():.3g} ({seen['status']})")
    print(json.dumps({"compared": compared, "covered": covered / compared, "wrong": worst}))
    assert compared > 0.5 * count * INSTANTS
    assert covered >= COVERAGE * compared, worst
    assert wrong <= max(1, (1.0 - COVERAGE) * count), worst


def test_motions_agree_with_the_package(laboratory: Laboratory) -> None:
    """Law: random kinds of systems and drives, to within the errors that both state."""
    require_agreement(laboratory, seed=0, count=12)


@pytest.mark.slow
def test_a_thousand_motions_agree_with_the_package(laboratory: Laboratory) -> None:
    """The same law on 1000 motions."""
    require_agreement(laboratory, seed=1, count=1000)


ORDER = """
async (url) => {
  const field = await import(url);
  const { constantsOf, follow } = await import("/engine/stepper.js");
  const period = field.period(field.parameters);
  const q = constantsOf(field, field.parameters);
  const end = (steps) => {
    const kept = new Float64Array(2 * (4 * steps + 1));
    const segment = { start: 0, length: period, phase: 0, share: 1, piece: 0, steps, repeats: 4 };
    follow(field, q, Float64Array.of(1, 0), [segment], 1, 1, kept);
    return kept[kept.length - 2];
  };
  const exact = end(512);
  return [16, 24, 32, 48].map((steps) => Math.abs(end(steps) - exact));
}
"""


def test_the_method_is_of_order_eight(laboratory: Laboratory) -> None:
    """Law: errors fall with the eighth power of the step, on a motion under a load in time."""
    model = page_model(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    laboratory.run(model, {"initial": [1.0, 0.0], "periods": 1})
    errors = np.array(laboratory.evaluate(ORDER, f"/fields/{model.id}.js"))
    slope = np.polyfit(np.log([16, 24, 32, 48]), np.log(errors), 1)[0]
    assert -9.5 < slope < -7.5, errors


ONE_STEP = """
async (h) => {
  const { NODES, STAGES, step } = await import("/engine/step.js");
  const motion = (y, i, q, w, k, out, j) => {
    out[j] = y[i + 1];
    out[j + 1] = -q[0] * Math.sin(y[i]) + w[k] * y[i] * y[i + 1];
  };
  const y = Float64Array.of(0.7, -0.3);
  const w = Float64Array.from(NODES, (node) => Math.cos(node * h));
  step(motion, y, 2, h, Float64Array.of(1.3), w, 0, 1, new Float64Array(2),
    new Float64Array(2 * STAGES));
  return [NODES, [...y]];
}
"""


@pytest.mark.parametrize("h", [0.3, 1.7])
def test_one_step_is_that_of_the_package(laboratory: Laboratory, h: float) -> None:
    """Law: the method is Cooper's and Verner's, whose order conditions the package checks.

    The rates are not linear, so that every coefficient shows.
    """
    method = default_method()

    def rates(node: int, y: list[Any]) -> list[Any]:
        load = np.cos(method.nodes[node] * h)
        return [y[1], -1.3 * np.sin(y[0]) + load * y[0] * y[1]]

    nodes, seen = laboratory.evaluate(ONE_STEP, h)
    np.testing.assert_allclose(nodes, method.nodes, rtol=1e-15)
    np.testing.assert_allclose(seen, method.step(rates, [0.7, -0.3], h), rtol=2e-15)


TIMES = """
async ([url, options]) => {
  const field = await import(url);
  const { integrate } = await import("/engine/motion.js");
  const [first, again] = [integrate(field, options), integrate(field, options)];
  const same = first.y.every((column, c) => column.every((one, k) => one === again.y[c][k]));
  return { t: [...first.t], load: [...first.observables[field.observable_names.indexOf("load")]],
    section: [...first.section.t], breaks: field.breaks, same };
}
"""


def times_of_run(laboratory: Laboratory, model: PageModel, **length: float) -> Any:
    options = {"initial": model.description["initial"], **length}
    laboratory.run(model, options)
    return laboratory.evaluate(TIMES, [f"/fields/{model.id}.js", options])


def test_steps_end_where_a_load_jumps(laboratory: Laboratory) -> None:
    """Law: every break is an instant of the curve, with the load after it; runs end as asked."""
    steps = rm.Steps([0.0, 1.3, 1.35, 7.77], [0.1, 0.2, 0.05, 0.3])
    seen = times_of_run(laboratory, page_model(rm.Actuator(), steps), duration=9.1)
    assert (np.diff(seen["t"]) > 0.0).all()
    assert seen["t"][-1] == pytest.approx(9.1, rel=1e-14)
    for time, load in zip(steps.times, steps.loads, strict=True):
        nearest = int(np.argmin(np.abs(np.array(seen["t"]) - time)))
        assert seen["t"][nearest] == pytest.approx(time, rel=1e-15)
        assert seen["load"][nearest] == load
    assert seen["section"] == []
    assert seen["same"]


@pytest.mark.parametrize("length", [{"periods": 3.4}, {"duration": 11.0}, {"periods": 0.3}])
def test_runs_are_as_long_as_asked(laboratory: Laboratory, length: dict[str, float]) -> None:
    """Law: whole periods and parts of one; the section is at whole periods, the load exact."""
    drive = rm.SineSquared(0.4, 1.25)
    period = float(drive.period or 0.0)
    seen = times_of_run(laboratory, page_model(rm.Actuator(), drive), **length)
    end = length.get("duration", length.get("periods", 0.0) * period)
    assert seen["t"][-1] == pytest.approx(end, rel=1e-12)
    np.testing.assert_allclose(seen["load"], drive(seen["t"]), atol=1e-14)
    whole = np.arange(int(end / period) + 1) * period
    np.testing.assert_allclose(seen["section"], whole, rtol=1e-14)


def test_samples_end_where_they_are_known(laboratory: Laboratory) -> None:
    """Law: a longer run than the table ends with it."""
    seen = times_of_run(
        laboratory, page_model(rm.Actuator(), rm.Sampled([0.0, 4.0, 6.0], [0.0, 0.1, 0.2])),
        duration=50.0,
    )  # fmt: skip
    assert seen["t"][-1] == pytest.approx(6.0, rel=1e-14)
    assert np.isfinite(seen["load"]).all()


def test_a_chaotic_motion_says_until_when_it_is_determined(laboratory: Laboratory) -> None:
    """Law: its error only grows, to the size of the motion; more steps determine it for longer."""
    system = rm.LagrangianSystem.example()
    model = page_model(system, rm.Sine(0.3, 1.0))
    options = {"initial": [0.0, 0.0], "periods": 200}
    rough, fine = (
        laboratory.run(model, {**options, "refine": refine}, 2000) for refine in (False, True)
    )
    for one in (rough, fine):
        assert one["status"] == "undetermined"
        assert "possible" in one["message"]
        assert (np.diff(one["error"]) >= 0.0).all()
        assert one["error"][-1] > 0.1
    assert 20.0 < rough["determinedUntil"] < fine["determinedUntil"] < fine["end"]


def test_a_motion_that_leaves_its_limits_ends_there(laboratory: Laboratory) -> None:
    """Law: curves end where the state has no meaning any more, and the status says so."""
    falling = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="-x**4/4 - load*x"
    )
    seen = laboratory.run(
        page_model(falling, rm.Constant(0.1)), {"initial": [0.5, 0.0], "duration": 50.0}
    )
    assert seen["status"] == "left"
    assert seen["end"] < 10.0
    assert f"{seen['end']:.4g}"[:3] in seen["message"]
    assert np.isfinite(seen["y"]).all()


def test_steps_that_are_too_long_are_not_taken_for_leaving(laboratory: Laboratory) -> None:
    """Law: a film that is much faster than its load is followed, with many steps in a period."""
    film = rm.Actuator(c=0.029, temperature=276.0, prestress=0.82)
    model = page_model(film, rm.Sine(0.56, 0.32, mean=0.1))
    seen = laboratory.run(model, {"initial": [1.0, 0.0], "periods": 20})
    assert seen["status"] in ("ok", "undetermined")
    assert seen["end"] == pytest.approx(20 * 2.0 * np.pi / 0.32)
    assert seen["steps"] > 100
    assert max(seen["error"][:10]) < 1e-4


def test_rest_stays_determined(laboratory: Laboratory) -> None:
    """Law: where nothing moves, rounding is not taken for a motion."""
    model = page_model(rm.Actuator(), rm.SineSquared(0.0, 1.25))
    seen = laboratory.run(model, {"initial": [1.0, 0.0], "periods": 500})
    assert seen["status"] == "ok"
    assert max(seen["error"]) < 1e-9
    assert np.ptp(seen["y"][0]) < 1e-12


def test_stated_errors_fall_when_asked_to(laboratory: Laboratory) -> None:
    """Law: a refined run of the default actuator states a thousandth of the error, or less."""
    model = page_model(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    options = {"initial": [1.0, 0.0], "periods": 500}
    usual = laboratory.run(model, options)
    refined = laboratory.run(model, {**options, "refine": True})
    assert usual["error"][-1] < 1e-4
    assert refined["error"][-1] < 1e-3 * usual["error"][-1]


POTENTIAL = """
async ([url, options]) => {
  const field = await import(url);
  const { potential } = await import("/engine/potential.js");
  const found = potential(field, options);
  return found && { ...found, x: [...found.x], observable: [...found.observable],
    curves: found.curves.map((one) => ({ ...one, energy: [...one.energy] })) };
}
"""


def potential(laboratory: Laboratory, model: PageModel, **further: Any) -> Any:
    options = {"initial": model.description["initial"], **further}
    laboratory.run(model, {**options, "duration": 1.0})
    return laboratory.evaluate(
        POTENTIAL, [f"/fields/{model.id}.js", {**options, "description": model.description}]
    )


@pytest.mark.parametrize(("m", "prestress"), [(0.16, 0.0), (0.3, 0.5)])
def test_equilibria_of_the_potential_are_those_of_the_package(
    laboratory: Laboratory, m: float, prestress: float
) -> None:
    """Law: places and stability agree; the curves are flat there."""
    actuator = rm.Actuator(prestress=prestress)
    found = potential(laboratory, page_model(actuator, rm.Constant(m)))
    assert [one["load"] for one in found["curves"]] == [0.0, m]
    for curve in found["curves"]:
        exact = rm.equilibria(actuator, curve["load"])
        seen = sorted(one["observable"] for one in curve["equilibria"])
        places = np.sort(exact["equilibrium_stretch"].values)
        np.testing.assert_allclose(seen, places, atol=1e-8)
        assert len(curve["equilibria"]) == 1
        assert curve["equilibria"][0]["stable"]
        lowest = found["x"][int(np.argmin(curve["energy"]))]
        assert abs(lowest - curve["equilibria"][0]["x"]) < 0.01


@pytest.mark.parametrize(
    ("drive", "extremes"),
    [
        (rm.SineSquared(0.4, 1.25), [0.16]),
        (rm.Sine(0.1, 1.0, mean=0.3), [0.2, 0.4]),
        (rm.Steps([0.0, 30.0, 60.0], [0.16, 0.32, 0.05]), [0.05, 0.32]),
        (rm.Sines([0.1, 0.1], [1.0, 2.0**0.5], 0.9, mean=0.3), [0.1, 0.5]),
    ],
)
def test_potentials_are_those_at_the_extremes_of_the_load(
    laboratory: Laboratory, drive: Any, extremes: list[float]
) -> None:
    """Law: without a load, at the least and at the largest; each load once."""
    found = potential(laboratory, page_model(rm.Actuator(), drive))
    loads = [one["load"] for one in found["curves"]]
    np.testing.assert_allclose(loads, [0.0, *extremes], atol=2e-3)


def test_two_wells_have_a_saddle_between_them(laboratory: Laboratory) -> None:
    """Law: Duffing's potential has stable rests at -1 and 1, and an unstable one at 0."""
    found = potential(
        laboratory, page_model(rm.LagrangianSystem.example(), rm.Constant(0.0)), low=-1.7
    )
    (curve,) = found["curves"]
    assert [one["stable"] for one in curve["equilibria"]] == [True, False, True]
    places = [one["x"] for one in curve["equilibria"]]
    np.testing.assert_allclose(places, [-1.0, 0.0, 1.0], atol=1e-6)


def test_two_coordinates_and_no_energy_have_no_potential(laboratory: Laboratory) -> None:
    """Law: nothing is drawn where there is no curve."""
    for system in (rm.Actuator(prestress=(0.0, 0.1)), rm.FirstOrderSystem.example()):
        assert potential(laboratory, page_model(system, rm.Constant(0.1))) is None

"""How long a page takes from a changed number to new curves, in the browser of the system.

Measured is the engine of the explorer alone: 500 drive periods from rest at two resolutions, with
everything that is drawn and its stated error.  Every run has another temperature.  Times are
medians after some runs have warmed the browser's compiler; the very first run is shown too.
"""

from __future__ import annotations

import shutil
import statistics
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import remanent as rm
from benchmarks.rows.plan import Plan
from remanent.models.drives.base import Drive
from remanent.page.files import assets_folder
from remanent.page.model import PageModel, page_model

#: Names under which the browser is looked for.
_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_ARGUMENTS = ("--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
_ORIGIN = "http://page.test/"
#: Drive periods of a run, and runs.
_PERIODS = 500
_RUNS, _QUICK_RUNS = 120, 12
#: Share of the runs that warm the compiler.
_WARMING = 0.25
_MEASURE = """
async ([url, initial, periods, runs]) => {
  const field = await import(url);
  const { integrate } = await import("/engine/motion.js");
  const times = [];
  let motion = null;
  for (let k = 0; k < runs; k += 1) {
    const parameters = { ...field.parameters };
    if ("temperature" in parameters) {
      parameters.temperature *= 1 + 1e-4 * k;
    }
    const started = performance.now();
    motion = integrate(field, { parameters, initial, periods });
    times.push(performance.now() - started);
    await new Promise((resolve) => setTimeout(resolve, 0));
  }
  return { times, steps: motion.stepsPerPeriod, error: motion.error[motion.error.length - 1] };
}
"""


def measure(plan: Plan) -> dict[str, Any]:
    """Milliseconds of runs of several systems; without a browser, the reason."""
    path = next((found for name in _BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        plan.say("explorer: left out, no Chromium is installed")
        return {"periods": _PERIODS, "systems": {}}
    runs = _QUICK_RUNS if plan.quick else _RUNS
    models = {name: page_model(system, drive) for name, (system, drive) in _systems().items()}
    with _page(path, models) as page:
        measured: dict[str, dict[str, float]] = {}
        for name, model in models.items():
            plan.say(f"explorer: {name}")
            address, initial = f"/fields/{model.id}.js", model.description["initial"]
            answer = page.evaluate(_MEASURE, [address, initial, _PERIODS, runs])
            warm = answer["times"][int(_WARMING * runs) :]
            measured[name] = {
                "first": answer["times"][0],
                "median": statistics.median(warm),
                "steps": answer["steps"],
                "error": answer["error"],
            }
    return {"periods": _PERIODS, "systems": measured}


def _systems() -> dict[str, tuple[Any, Drive]]:
    drive = rm.SineSquared(0.4, 1.25)
    gent = rm.Actuator(material=rm.Gent(30.0), dissipation=rm.Rayleigh(0.05))
    warm = rm.Actuator(dissipation=rm.Zener(0.5, 1.0), heat=rm.Heat())
    return {
        "the cube of the article": (rm.Actuator(), drive),
        "Gent, damped": (gent, drive),
        "Zener with heat": (warm, drive),
        "two stretches": (rm.Actuator(prestress=(0.0, 0.1)), drive),
    }


@contextmanager
def _page(path: str, models: dict[str, PageModel]) -> Iterator[Any]:
    """An empty page that finds the engine and the equations at its own address."""
    from playwright.sync_api import sync_playwright

    sources = {f"fields/{model.id}.js": model.field_source for model in models.values()}

    def answer(route: Any) -> None:
        name = route.request.url.removeprefix(_ORIGIN)
        if name in sources:
            route.fulfill(body=sources[name], content_type="text/javascript")
        elif name.startswith("engine/"):
            text = (assets_folder() / name).read_text(encoding="utf-8")
            route.fulfill(body=text, content_type="text/javascript")
        else:
            route.fulfill(body="<!doctype html><title>engine</title>", content_type="text/html")

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(_ARGUMENTS))
        try:
            page = browser.new_page()
            page.route("**/*", answer)
            page.goto(_ORIGIN)
            yield page
        finally:
            browser.close()

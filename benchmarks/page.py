"""The page of the results, with its pictures, written from the saved results."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks import figures, tables
from benchmarks.targets import Results

#: Where the page and its pictures are written.
DOCS = Path(__file__).parents[1] / "docs"
#: Waiting processes per processor above which the page warns.
_BUSY_WARNING = 0.2

_INTRODUCTION = """\
# Measured speed and errors

This page is written by `make bench`, each section from one run. Every tool gets the same work:
motions of equation (16) from rest under $m = (b \\sin\\omega\\tau)^2$, up to $\\tau = 100$. Each is
set so that its **worst error** in $\\lambda_3$ over the checked frequencies stays within
$10^{-8}$, by the cheapest of its settings that does; errors are differences from a solution in
extended precision (heyoka.py, tolerance $10^{-18}$). Times are medians, on one core, in
microseconds per trajectory and unit of $\\tau$; tools take turns. Compiling is shown apart.
"""
TARGETS = """\
*Measured* is how many times as fast as the other tool this package is, where the row says nothing
else; *at least* is what it has to reach, and *aim* what it should. *Met* is `aim` where the aim is
reached, and `yes` where only the least is. Ratios to other tools differ between processors; the
last section of the page names this one.
"""
_WORK = """\
Ours gives the extremes of $\\lambda_3$ over the whole motion, between steps too; the second of its
rows also gives an error for each. Ratios are to that row. For heyoka.py, extremes by events cost
more than the motion, since their callbacks are Python; the targets therefore compare with the
faster of two rows that are less work: the state at the end only, and "extremes at no cost", the
bare motion at the tolerance that its extremes need. diffrax, SciPy, pynamicalsys and Octave
give the end only, too, and are timed on the frequencies stated. The peers have the parameters
written in as numbers, and all but diffrax, where it gains nothing, the load as
$\\tfrac12 b^2 (1 - \\cos 2\\omega\\tau)$, which is faster than the square of a sine; ours takes
parameters as data. SciPy runs one motion after another, which is what the targets compare with,
and, in a row of its own, 1024 motions as one system.
"""
_FILM = """\
$c = 0.01$, $S = 1$, $b = 0.9$, $\\omega$ from 0.5 to 4: fast stretches of the motion, and steps
that should differ a hundredfold between frequencies.
"""
_PRECISION = """\
Time against achieved error, each point one setting. heyoka.py and SciPy give the end state only,
and their errors are those of the end state; ours are those of the extremes. Hollow markers are
settings at which some trajectories failed to meet the error bound.
"""
_KERNEL = """\
One double step of a group of *lanes*, the elements of two vectors of the processor, each of which
carries one motion: two steps and, for a bound, one step of a second solution and the comparison of
the two. By Runge–Kutta's method the second solution is one with twice the step, by Adams' method
the first with its errors amplified ([how](explanation/error-bound.md)). Numbers are operations per
trajectory that are always done, read from the assembly. The share of slots is that of the
instructions through the multiply–add units in what a loop of nothing but independent multiply–adds
issues in the same time on the same core; the share of operations counts a multiply–add as two.
Divisions, comparisons and moves take time and are not counted.
"""
_STEPS = """\
Steps taken over those of an oracle, which knows of every motion the least resolution with which
its true error meets the tolerance. *Resolution*: how much finer the steps of the last run were;
*runs*: time of all runs over that of those that were kept, pilots and attempts that missed the
tolerance included; *lanes*: steps of whole groups over those of their motions; *companion*: the
second solution, which tells the error. The last column is the median of
the stated bound over the true error. On one core; extremes but where states are named.
"""
_BRANCH = """\
The branch of the smallest orbit of the undamped actuator, 500 points down from $\\omega = 1.6$ to
1.15, with multipliers, and the same for 64 actuators (temperatures from 250 to 400 K, prestress
from 0 to 1) followed together. AUTO-07p, in the fastest form we found, uses 60 intervals with 4
collocation points and tolerance $10^{-8}$; its multipliers are then good to $10^{-4}$. Ours has the
loosest tolerance with which its orbits close after a period as well as AUTO's. Processor time.
"""
_LYAPUNOV = """\
The largest exponent over 500 drive periods, from rest, over $\\omega$ from 0.8 to 2 and $b$ from
0.2 to 1.2, each program at the loosest tolerance with which one period of 64 states on such motions
ends within $10^{-7}$ of what SciPy finds at $10^{-13}$. Ours runs everything once more with steps
twice as long, to give the exponent's error; pynamicalsys runs points drawn at random, once.
Processor time.
"""
_CHART = """\
Every point is a motion from rest of the undamped actuator at 350 K, labelled by the rules of
`classify` with tolerance $10^{-7}$.
"""
_BIAXIAL = """\
Six states: two stretches with their rates, and the viscous stretches of a branch with
$\\mu_v/\\mu = 0.5$, $t_r = 1$; $S = (0.3, 0)$, 4096 frequencies. Ours is `frequency_response`,
extremes between steps with their error; heyoka.py, in the fastest of its forms, gives the state at
the end only, each at the loosest tolerance with which its own results are within $10^{-8}$.
Processor time.
"""
_DOUBLE_WELL = """\
A system of one's own, $x'' + 0.15 x' - x + x^3 = m\\cos\\omega\\tau$ as a `LagrangianSystem`, from
rest in the right well, $m = 0.05$, $\\omega$ from 0.5 to 2. Ours is `frequency_response`, extremes
between steps with their error, and the same motion at one resolution without a bound; the others
give the last state only, each at the loosest tolerance with which its own results are within
$10^{-8}$ of what SciPy finds at $10^{-13}$. heyoka.py is shown in each of its forms. Processor
time.
"""
_DOUBLE_WELL_EXPONENTS = """\
The largest exponent of the double well over 500 drive periods, $\\omega$ from 0.8 to 1.6 and $m$
from 0.05 to 0.45, each tool at the loosest tolerance with which one period of 64 states on such
motions ends within $10^{-7}$. Ours runs everything once more with steps twice as long, to give the
exponent's error; the others run points drawn at random, once. Processor time.
"""
_GROWTH = """\
`frequency_response` at tolerance $10^{-8}$ on one core, each size in a process of its own after a
small run. Memory is the peak of the resident set less that before, and less the result.
"""
_STUDIES = """\
Lyapunov exponents over 20 drive periods on a grid of $b$ and $\\omega$: the verb called directly,
and the same study into a store, in this process and on workers of Dask with one thread each;
seconds of the wall clock, one core each. Memory is the peak of a whole process that fills a store.
"""
_START = """\
Whole processes, medians; "first figure" computes and draws a frequency response of 301 points.
"""
_EXPLORER = """\
From a changed temperature to new curves by the engine in the page: 500 drive periods at two
resolutions with the stated error, everything that is drawn, in the Chromium of the system, medians
once its compiler is warm. Drawing is not counted. A stated error of 1 says that
the two runs have parted: the motion is not known to its end.
"""


def write(results: Results) -> Path:
    """Write ``docs/results.md`` and ``docs/results/*.svg``."""
    (DOCS / "results").mkdir(exist_ok=True)
    path = DOCS / "results.md"
    path.write_text("\n".join(_page(results)).rstrip() + "\n", encoding="utf-8")
    return path


def _page(results: Results) -> Iterator[str]:
    yield _INTRODUCTION
    yield from warnings(results)
    yield from ("## Targets", "", tables.targets(results).markdown(), "")
    yield TARGETS
    for row, title, text, table in _SECTIONS:
        if row in results:
            data = results[row]["data"]
            yield from (f"## {title}", "", text, table(data).markdown() if table else "", "")
            yield from _details(row, data)
            yield from _pictures(row, data)
    yield from ("## The error estimate", "", "```{include} results/coverage.md\n```", "")
    yield from ("## Every other error", "", "```{include} results/errors.md\n```", "")
    yield from ("## The search for orbits", "", "```{include} results/orbit_search.md\n```", "")
    yield from ("## Machine and versions", "", tables.environment(results.values()).markdown())


def warnings(results: Results) -> Iterator[str]:
    """What is to be known of the runs: small sizes, a busy machine."""
    quick = [row for row, result in results.items() if result["quick"]]
    busy = [row for row, result in results.items() if result["busy"] > _BUSY_WARNING]
    if quick or busy:
        yield ":::{warning}"
        if quick:
            yield "Measured at small sizes only (`--quick`), which try the code and say little"
            yield f"about speed: {', '.join(quick)}."
        if busy:
            yield "Measured while other programs used the machine, so that times scatter and may be"
            yield f"too long: {', '.join(busy)}."
        yield ":::\n"


def _details(row: str, data: Any) -> Iterator[str]:
    if row not in ("response", "film"):
        return
    job = data["job"]
    samples = [f"{one['name']}: {one['timed_on']}" for one in data["tools"].values()
               if one["timed_on"] < job["count"]]  # fmt: skip
    yield (
        f"{job['count']} frequencies, {job['checked']} checked, "
        f"{data['unresolved']} left out because even the best of double precision is off by "
        f"more than 1e-9; median of {data['repeats']}."
    )
    if samples:
        yield "Timed on fewer frequencies: " + "; ".join(samples) + "."
    yield ""


def _pictures(row: str, data: Any) -> Iterator[str]:
    if row == "precision":
        for name, one in data.items():
            tools = "; ".join(curve["name"] for curve in one["curves"].values())
            file = f"precision-{name}.svg"
            figures.precision(one, DOCS / "results" / file)
            yield _figure(file, _CAPTIONS[name], f"{_PRECISION_SEEN}: {tools}")
    elif row == "growth":
        figures.growth(data, DOCS / "results" / "growth.svg")
        yield _figure("growth.svg", _GROWTH_CAPTION, _GROWTH_SEEN)
    elif row == "chart" and (DOCS / "results" / "chart.png").exists():
        yield _figure("chart.png", _CHART_CAPTION, _CHART_SEEN)


def _figure(file: str, caption: str, seen: str) -> str:
    return f"```{{figure}} results/{file}\n:alt: {seen}\n\n{caption}\n```\n"


_CHART_CAPTION = """\
Tori by their rotation number, chaos by its exponent; grey is undecided after 500 periods. On the
line a pair of orbits of the primary resonance is born."""
_CHART_SEEN = (
    "A map of the plane of frequency and amplitude of the load in colours of the rotation number, "
    "with grey bands of undecided motions and a line along which orbits are born"
)
_PRECISION_SEEN = (
    "Two panels with logarithmic axes, the worst and the median error falling to the right and the "
    "time rising; a curve of settings for each of"
)
_GROWTH_SEEN = (
    "Two panels with logarithmic axes, time and memory against the number of trajectories; memory "
    "has one curve for the result and one for what is used beyond it"
)
_GROWTH_CAPTION = "Time (a), and memory of the result and beyond it (b)."
_CAPTIONS = {
    "response": "The cube: time against the worst error (a) and the median one (b).",
    "film": "The film: the same.",
}
_SECTIONS: tuple[tuple[str, str, str, Any], ...] = (
    ("response", "Frequency response of a cube", _WORK, tables.work),
    ("film", "Frequency response of a film", _FILM, tables.work),
    ("precision", "Work and precision", _PRECISION, None),
    ("kernel", "Arithmetic", _KERNEL, tables.kernel),
    ("steps", "Where the work goes", _STEPS, tables.steps),
    ("branch", "Branches of periodic orbits", _BRANCH, tables.branch),
    ("lyapunov", "Lyapunov exponents", _LYAPUNOV, tables.lyapunov),
    ("chart", "A chart of regimes", _CHART, tables.chart),
    ("biaxial", "Two directions with a Zener branch", _BIAXIAL, tables.at_equal_error),
    ("double_well", "A system of one's own", _DOUBLE_WELL, tables.at_equal_error),
    (
        "double_well_exponents",
        "Lyapunov exponents of a system of one's own",
        _DOUBLE_WELL_EXPONENTS,
        tables.at_equal_error,
    ),
    ("growth", "Growth", _GROWTH, tables.growth),
    ("studies", "Studies in stores", _STUDIES, tables.studies),
    ("start", "Start", _START, tables.start),
    ("explorer", "The page of the explorer", _EXPLORER, tables.explorer),
)

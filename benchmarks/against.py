"""Times of this tree over those of another commit: ``python -m benchmarks.against COMMIT``.

Two processes, one for each tree, take turns at every call, so that both see the same machine.
The calls use public names only.  A name that the other commit lacks is left out.
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

ROOT = Path(__file__).parent.parent
#: Calls of the rows that measure this package alone, and of every family of verbs.
CALLS = {
    "response": "rm.frequency_response(hot, drive, np.linspace(0.5, 2.0, 4001))",
    "film": "rm.frequency_response(rm.Actuator(temperature=350.0, c=0.01), drive, "
    "np.linspace(0.5, 2.0, 1001))",
    "biaxial": "rm.frequency_response(rm.Actuator(temperature=350.0, prestress=(0.3, 0.0), "
    "dissipation=rm.Zener(0.5, 1.0)), drive, np.linspace(0.5, 2.0, 512), duration=100.0, "
    "tolerance=1e-8, resonance_width=10.0)",
    "lyapunov": "rm.lyapunov(hot, drive, periods=100, over={'omega': np.linspace(0.8, 2.0, 64), "
    "'b': np.linspace(0.2, 1.2, 32)}, tolerance=1e-6)",
    "chart": "rm.regime_chart(hot, drive, {'b': np.linspace(0.1, 1.6, 24), "
    "'omega': np.linspace(0.4, 2.2, 24)}, periods=200, tolerance=1e-7)",
    "branch": "rm.continue_orbit(damped, drive, 'omega', (0.8, 1.8))",
    "periodic_orbits": "rm.periodic_orbits(damped, drive)",
    "response_diagram": "rm.response_diagram(hot, drive, (1.1, 1.4))",
    "bifurcation_diagram": "rm.bifurcation_diagram(rm.Actuator(), rm.SineSquared(0.4, 0.8), 'b', "
    "np.linspace(0.1, 1.2, 40))",
    "strong_chart": "rm.regime_chart(rm.Actuator(), drive, {'b': np.linspace(0.8, 2.5, 12), "
    "'omega': np.linspace(0.5, 1.6, 12)}, periods=300)",
    "long_response": "rm.frequency_response(rm.Actuator(), drive, np.linspace(0.5, 2.0, 256), "
    "duration=2000.0, tolerance=1e-6)",
    "strong_response": "rm.frequency_response(hot, rm.SineSquared(1.2, 1.0), "
    "np.linspace(0.5, 2.0, 301))",
    "biaxial_orbits": "rm.periodic_orbits(rm.Actuator(prestress=(0.3, -0.2), "
    "dissipation=rm.Zener(0.5, 0.7)), drive)",
    "simulate": "rm.simulate(hot, drive, duration=100.0, over={'b': np.linspace(0.1, 0.9, 100)})",
    "resonances": "rm.resonances(damped, drive, (0.5, 2.0))",
    "backbone": "rm.backbone(rm.Actuator(), np.linspace(1.05, 1.5, 50))",
    "equilibria": "rm.equilibria(rm.Actuator(), 0.16)",
    "snap_through": "rm.snap_through(rm.Actuator(prestress=0.3), 'm', (0.0, 0.5))",
    "step_response": "rm.step_response(damped, rm.Constant(0.5), duration=100.0)",
    "shape_command": "rm.shape_command(rm.Actuator(), 1.3)",
    "sensitivity": "rm.sensitivity(rm.simulate, damped, drive, times=[3.0], "
    "of=lambda ds: ds.stretch, parameters=['c', 'b'])",
}
#: Whole processes, timed by themselves.
STARTS = {
    "import": "import remanent",
    "import plot": "import remanent; remanent.plot",
    "first figure": "import io, numpy as np, remanent as rm; "
    "ds = rm.frequency_response(rm.Actuator(), rm.SineSquared(0.4, 1.0), "
    "np.linspace(0.5, 2.0, 301)); "
    "rm.plot.response(ds)[0].get_figure().savefig(io.BytesIO())",
}
#: What runs in the process of a tree: answers every name of a call by its processor time.
_SERVER = f"""
import sys, time
import numpy as np
import remanent as rm
hot, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.25)
damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
calls = {CALLS!r}
for name in sys.stdin:
    begin = time.process_time()
    try:
        eval(calls[name.strip()])
        print(time.process_time() - begin, flush=True)
    except Exception as error:
        print("nan", flush=True)
        print(name.strip(), error, file=sys.stderr)
"""


@click.command()
@click.argument("commit")
@click.argument("names", nargs=-1, type=click.Choice([*CALLS, *STARTS]))
@click.option("--repeats", default=9, help="Calls of each kind in each tree.")
def main(commit: str, names: tuple[str, ...], repeats: int) -> None:
    """Print medians of processor time in COMMIT and here, and their ratio."""
    click.echo(f"{'milliseconds':18s} {commit[:10]:>10s} {'here':>10s} {'ratio':>7s}")
    with _tree_of(commit) as other:
        for name in names or (*CALLS, *STARTS):
            times = _alternating(name, (other, ROOT), repeats)
            before, here = (1e3 * statistics.median(column) for column in zip(*times, strict=True))
            ratio = statistics.median(b / a for a, b in times)
            click.echo(
                f"{name:18s} {before:10.1f} {here:10.1f} {ratio:7.2f}"
                if math.isfinite(ratio)
                else f"{name:18s} cannot be called in both"
            )


def _alternating(name: str, trees: tuple[Path, Path], repeats: int) -> list[list[float]]:
    """Seconds in both trees, which take turns; the first call of each does not count."""
    if name in STARTS:
        code = STARTS[name]
        return [[_seconds_of_process(tree, code) for tree in trees] for _ in range(repeats)]
    servers = [_process(tree, _SERVER) for tree in trees]
    try:
        return [[_answer(server, name) for server in servers] for _ in range(repeats + 1)][1:]
    finally:
        for server in servers:
            server.communicate()


def _answer(server: subprocess.Popen[str], name: str) -> float:
    assert server.stdin is not None
    assert server.stdout is not None
    server.stdin.write(f"{name}\n")
    server.stdin.flush()
    return float(server.stdout.readline())


def _seconds_of_process(tree: Path, code: str) -> float:
    """Processor time of a whole process."""
    before = sum(os.times()[2:4])
    _process(tree, code).communicate()
    return sum(os.times()[2:4]) - before


def _process(tree: Path, code: str) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    environment = {**os.environ, "PYTHONPATH": str(tree / "src"), "MPLBACKEND": "Agg"}
    command = [sys.executable, "-W", "ignore", "-c", code]
    return subprocess.Popen(
        command, stdin=pipe, stdout=pipe, text=True, env=environment, cwd=tempfile.gettempdir()
    )


@contextmanager
def _tree_of(commit: str) -> Iterator[Path]:
    """The files of a commit, in a work tree that is removed afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(tree), commit], check=True)
        try:
            yield tree
        finally:
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)


if __name__ == "__main__":
    main()

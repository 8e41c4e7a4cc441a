"""The command: ``python -m tests.adequacy --sample 300 --seed 1``.

Mutants of a random sample of the numeric core are judged by the tests that run their line, as
``make coverage`` has recorded it.  Every verdict is written at once, so that the same command
goes on where it was stopped.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Sequence
from datetime import date
from pathlib import Path

import click

from benchmarks import store
from benchmarks.machine import environment
from tests.adequacy import mutants, trial, verdicts
from tests.adequacy.core import NUMERIC_CORE, PACKAGE, package_of
from tests.adequacy.covering import CoveringTests
from tests.adequacy.durations import DURATIONS, MEASURED
from tests.adequacy.mutants import Mutant

#: Every how many mutants the same tests are run without a change, which they must pass.
_CONTROL_EVERY = 10


@click.command()
@click.option("--sample", "size", default=300, show_default=True, help="How many mutants.")
@click.option("--seed", default=1, show_default=True, help="Which sample.")
@click.option("--seconds", default=8.0, show_default=True, help="Of tests for each mutant.")
@click.option("--only", multiple=True, help="Judge only mutants of these packages.")
@click.option("--again", is_flag=True, help="Judge survivors again.")
@click.option("--save", is_flag=True, help="Keep the score among the results of benchmarks.")
def main(
    size: int, seed: int, seconds: float, only: tuple[str, ...], again: bool, save: bool
) -> None:
    """The mutation score of the numeric core."""
    covering = CoveringTests.read(MEASURED / "coverage", DURATIONS)
    file = MEASURED / f"mutants-{seed}.jsonl"
    with tempfile.TemporaryDirectory(dir=MEASURED) as folder:
        copy = trial.copy_repository(Path(folder))
        drawn = mutants.sample(copy, size=size, seed=seed)
        wanted = [m for m in drawn if not only or package_of(m.file) in only]
        _judge_sample(copy, wanted, covering, file, seconds=seconds, again=again)
    found, at_first = verdicts.read(file), verdicts.read(file, first=True)
    names = [mutant.name for mutant in drawn if mutant.name in found]
    sample = [found[name] for name in names]
    table = verdicts.scores(sample)
    for package, row in table.items():
        click.echo(f"{package:12} " + "  ".join(f"{key} {value}" for key, value in row.items()))
    if save:
        before = verdicts.scores([at_first[name] for name in names])["in all"]
        about = {"seed": seed, "seconds": seconds, "core": NUMERIC_CORE, "at first": before}
        _save({**about, "packages": table}, sample)


def _judge_sample(
    copy: Path,
    drawn: Sequence[Mutant],
    covering: CoveringTests,
    file: Path,
    *,
    seconds: float,
    again: bool,
) -> None:
    """Write a verdict on each mutant that has none, and on survivors if asked."""
    trial.prepare()
    done = verdicts.read(file)
    for number, mutant in enumerate(drawn):
        old = done.get(mutant.name)
        if old is not None and (verdicts.is_killed(old) or not again):
            continue
        covering_tests = covering.of(mutant.file, mutants.statement_lines(copy, mutant))
        tests = covering.first(covering_tests, seconds)
        found = _judge(copy, mutant, tests, covering.duration(tests))
        verdicts.append(file, found)
        click.echo(f"{number + 1:4} {found.verdict:11} {found.tests:4} tests  {mutant.name}")
        if number % _CONTROL_EVERY == 0:
            _control(copy, mutant, tests, covering.duration(tests))


def _judge(copy: Path, mutant: Mutant, tests: Sequence[str], alone: float) -> verdicts.Finding:
    """What `tests`, which take so long without a change, say of a mutant."""
    before = (copy / PACKAGE / mutant.file).read_text("utf-8")
    after = mutants.mutated(copy, mutant)
    verdict = trial.judge(copy, MEASURED / "cache", mutant.file, after, tests, alone)
    return verdicts.finding(mutant, before, after, len(tests), verdict)


def _control(copy: Path, mutant: Mutant, tests: Sequence[str], alone: float) -> None:
    """Tests that fail without a change say nothing of a mutant."""
    text = (copy / PACKAGE / mutant.file).read_text("utf-8")
    if trial.judge(copy, MEASURED / "cache", mutant.file, text, tests, alone).is_kill:
        raise click.ClickException(f"Without a change, one of these fails: {', '.join(tests)}")


def _save(result: dict[str, object], sample: Sequence[verdicts.Finding]) -> None:
    """Write the score, and every mutant that no test saw."""
    kept = [vars(one) for one in sample if not verdicts.is_killed(one)]
    about = {"date": str(date.today()), "environment": environment()}
    store.save("tests/mutants", {**about, **result, "not killed": kept})


if __name__ == "__main__":
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    sys.exit(main())

"""What was found about mutants: a line of JSON for each, and the score."""

from __future__ import annotations

import json
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scipy.stats import binomtest

from tests.adequacy.core import package_of
from tests.adequacy.trial import Verdict

if TYPE_CHECKING:  # counting needs nothing of what makes mutants
    from tests.adequacy.mutants import Mutant

_EQUIVALENT_FILE: Final = Path(__file__).with_name("equivalent.toml")
_EQUIVALENT: Final = "equivalent"


@dataclass(frozen=True)
class Finding:
    """What the tests said of a mutant.

    Parameters
    ----------
    mutant : str
        Its name.
    before, after : str
        The lines that differ, without the change and with it.
    tests : int
        How many tests had the chance to fail.
    verdict : str
        A :class:`Verdict`.
    """

    mutant: str
    before: str
    after: str
    tests: int
    verdict: str

    @property
    def file(self) -> str:
        """The file, relative to the package."""
        return self.mutant.partition(":")[0]


def finding(mutant: Mutant, before: str, after: str, tests: int, verdict: Verdict) -> Finding:
    """A finding with the lines in which two texts of a file differ."""
    old, new = before.splitlines(), after.splitlines()
    head = next(i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b)
    pairs = enumerate(zip(reversed(old[head:]), reversed(new[head:]), strict=False))
    tail = next((i for i, (a, b) in pairs if a != b), min(len(old), len(new)) - head)
    removed, added = (
        "\n".join(line.strip() for line in text[head : len(text) - tail]) for text in (old, new)
    )
    return Finding(mutant.name, removed, added, tests, str(verdict))


def append(file: Path, new: Finding) -> None:
    """Add a line."""
    file.parent.mkdir(exist_ok=True)
    with file.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(asdict(new), ensure_ascii=False) + "\n")


def read(file: Path, *, first: bool = False) -> dict[str, Finding]:
    """The last finding about each mutant, or the first, before tests were written for it."""
    if not file.exists():
        return {}
    lines = [json.loads(line) for line in file.read_text("utf-8").splitlines()]
    return {line["mutant"]: Finding(**line) for line in (reversed(lines) if first else lines)}


def equivalent_mutants() -> dict[tuple[str, str, str], str]:
    """Why a mutant is equivalent, by its file and the lines before and after."""
    entries = tomllib.loads(_EQUIVALENT_FILE.read_text("utf-8"))["mutant"]
    return {(e["file"], e["before"], e["after"]): e["reason"] for e in entries}


def is_killed(found: Finding) -> bool:
    """Whether the tests saw the mutant."""
    return Verdict(found.verdict).is_kill


def scores(found: Iterable[Finding]) -> dict[str, dict[str, Any]]:
    """By package and in all: how many of each verdict, and the score with its interval."""
    reasons = equivalent_mutants()
    counts: dict[str, Counter[str]] = {}
    for one in found:
        is_equivalent = (one.file, one.before, one.after) in reasons and not is_killed(one)
        verdict = _EQUIVALENT if is_equivalent else one.verdict
        for group in (package_of(one.file), "in all"):
            counts.setdefault(group, Counter())[verdict] += 1
    names = sorted(set(counts) - {"in all"})
    return {name: _score(counts[name]) for name in (*names, "in all") if name in counts}


def _score(counts: Mapping[str, int]) -> dict[str, Any]:
    """Killed among those that could be, with an interval that holds with 95 %."""
    judged = sum(counts.values()) - counts.get(_EQUIVALENT, 0)
    killed = counts.get(Verdict.KILLED, 0) + counts.get(Verdict.TIMEOUT, 0)
    interval = binomtest(killed, judged).proportion_ci(method="wilson") if judged else (0.0, 1.0)
    return {
        "mutants": sum(counts.values()),
        "killed": counts.get(Verdict.KILLED, 0),
        "time ran out": counts.get(Verdict.TIMEOUT, 0),
        "survived": counts.get(Verdict.SURVIVED, 0),
        "run by no test": counts.get(Verdict.UNCOVERED, 0),
        "equivalent": counts.get(_EQUIVALENT, 0),
        "score": round(killed / judged, 4) if judged else None,
        "interval": [round(float(end), 4) for end in interval],
    }

"""How coverage and the mutation score are counted."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.adequacy import trial, verdicts
from tests.adequacy.core import NUMERIC_CORE, PACKAGE, ROOT, core_files, is_core
from tests.adequacy.coverage import shares
from tests.adequacy.covering import CoveringTests, _imported_files
from tests.adequacy.trial import Verdict
from tests.adequacy.verdicts import Finding

on_posix = pytest.mark.skipif(not hasattr(os, "fork"), reason="trials are forked")


def found(mutant: str, verdict: Verdict, after: str = "x = 2") -> Finding:
    return Finding(mutant, "x = 1", after, 3, str(verdict))


def test_every_part_of_the_core_has_files_and_no_other_file_is_in_it() -> None:
    """A package that is renamed does not leave the core in silence."""
    files = core_files()
    for part in NUMERIC_CORE:
        assert any(file == part or file.startswith(f"{part}/") for file in files), part
    assert not is_core("studies/sweep/store.py")
    assert not is_core("modelsque/file.py")


def test_the_share_of_a_package_counts_lines_and_branches_alike() -> None:
    """Of 10 lines and 6 branches in two files, 8 and 4 are run: 12 of 16."""
    counts = {
        "models/a.py": (6, 5, 4, 3),
        "models/b.py": (4, 3, 2, 1),
        "web/c.py": (4, 0, 0, 0),
    }
    keys = ("num_statements", "covered_lines", "num_branches", "covered_branches")
    table = shares({file: dict(zip(keys, row, strict=True)) for file, row in counts.items()})
    assert table["models"]["share"] == table["numeric core"]["share"] == 12 / 16
    assert table["web"]["share"] == 0
    assert table["in all"]["share"] == 12 / 20


def test_a_score_leaves_out_what_is_equivalent_and_counts_what_no_test_runs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Killed and out of time, over all but the equivalent that survived."""
    same = {("models/a.py", "x = 1", "x = 1.0"): "A number is the same as a float."}
    monkeypatch.setattr(verdicts, "equivalent_mutants", lambda: same)
    table = verdicts.scores(
        [
            found("models/a.py:1:4 A", Verdict.KILLED),
            found("models/a.py:2:4 A", Verdict.TIMEOUT),
            found("models/a.py:3:4 A", Verdict.SURVIVED),
            found("models/a.py:4:4 A", Verdict.UNCOVERED),
            found("models/a.py:5:4 A", Verdict.SURVIVED, "x = 1.0"),
            found("analysis/b.py:1:4 A", Verdict.KILLED, "x = 1.0"),
        ]
    )
    assert table["models"]["score"] == 2 / 4
    assert table["models"]["equivalent"] == 1
    assert table["analysis"]["score"] == 1
    assert table["in all"]["score"] == 3 / 5
    low, high = table["in all"]["interval"]
    assert low < 3 / 5 < high


def test_findings_are_kept_and_the_last_of_a_mutant_counts(tmp_path: Path) -> None:
    """A survivor that is judged again has its new verdict; the first one is not lost."""
    file = tmp_path / "new" / "mutants.jsonl"
    for verdict in (Verdict.SURVIVED, Verdict.KILLED):
        verdicts.append(file, found("models/a.py:1:4 A", verdict))
    verdicts.append(file, found("models/a.py:2:4 A", Verdict.SURVIVED))
    kept = verdicts.read(file)
    assert [one.verdict for one in kept.values()] == ["killed", "survived"]
    at_first = verdicts.read(file, first=True)
    assert {one.verdict for one in at_first.values()} == {"survived"}


def test_the_tests_of_a_line_are_those_that_run_it_and_the_nearest_come_first() -> None:
    """A line that runs at import is held by every test of its file; one that never runs by none."""
    near, fast, other = "tests/unit/models/test_a.py::t", "tests/x.py::fast", "tests/x.py::other"
    lines = {1: frozenset[str](), 5: frozenset({fast, near}), 6: frozenset({other})}
    covering = CoveringTests({"models/a.py": lines}, {near: 3.0, fast: 1.0, other: 2.0})
    assert covering.of("models/a.py", [5]) == [near, fast]
    assert covering.of("models/a.py", [1]) == [near, fast, other]
    assert covering.of("models/a.py", [9]) == []
    assert covering.first([near, fast, other], 4.5) == [near, fast]
    assert covering.first([near, fast, other], 0.5) == [near]


def test_values_are_held_by_the_tests_of_the_files_that_import_them() -> None:
    """A file of constants runs at import only, and no test is known to run it."""
    text = "from remanent.models.values import LIMIT\nimport numpy\nfrom remanent import _threads\n"
    assert [*_imported_files(text)] == ["models/values.py"]
    lines = {"models/a.py": {3: frozenset({"t"})}, "models/values.py": {1: frozenset[str]()}}
    covering = CoveringTests(lines, {"t": 1.0}, {"models/values.py": ["models/a.py"]})
    assert covering.of("models/values.py", [1]) == ["t"]
    assert covering.of("models/values.py", [2]) == []


def test_a_changed_file_comes_back_as_it_was_and_has_a_time_of_its_own(tmp_path: Path) -> None:
    """Python tells compiled files of two texts of equal length apart by their times."""
    file = tmp_path / "a.py"
    file.write_text("x = 1\n")
    before = file.stat().st_mtime_ns
    times = set()
    for text in ("x = 2\n", "x = 3\n"):
        with trial.changed(file, text):
            assert file.read_text() == text
            times.add(file.stat().st_mtime_ns)
    assert len(times | {before}) == 3
    assert (file.read_text(), file.stat().st_mtime_ns) == ("x = 1\n", before)


@on_posix
@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        ("def half(x): return x / 2", Verdict.SURVIVED),
        ("def half(x): return x * 2", Verdict.KILLED),
        ("def half(x): return x // 2", Verdict.SURVIVED),
        ("def half(x): raise SystemExit", Verdict.KILLED),
    ],
)
def test_a_mutant_is_killed_by_a_test_that_fails(
    tmp_path: Path, text: str, verdict: Verdict
) -> None:
    """A test of one value sees another value, but not a change that keeps that value."""
    tree, cache = tmp_path / "tree", tmp_path / "cache"
    (tree / PACKAGE).mkdir(parents=True)
    (tree / PACKAGE / "half.py").write_text("def half(x): return x / 2")
    (tree / "test_half.py").write_text(
        "import runpy\n\n"
        "def test_half():\n"
        f"    assert runpy.run_path('{PACKAGE.as_posix()}/half.py')['half'](4) == 2\n"
    )
    cache.mkdir()
    tests = ["test_half.py::test_half"]
    assert trial.judge(tree, cache, "half.py", text, tests, 0.1) is verdict
    assert trial.judge(tree, cache, "half.py", text, [], 0.0) is Verdict.UNCOVERED


@on_posix
@pytest.mark.slow
def test_a_mutant_that_never_ends_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A loop without an end takes the processor's time that it is given, and no more."""
    monkeypatch.setattr(trial, "_START_SECONDS", 3.0)
    (tmp_path / "cache").mkdir()
    (tmp_path / PACKAGE).mkdir(parents=True)
    (tmp_path / PACKAGE / "half.py").write_text("")
    (tmp_path / "test_half.py").write_text("def test_half():\n    while True: pass\n")
    tests = ["test_half.py::test_half"]
    verdict = trial.judge(tmp_path, tmp_path / "cache", "half.py", "x = 1", tests, 0.0)
    assert verdict is Verdict.TIMEOUT


class TestMutants:
    """With the changes of Cosmic Ray, where it is installed."""

    @pytest.fixture
    def root(self, tmp_path: Path) -> Path:
        (tmp_path / PACKAGE).mkdir(parents=True)
        return tmp_path

    @pytest.mark.parametrize(
        ("text", "changes"),
        [
            ("def f(x: int | None) -> int | None: ...", 0),
            ("@cache\ndef f(): ...", 0),
            ("y = list(zip(a, b, strict=True))", 0),
            ("def f(a, *, b): ...", 0),
            ("y = a + b", 6),
            ("y = a | b", 4),
            ("y = a < b", 5),
            ("y = a is b", 1),
            ("y = 3", 2),
        ],
    )
    def test_only_what_runs_is_changed(self, root: Path, text: str, changes: int) -> None:
        """Signs of numbers become signs of numbers; what has no effect is left alone."""
        pytest.importorskip("cosmic_ray")
        from tests.adequacy import mutants

        (root / PACKAGE / "a.py").write_text(text)
        variants = [mutant for site in mutants.sites_of(root, "a.py") for mutant in site]
        texts = {mutants.mutated(root, m) for m in variants if mutants.is_mutant(root, m)}
        assert len(texts) == changes
        assert text not in texts

    def test_a_statement_is_its_head_without_its_body(self, root: Path) -> None:
        """A test that runs the body of a loop need not say anything of what follows it."""
        pytest.importorskip("cosmic_ray")
        from tests.adequacy import mutants

        text = "for i in range(\n    3\n):\n    f(i)\ng(\n    4\n)\n"
        (root / PACKAGE / "a.py").write_text(text)
        three, four = (
            next(m for site in mutants.sites_of(root, "a.py") for m in site if m.start == start)
            for start in ((2, 4), (6, 4))
        )
        assert list(mutants.statement_lines(root, three)) == [1, 2, 3]
        assert list(mutants.statement_lines(root, four)) == [5, 6, 7]

    def test_a_sample_depends_on_its_seed_alone(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The same seed draws the same mutants, a longer sample begins with the shorter one."""
        pytest.importorskip("cosmic_ray")
        from tests.adequacy import mutants

        monkeypatch.setattr(mutants, "core_files", lambda _root: ["integrate/ensemble/counts.py"])
        few = mutants.sample(ROOT, size=5, seed=1)
        assert mutants.sample(ROOT, size=9, seed=1)[:5] == few
        assert mutants.sample(ROOT, size=5, seed=2) != few
        assert len({m.start for m in mutants.sample(ROOT, size=9, seed=1)}) == 9

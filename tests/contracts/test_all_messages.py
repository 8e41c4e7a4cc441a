"""Every message is a help: rules that hold for all of them, read from the source.

``python -m tests.contracts.messages`` prints the list.  What a verb says of a bad argument when it
is called is tried in ``test_messages.py``; here is what no call of a test may ever lead to.
"""

from __future__ import annotations

import inspect
import re

import pytest

import remanent as rm
from remanent.studies.sweep.faults import Fault
from tests.contracts.messages import PARTS, bare, collected, messages_of

MESSAGES = collected()
#: Parts of messages, each once, with one of the places where it is said.
TEXTS = {
    (name, text): f"{message.file}:{message.line}"
    for message in MESSAGES
    for name, text in message.parts.items()
    if message.call != "echo"
}
#: With what a remedy begins: what to do.
VERBS = """
    Add Ask Average Build Call Cancel Change Check Compute Convert Correct Create Define Drop
    Exchange Fit Give Go Install Join Leave Look Make Measure Move Name Open Pass Put Raise Read
    Reduce Remove Rename Rescale Run Save Say Select Shift Shorten Sort Start Store Take Try Use
    Vary Wait Widen Write
"""
#: Words of the developers, and words that blame.
REFUSED_WORDS = """
    arg args assertion bad batch chunk dtype fallback illegal invalid kernel kwarg kwargs lowered
    ndarray payload segment silly subclass tile traceback vectorised wrong
"""
#: What a user does not meet: messages to who adds a variable of results or a part of the page.
TO_DEVELOPERS = frozenset({"results/schema.py"})


def faults(rule: str, name: str = "") -> list[str]:
    """Places and texts of parts that a rule, a pattern of a whole text, does not match."""
    return [
        f"{place}  {part}: {text}"
        for (part, text), place in TEXTS.items()
        if part == (name or part) and not re.fullmatch(rule, text, re.DOTALL)
    ]


def test_there_are_messages() -> None:
    """They are found, with all their parts: else nothing here could fail."""
    assert len(MESSAGES) > 400
    (one,) = messages_of("x.py", 'raise InputError("n", must="be " + a, got=b, why="W.", fix="F.")')
    assert one.text == "`{name}` must be {a}; got {got}. W. F."
    two = messages_of("x.py", 'warn_of_input("one" if a else f"two {b}")')
    assert [message.text for message in two] == ["one", "two {b}"]


def test_errors_of_arguments_have_all_parts() -> None:
    """None can be made without its rule, what was given, its reason and its remedy."""
    for made in (rm.InputError, Fault):
        asked = inspect.signature(made).parameters
        assert all(asked[part].default is inspect.Parameter.empty for part in PARTS)


def test_rules_follow_the_word_must() -> None:
    """A rule goes on after "must": a verb, without a capital and without a full stop."""
    assert not faults(r"(\{.*|(not )?[a-z].*)(?<!\.)", "must")


@pytest.mark.parametrize("part", ["why", "fix"])
def test_reasons_and_remedies_are_whole_sentences(part: str) -> None:
    """With a capital, a name or a number first, and a full stop at the end."""
    assert not faults(r"([A-Z\[{`0-9].*[.?…]|.*\})", part)


def test_whole_messages_are_whole_sentences() -> None:
    """Warnings, and errors about no argument."""
    broken = [
        f"{m.file}:{m.line}: {m.text}"
        for m in MESSAGES
        if "whole" in m.parts
        and m.call not in {"echo", "reason"}
        and not re.fullmatch(r"[A-Z`{\"].*[.}]", m.text, re.DOTALL)
    ]
    assert not broken


def test_reasons_of_points_are_clauses() -> None:
    """They follow their status and a colon; those of a whole result are sentences."""
    assert not [
        f"{m.file}:{m.line}: {m.text}"
        for m in MESSAGES
        if m.call == "reason" and not re.fullmatch(r"[A-Z].*\.|[a-z].*[^.]", m.text)
    ]


def test_remedies_say_what_to_do() -> None:
    """They begin with a verb, perhaps after a question that names what was meant."""
    begin = re.compile(r"(?:\{[^}]*\})?([A-Z][a-z]+)")
    verbs = VERBS.split()
    lost = [
        f"{place}: {text}"
        for (part, text), place in TEXTS.items()
        if part == "fix" and (first := begin.match(text)) is not None and first[1] not in verbs
    ]
    assert not lost


def test_words_are_those_of_users() -> None:
    """No word of the developers, and none that blames in place of the rule."""
    found = [
        f"{place}: {text}"
        for (_, text), place in TEXTS.items()
        if {*REFUSED_WORDS.split()} & set(re.findall(r"[a-z]+", bare(text).lower()))
    ]
    assert not found


def test_no_part_of_the_source_is_named() -> None:
    """No module, no private name and no file of the package."""
    private = re.compile(
        r"(?<![\w.-])_(?!error)[a-z]\w+|remanent[./](?!save|load)\w+[./]\w+|\.py\b"
    )
    found = [
        f"{place}: {text}"
        for (_, text), place in TEXTS.items()
        if private.search(bare(text)) and place.partition(":")[0] not in TO_DEVELOPERS
    ]
    assert not found


def test_marks_come_in_pairs() -> None:
    """Backticks and brackets are closed, and blanks are single."""
    for (_, text), place in TEXTS.items():
        assert bare(text).count("`") % 2 == 0, f"{place}: {text}"
        assert "  " not in text, f"{place}: {text}"
        opened, closed = (sum(map(text.count, marks)) for marks in ("([{", ")]}"))
        assert opened == closed, f"{place}: {text}"  # of either kind, as in [0, 1)
        assert not re.search(r" [.,;](\s|$)", text), f"{place}: {text}"


@pytest.mark.parametrize("status", list(rm.Status), ids=lambda status: status.meaning)
def test_every_status_has_a_sentence(status: rm.Status) -> None:
    """It says what became of a point."""
    assert re.fullmatch(r"[A-Z].*\.", status.explanation)

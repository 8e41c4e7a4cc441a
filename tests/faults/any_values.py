"""Calls of every public name with values of every type, and what may come of a call.

Calls are made from signatures and from sound arguments, so that a new name takes part by itself.

    python -m tests.faults.any_values --seeds 11 12 --calls 2000

makes many of them, and prints each that goes wrong and how many ended how.
"""

from __future__ import annotations

import argparse
import json
import logging
import random
import resource
import signal
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import chdir
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import remanent as rm
from tests.faults.near_values import OF_OWN, kind_of_argument, values_by_kind
from tests.faults.subjects import MATPLOTLIB_WORDS, OF_AN_OWN_SYSTEM, Subject, subjects
from tests.faults.value import Value
from tests.faults.value_pool import (
    KEYS,
    OwnError,
    before_one,
    in_array,
    in_list,
    in_mapping,
    pool,
)

#: Nothing may take longer, in seconds of processor time.  A sound call of the slowest verb takes a
#: twentieth of it; a motion over a million drive periods at a tight tolerance, a half.
CAP_SECONDS = 60
#: Nor more memory: what needs more fails, where the machine would end the process.
MOST_MEMORY_BYTES = 8 * 2**30
#: Nor so many times as long on the clock, on a machine that does other things too.
WAIT_FACTOR = 10
#: Share of calls that are given a name which no argument has.
UNKNOWN_NAME_SHARE = 0.02
#: Share of values that are of the kind that an argument takes.
NEAR_SHARE = 0.6
#: Verbs whose answers take seconds, and the share for them.
SLOW = frozenset(
    f"rm.{name}"
    for name in (
        "basins", "classify", "continue_bifurcation", "continue_orbit", "fit", "lyapunov",
        "manifold_crossing", "periodic_orbits", "regime_chart", "resonances", "response_diagram",
        "switch_branch", "symmetry_check", "uncertainty", "locate_bifurcation", "shape_command",
        "shape_commands", "design", "bifurcation_diagram",
    )
)  # fmt: skip
NEAR_SHARE_OF_SLOW = 0.15
#: Share of the others that are put into a container; of mappings among these.
WRAPPED_SHARE, MAPPING_SHARE = 0.3, 0.6
#: Longest message, in letters.
MAX_MESSAGE_LETTERS = 2500
#: A file for results, in the folder of the call.
RESULT_FILE = Path("result.nc")


@dataclass(frozen=True)
class Ending:
    """What became of a call: a word for it, and what is wrong with it if anything is."""

    kind: str
    wrong: str = ""


@dataclass(frozen=True)
class Attempt:
    """One call."""

    subject: Subject
    spoilt: Mapping[str, Value]

    def __str__(self) -> str:
        given = ", ".join(f"{name}={value.word}" for name, value in self.spoilt.items())
        return f"{self.subject.name}({given})"

    def ending(self) -> Ending:
        """What becomes of it."""
        arguments = dict(self.subject.sound())
        arguments |= {name: value.make() for name, value in self.spoilt.items()}
        before = shown(arguments)
        with (
            warnings.catch_warnings(),
            listening() as heard,
            TemporaryDirectory() as folder,
            chdir(folder),  # files that are asked for by name stay out of the repository
        ):
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", rm.InputWarning)
            try:
                with alarm(CAP_SECONDS):
                    result = self.subject.call(**arguments)
                    wrong = wrong_answer(result, self.spoilt)
                    ending = Ending("answer", wrong)
            except rm.InputError as error:
                ending = Ending("InputError", wrong_message(str(error)))
            except OwnError:
                ending = Ending("error of the caller's own")
            except Exception as error:
                ending = Ending("failure", f"{type(error).__name__}: {str(error)[:300]}")
            finally:
                plt.close("all")
        if not ending.wrong and heard:
            return Ending("failure", f"logged: {heard[0][:300]}")
        if not ending.wrong and shown(arguments) != before:
            return Ending("failure", "it changed its arguments")
        return ending

    def outcome(self) -> str:
        """What is wrong with what became of it; nothing where all is well."""
        return self.ending().wrong


def attempts(subjects: list[Subject], seed: int) -> Iterator[Attempt]:
    """Calls without end, the same for the same seed."""
    draw = random.Random(seed)
    values = pool()
    while True:
        subject = draw.choice(subjects)
        names = subject.argument_names()
        if subject.name.startswith("rm.") and draw.random() < UNKNOWN_NAME_SHARE:
            names = ["tolerence"]
        count = min(len(names), draw.choice([1, 1, 1, 2, 3]))
        sound = subject.sound()
        is_slow = subject.name.removesuffix(OF_AN_OWN_SYSTEM) in SLOW
        share = NEAR_SHARE_OF_SLOW if is_slow else NEAR_SHARE
        spoilt = {
            name: draw_value(draw, values, near_values(subject, name, sound.get(name)))
            if draw.random() < share
            else draw_value(draw, values, [])
            for name in draw.sample(names, count)
        }
        yield Attempt(subject, spoilt)


def near_values(subject: Subject, name: str, sound: object) -> list[Value]:
    """Values of the kind that an argument takes."""
    kinds, kind = values_by_kind(), kind_of_argument(name, sound)
    plain = kinds.get(kind, [])
    return kinds.get(f"{kind}{OF_OWN}", plain) if subject.is_of_own_system else plain


def draw_value(draw: random.Random, values: list[Value], near: list[Value]) -> Value:
    """A value of the kind that is asked for, or any, sometimes within another."""
    if near:
        return draw.choice(near)
    value = draw.choice(values)
    if draw.random() > WRAPPED_SHARE:
        return value
    if draw.random() < MAPPING_SHARE:
        return in_mapping(draw.choice(KEYS), value)
    return draw.choice([in_list, before_one, in_array])(value)


def shown(arguments: Mapping[str, Any]) -> str:
    """The arguments in words, by which a change is seen."""
    words = []
    for name, value in arguments.items():
        try:
            words.append(f"{name}={value!r}" if isinstance(value, list | dict | np.ndarray) else "")
        except Exception:
            words.append(name)
    return ", ".join(words)


def wrong_message(message: str) -> str:
    """What is wrong with a message."""
    if len(message) > MAX_MESSAGE_LETTERS:
        return f"a message of {len(message)} letters"
    return ""


def wrong_answer(result: Any, spoilt: Mapping[str, Value]) -> str:
    """What is wrong with an answer; it is written, drawn or saved and read to see it.

    Results that are made of what a caller changed need not be such as files hold, and words for
    Matplotlib are its own.
    """
    str(result), repr(result)
    if isinstance(result, xr.Dataset):
        changed = any("result of" in value.word for value in spoilt.values())
        return untold(result) or ("" if changed else unsaved(result))
    if spoilt.keys().isdisjoint(MATPLOTLIB_WORDS):
        for number in plt.get_fignums():
            plt.figure(number).set_dpi(30)
            plt.figure(number).canvas.draw()
    return ""


def untold(ds: xr.Dataset) -> str:
    """A status that is none, or infinity beside status ok."""
    if "status" not in ds or ds.status.dtype != np.int8:
        return ""  # the status of a result that the caller changed
    codes = np.unique(ds.status.values)
    if not {*codes.tolist()} <= {int(code) for code in rm.Status}:
        return f"status {codes}"
    return ""


def unsaved(ds: xr.Dataset) -> str:
    """How a result changes in a file."""
    try:
        back = rm.load(rm.save(ds, RESULT_FILE))
    except rm.InputError as error:
        return f"cannot be saved: {error}"
    return "" if back.equals(ds) else "another after it was saved"


class listening(logging.Handler):  # noqa: N801, used as a statement
    """Collect what libraries log as a warning."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.heard: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep it."""
        self.heard.append(record.getMessage())

    def __enter__(self) -> list[str]:
        logging.getLogger().addHandler(self)
        return self.heard

    def __exit__(self, *_: object) -> None:
        logging.getLogger().removeHandler(self)


class TooLong(BaseException):
    """A call took longer than the cap."""


class alarm:  # noqa: N801, used as a statement
    """Raise in the main thread after some seconds of processor time, or many of waiting."""

    def __init__(self, seconds: int) -> None:
        self.seconds = seconds

    def __enter__(self) -> None:
        def ring(_: int, __: FrameType | None) -> None:
            raise TooLong

        self.previous = [signal.signal(one, ring) for one in (signal.SIGPROF, signal.SIGALRM)]
        signal.setitimer(signal.ITIMER_PROF, self.seconds)
        signal.alarm(WAIT_FACTOR * self.seconds)

    def __exit__(self, kind: type[BaseException] | None, error: Any, trace: Any) -> None:
        signal.alarm(0)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        for one, previous in zip((signal.SIGPROF, signal.SIGALRM), self.previous, strict=True):
            signal.signal(one, previous)
        if kind is TooLong:
            raise TimeoutError(f"more than {self.seconds} s") from None


def run(seed: int, calls: int) -> dict[str, Counter[str]]:
    """How many calls of each name ended how; what goes wrong is printed at once."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for k, attempt in enumerate(islice(attempts(subjects(), seed), calls)):
        if k and k % 250 == 0:
            print(f"{seed}: {k} calls, {time.process_time():.0f} s", flush=True)
        begin = time.process_time()
        ending = attempt.ending()
        took = time.process_time() - begin
        counts[attempt.subject.name]["failure" if ending.wrong else ending.kind] += 1
        if ending.wrong:
            print(f"{seed}: {attempt}: {ending.wrong}", flush=True)
        elif took > CAP_SECONDS / 3:
            print(f"{seed}: {attempt}: took {took:.0f} s", flush=True)
    return counts


def main(words: list[str]) -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults.any_values")
    parser.add_argument("--seeds", type=int, nargs="+", required=True)
    parser.add_argument("--calls", type=int, default=2000, help="of each seed")
    parser.add_argument("--out", type=Path, help="a file for the counts, JSON")
    options = parser.parse_args(words)
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES,) * 2)
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for seed in options.seeds:
        for name, endings in run(seed, options.calls).items():
            counts[name] += endings
        total: Counter[str] = sum(counts.values(), Counter())
        print(f"seeds up to {seed}: {dict(total)}", flush=True)
        if options.out:
            table = {"seeds": options.seeds, "calls_of_each": options.calls, "total": total}
            options.out.write_text(json.dumps({**table, "by_name": counts}, indent=1))


if __name__ == "__main__":
    main(sys.argv[1:])

"""Study files with mistakes: refused in words that name table and key, and nothing is done.

Law: Study files.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

import remanent as rm
from remanent.studies.sweep.faults import StudyFileError
from remanent.studies.sweep.study_file import StudyFile, read_study
from remanent.studies.sweep.toml_text import MAX_FILE_BYTES
from tests.faults.study_file_mutations import CHART, FILM, PENDULUM, SOUND_FILES, STATICS, files

#: Files of the fast test, and of one seed of the slow one.
FEW, MANY = 300, 1000
#: What no reading of a file does.
DEEDS = ("os.system", "os.posix_spawn", "os.exec", "os.fork", "subprocess.Popen", "socket.connect")


def outcome(path: Path) -> StudyFile | StudyFileError:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rm.InputWarning)
        try:
            return read_study(path)
        except StudyFileError as error:
            return error


def refusal(path: Path) -> list[str]:
    """The lines of the message that refuses a file, without the first."""
    found = outcome(path)
    assert isinstance(found, StudyFileError), found
    return str(found).split("\n")[1:]


#: Likely mistakes: what is changed in a sound file, into what, and where the message says it is.
MISTAKES: dict[str, tuple[str, str, str, str]] = {
    "verb missing": (CHART, 'verb = "classify"\n', "", "verb: must be given"),
    "verb misspelt": (CHART, '"classify"', '"classifiy"', "verb: .*Did you mean `classify`"),
    "verb without over": (CHART, '"classify"', '"fit"', "verb: must be one of"),
    "verb a number": (CHART, '"classify"', "3", "verb: must be text"),
    "verb a name that is no verb": (CHART, '"classify"', '"Actuator"', "verb: must be one of"),
    "text without quotes": (CHART, '"classify"', "classify", "line 1: must be TOML"),
    "single equals missing": (CHART, "temperature = 350", "temperature 350", "line 4: must be"),
    "key twice": (CHART, "b = 0.4", "b = 0.4\nb = 0.5", "line 11: .*remove or rename"),
    "table twice": (CHART, "[options]", "[drive]", "line 16: .*remove or rename"),
    "True as in Python": (CHART, "periods = 500", "periods = True", "line 17: .*small letters"),
    "colon for equals": (CHART, "omega = 1.25", "omega: 1.25", "line 11: must be TOML"),
    "comment as in C": (CHART, "[drive]", "[drive] // the load", "line 8: must be TOML"),
    "decimal comma": (CHART, "b = 0.4", "b = 0,4", "line 10: must be TOML"),
    "units without quotes": (FILM, '"50 Hz"', "50 Hz", "line 14: must be TOML"),
    "unknown table": (CHART, "[options]", "[optoins]", "optoins: .*Did you mean `options`"),
    "unknown key": (CHART, "omega = 1.25", "omgea = 1.25", r"\[drive\] omgea: .*mean `omega`"),
    "unknown field of the actuator": (
        CHART, "temperature = 350", "temprature = 350",
        r"\[actuator\] temprature: .*mean `temperature`",
    ),
    "one for true": (FILM, "remanence", "own_field = 1\nremanence", r"\[actuator.si\] own_field:"),
    "true for a number": (CHART, "b = 0.4", "b = true", r"\[drive\] b: must be one real number"),
    "number in quotes": (CHART, "b = 0.4", 'b = "0.4"', r"\[drive\] b: .*without quotes"),
    "list for a number": (CHART, "b = 0.4", "b = [0.4, 0.5]", r"\[drive\] b: must be one real"),
    "date": (CHART, "b = 0.4", "b = 2024-01-01", r"\[drive\] b: .*got the date"),
    "not a number": (CHART, "b = 0.4", "b = nan", r"\[drive\] b: must be a finite number"),
    "infinity": (CHART, "periods = 500", "periods = inf", r"\[options\] periods: must be a finite"),
    "too large an integer": (CHART, "500", "9" * 40, r"\[options\] periods: must be an integer"),
    "absolute zero": (CHART, "temperature = 350", "temperature = 0", r"\[actuator\] temperature:"),
    "celsius below zero": (
        CHART, "temperature = 350", "temperature = -20",
        r"\[actuator\] temperature: .*Celsius",
    ),
    "celsius by a wrong name": (
        CHART, "temperature = 350", 'temperature = "25 C"',
        r"\[actuator\] temperature: must have a unit of the dimension of K",
    ),
    "unit of another dimension": (FILM, '"50 Hz"', '"50 mT"', r"\[drive\] omega: must be a freq"),
    "unit that is none": (FILM, '"100 kPa"', '"100 kPascals"', r"\[actuator.si\] shear_modulus:"),
    "unit without sizes": (CHART, "b = 0.4", 'b = "140 mT"', r"\[drive\] b: .*\[actuator.si\]"),
    "number where a quantity is": (FILM, '"5 mm"', "5", r"\[actuator.si\] half_length: must be a"),
    "size missing": (FILM, 'half_length = "5 mm"\n', "", r"\[actuator.si\] half_length: must be g"),
    "negative size": (FILM, '"2000 kg/m^3"', '"-2 kg/m^3"', r"\[actuator.si\] density: must be gr"),
    "slenderness beside sizes": (
        FILM, "[actuator]\n", "[actuator]\nc = 0.1\n", r"\[actuator\] c: must be left out beside",
    ),
    "temperature twice": (
        FILM, "[actuator.si]\n", 'temperature = 300\n[actuator.si]\ntemperature = "300 K"\n',
        r"\[actuator\] temperature: must be left out where",
    ),
    "no remanence": (FILM, 'remanence = "143 mT"\n', "", r"\[drive\] m: .*remanence"),
    "material without kind": (CHART, 'kind = "Gent", ', "", r"\[actuator\] material.kind: .*noth"),
    "unknown kind": (CHART, '"Gent"', '"Gant"', r"\[actuator\] material.kind: .*mean `Gent`"),
    "drive as a material": (CHART, '"Gent"', '"Sine"', r"\[actuator\] material.kind: must be one"),
    "class of Python as kind": (CHART, '"Gent"', '"os.system"', r"\[actuator\] material.kind:"),
    "material as text": (CHART, '{ kind = "Gent", jm = 50 }', '"Gent"', r"\[actuator\] material:"),
    "number of a part missing": (CHART, ", jm = 50", "", r"\[actuator\] material.jm: must be gi"),
    "rule of a part broken": (CHART, "jm = 50", "jm = -50", r"\[actuator\] material.jm: must be"),
    "dissipation as a number": (
        CHART, '[{ kind = "Rayleigh", eta = 0.05 }]', "0.05", r"\[actuator\] dissipation: must be",
    ),
    "no actuator": (CHART, "[actuator]", "[system]", r"\[system\] kind: .*nothing"),
    "actuator and system": (PENDULUM, "[drive.pressure]", "[actuator]\n[drive.pressure]",
                            r"\[actuator\]: must be given, or \[system\]"),
    "no drive": (CHART, '[drive]\nkind = "SineSquared"\nb = 0.4\nomega = 1.25\n', "",
                 r"\[drive\]: must be given for classify"),
    "drive where there is none": (
        STATICS, "[over]", '[drive]\nkind = "Constant"\nm = 0.1\n[over]',
        r"\[drive\]: must be left out for equilibria",
    ),
    "drive without kind": (CHART, 'kind = "SineSquared"\n', "", r"\[drive\] kind: must be one of"),
    "load without a drive": (PENDULUM, '[drive.voltage]\nkind = "Sine"\nm = 0.1\nomega = 2.0\n', "",
                             r"\[over\] voltage.m: must be a numeric field"),
    "formula with code": (
        PENDULUM, "theta_rate**2/2", "__import__('os').system('true')", r"\[system\] kinetic:",
    ),
    "unknown name in a formula": (PENDULUM, "delta = 0.1", "dleta = 0.1", r"\[system\] dissip"),
    "no over": (CHART, "[over]", "[over2]", r"\[over\]: must name at least one field"),
    "over of nothing": (STATICS, "m = [0.0, 0.1]\n", "", r"\[over\]: must name at least one field"),
    "over of an unknown field": (STATICS, "m = [0", "mm = [0", r"\[over\] mm: .*Did you mean `m`"),
    "over of an element that is not there": (
        CHART, "dissipation.0.eta", "dissipation.1.eta",
        r"\[over\] dissipation.1.eta: .*Did you mean `dissipation.0.eta`",
    ),
    "over of one number": (STATICS, "[0.0, 0.1]", "0.1", r"\[over\] m: must be a list"),
    "over of texts": (STATICS, "[0.0, 0.1]", '["low", "high"]', r"\[over\] m.0: must be"),
    "over of an empty list": (STATICS, "[0.0, 0.1]", "[]", r"\[over\] m: must be a list of at le"),
    "over unsorted": (STATICS, "[0.0, 0.1]", "[0.1, 0.0]", r"\[over\] m: must be sorted upwards"),
    "over with a value out of range": (
        CHART, "[0.01, 0.1]", "[-0.01, 0.1]", r"\[over\] dissipation.0.eta: must be .*at least 0",
    ),
    "list and range": (
        CHART, "from = 0.2,", "values = [1, 2], from = 0.2,", r"\[over\] b: must be a list, or",
    ),
    "range without an end": (CHART, "to = 1.2, ", "", r"\[over\] b: must be a list, or a table"),
    "range with a step": (CHART, "count = 8 }", "step = 0.1 }", r"\[over\] b.step: must be a key"),
    "negative count": (CHART, "count = 8 }", "count = -8 }", r"\[over\] b.count: must be at least"),
    "broken count": (CHART, "count = 8 }", "count = 8.0 }", r"\[over\] b.count: must be a whole"),
    "huge count": (CHART, "count = 8 }", "count = 1000000000000 }", r"\[over\] b.count: must be"),
    "too many points": (
        CHART, '8 }\nomega = { from = 0.8, to = 2.0, count = 8', '1000000 }\nomega = { from = 0.8, '
        "to = 2.0, count = 1000000", r"\[over\]: must have at most 1000000000 points",
    ),
    "log from zero": (CHART, "from = 0.8", "from = 0", r"\[over\] omega.from: must be greater"),
    "unknown spacing": (CHART, '"log"', '"logarithmic"', r"\[over\] omega.spacing: must be one of"),
    "range downwards": (CHART, "from = 0.2", "from = 1.3", r"\[over\] b.to: must be greater than"),
    "pairs of different length": (
        FILM, "[1.0, 1.1]", "[1.0, 1.1, 1.2]", r"\[over\] initial.stretch: must have length 2",
    ),
    "two sobol": (FILM, "[options]", "[over.sobol]\n[options]", "line 22: .*remove or rename"),
    "sobol of no power of two": (FILM, "count = 8", "count = 9", r"\[over.sobol\] count: .*or 16"),
    "sobol without ranges": (
        FILM, 'ranges = { m = ["50 mT", "140 mT"], omega = ["20 Hz", "80 Hz"] }\n', "",
        r"\[over.sobol\] ranges: must be given",
    ),
    "sobol of a field with values": (
        FILM, "{ m = [", '{ temperature = [300, 400], m = [',
        r"\[over.sobol\] ranges.temperature: must be varied once",
    ),
    "sobol downwards": (
        FILM, '["20 Hz", "80 Hz"]', '["80 Hz", "20 Hz"]', r"\[over.sobol\] ranges.omega: must be",
    ),
    "option of another verb": (
        CHART, "periods = 500", "periods = 500\nduration = 3", r"\[options\] duration: must be a",
    ),
    "option missing": (CHART, "periods = 500\n", "", r"\[options\] periods: must be given"),
    "option out of range": (CHART, "periods = 500", "periods = 0", r"\[options\] periods: must be"),
    "options that exclude each other": (
        FILM, 'duration = "20 ms"', 'duration = "20 ms"\nperiods = 2', r"\[options\] (dur|per)",
    ),
    "over as an option": (CHART, "[options]", "[options]\nover = 3", r"\[options\] over: must be"),
    "system in a state that is none": (
        PENDULUM, "initial = [0.1, 0.0]", "initial = [0.1]", r"\[options\] initial: must",
    ),
    "store above": (CHART, '"chart.zarr"', '"../x"', "store: must be the name of a folder within"),
    "store at the root": (CHART, '"chart.zarr"', '"/tmp/x"', "store: must be the name of a folder"),
    "store on a drive": (CHART, '"chart.zarr"', "'C:\\x'", "store: must be the name of a folder"),
    "store without a name": (CHART, '"chart.zarr"', '""', "store: must be the name of a folder"),
    "store that is the file": (CHART, '"chart.zarr"', '"study.toml"', "store: must be the name"),
    "cap of nothing": (FILM, "point_seconds = 60.0", "point_seconds = 0", "point_seconds: must be"),
    "cap as text": (FILM, "point_seconds = 60.0", 'point_seconds = "1 min"', "point_seconds: must"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_likely_mistakes_are_told(mistake: str, tmp_path: Path) -> None:
    """The message names the table and the key, or the line, and says what to do."""
    sound, before, after, words = MISTAKES[mistake]
    assert before in sound
    file = tmp_path / "study.toml"
    file.write_text(sound.replace(before, after, 1), encoding="utf-8")
    lines = refusal(file)
    assert any(re.match(words, line) for line in lines), lines
    assert len(lines) <= 3, lines
    assert all(line.count(": must ") == 1 and "; got " in line for line in lines), lines


@pytest.mark.parametrize("sound", SOUND_FILES, ids=["chart", "film", "pendulum", "statics"])
@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.encode(),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.replace(" = ", "\t=\t").encode(),
    ],
    ids=["plain", "CRLF", "BOM", "tabs"],
)
def test_sound_files_are_read(sound: str, change: Any, tmp_path: Path) -> None:
    """The files that are spoilt elsewhere are sound, whatever their ends of lines."""
    file = tmp_path / "study.toml"
    file.write_bytes(change(sound))
    assert isinstance(outcome(file), StudyFile)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "verb: must be given"),
        (b"\x00\x01\x02\xff", "the file: must be text in UTF-8"),
        (CHART.encode("utf-16"), "the file: must be text in UTF-8"),
        (CHART.encode("utf-32-le"), "line 1: must be TOML"),
        (b"a = 1\xe9", "the file: must be text in UTF-8; got the byte 0xe9 in line 1"),
        (b"# \n" * MAX_FILE_BYTES, "the file: must be at most 1024 KiB"),
        (b"a = " + b"[" * 5000 + b"]" * 5000, "the file: must have at most 12 tables"),
        (b".".join([b"a"] * 100_000) + b" = 1", "the file: must have at most 12 tables"),
        (b"a = " + b"9" * 10_000, "the file: must hold numbers of ordinary length"),
        (b"over = " + b"{a = " * 15 + b"1" + b"}" * 15, "[over] a.a.a.a.a.a.a.a.a.a.a.a: must"),
        (b"verb = '" + b"x" * 5000 + b"'", "verb: must have at most 4000 characters"),
    ],
    ids=[
        "empty", "binary", "UTF-16", "UTF-32", "Latin-1", "large", "nested lists", "long key",
        "long number", "nested tables", "long text",
    ],
)  # fmt: skip
def test_what_is_no_study_is_told(content: bytes, words: str, tmp_path: Path) -> None:
    """Content of another kind or of another size is refused before it is looked at closely."""
    file = tmp_path / "study.toml"
    file.write_bytes(content)
    assert any(line.startswith(words) for line in refusal(file)), refusal(file)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    """So is a folder: the error names the path, and says why."""
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(rm.RemanentError, match=str(path)):
            read_study(path)


#: Names and texts in the code that spoilt files hold.
BAIT = {"pwned", "touch pwned", "__mro__"}
#: What was done since the last look.
DONE: list[str] = []


def note_deeds(event: str, arguments: tuple[Any, ...]) -> None:
    """Note programs that are started, and code of a file that is run."""
    if event in DEEDS:
        DONE.append(event)
    elif event == "exec":
        code = arguments[0]
        if code.co_filename.startswith("<") and BAIT & {*map(str, code.co_consts), *code.co_names}:
            DONE.append(f"exec {code.co_names}")


sys.addaudithook(note_deeds)


@contextmanager
def no_deeds(folder: Path) -> Iterator[None]:
    """Nothing is started, and nothing in the folder is written, while a file is read."""
    DONE.clear()
    before = {path: path.stat().st_size for path in folder.rglob("*")}
    yield
    assert not DONE
    assert {path: path.stat().st_size for path in folder.rglob("*")} == before


def try_files(seed: int, count: int, folder: Path) -> tuple[int, int]:
    """Read spoilt files; how many were read, and how many were refused."""
    file = folder / "study.toml"
    read = refused = 0
    for content in islice(files(seed), count):
        file.write_bytes(content)
        with no_deeds(folder):
            found = outcome(file)
        if isinstance(found, StudyFile):
            assert found.store is None or found.store.is_relative_to(folder)
            read += 1
            continue
        refused += 1
        lines = str(found).split("\n")[1:]
        assert lines
        assert all(line.count(": must ") >= 1 for line in lines), lines
        assert not any("Traceback" in line or "pydantic" in line for line in lines)
    return read, refused


def test_a_few_hundred_files(tmp_path: Path) -> None:
    """Each is a study or refused in words; nothing is run and nothing is written."""
    read, refused = try_files(0, FEW, tmp_path)
    assert min(read, refused) > FEW // 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 11))
def test_ten_thousand_files(seed: int, tmp_path: Path) -> None:
    """The same, ten thousand times."""
    read, refused = try_files(seed, MANY, tmp_path)
    assert min(read, refused) > MANY // 20

"""Study files spoilt at random: bytes, lines, keys, values and whole tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from random import Random
from typing import Final

from tests.contracts.study_text import value_text

CHART: Final = """verb = "classify"
store = "chart.zarr"
[actuator]
temperature = 350
prestress = 0.0
dissipation = [{ kind = "Rayleigh", eta = 0.05 }]
material = { kind = "Gent", jm = 50 }
[drive]
kind = "SineSquared"
b = 0.4
omega = 1.25
[over]
b = { from = 0.2, to = 1.2, count = 8 }
omega = { from = 0.8, to = 2.0, count = 8, spacing = "log" }
"dissipation.0.eta" = [0.01, 0.1]
[options]
periods = 500
tolerance = 1e-8
"""
FILM: Final = """verb = "simulate"
point_seconds = 60.0
[actuator]
magnet = { kind = "Magnet", law = "rotation" }
[actuator.si]
shear_modulus = "100 kPa"
density = "2000 kg/m^3"
half_length = "5 mm"
half_thickness = "0.5 mm"
remanence = "143 mT"
[drive]
kind = "Sine"
m = "140 mT"
omega = "50 Hz"
[over]
temperature = { values = [300, 350], dim = "case" }
"initial.stretch" = { values = [1.0, 1.1], dim = "case" }
[over.sobol]
count = 8
ranges = { m = ["50 mT", "140 mT"], omega = ["20 Hz", "80 Hz"] }
seed = 3
[options]
duration = "20 ms"
"""
PENDULUM: Final = """verb = "poincare_section"
[system]
kind = "LagrangianSystem"
coordinates = "theta"
kinetic = "theta_rate**2/2"
potential = "-cos(theta) - pressure*sin(theta) + voltage*theta"
dissipation = "delta*theta_rate**2/2"
parameters = { delta = 0.1 }
loads = ["pressure", "voltage"]
[drive.pressure]
kind = "Constant"
m = 0.5
[drive.voltage]
kind = "Sine"
m = 0.1
omega = 2.0
[over]
delta = [0.1, 0.2]
"voltage.m" = [0.1, 0.2]
[options]
periods = 3
initial = [0.1, 0.0]
"""
STATICS: Final = """verb = "equilibria"
[actuator]
prestress = [0.1, 0.2]
heat = { kind = "Heat", coupling = 2e-4 }
[over]
m = [0.0, 0.1]
[options]
"""
#: Files that are sound.
SOUND_FILES: Final = (CHART, FILM, PENDULUM, STATICS)
#: Text that does something where somebody runs it.
CODE: Final = (
    "__import__('os').system('touch pwned')", "open('pwned', 'w')", "!!python/object:os.system",
    "{{ 7*7 }}", "$(touch pwned)", "`touch pwned`", "%(touch)s", "x.__class__.__mro__",
)  # fmt: skip
#: Values of every kind, some of which a study may have.
VALUES: Final = (
    "true", "false", "0", "1", "-1", "3.5", "nan", "inf", "-inf", "1e308", "5e-324", "1e400",
    "-0.0", "9" * 30, "0x10", "1_000", "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z",
    '""', '"1"', '"50 Hz"', '"140 mT"', '"25 celsius"', '"20 ms"', '"1e999 Hz"', '"a"',
    "'''a\nb'''", "[]", "{}",
    "[[]]", "[1, 2]", "[2, 1]", "[1.0, 1.0]", '["50 Hz", 3]', "[1, [2]]", '["a", "b"]',
    "{ from = 1, to = 2, count = 3 }", "{ from = 1, to = 2, count = 999999999999 }",
    '{ from = 0, to = 2, count = 3, spacing = "log" }', '{ values = [1, 2], dim = "case" }',
    '{ kind = "Gent", jm = 50 }', '{ kind = "Rayleigh", eta = 1 }', '{ kind = "os" }',
    '"../../x"', '"/etc/passwd"', '"C:\\\\x"', '"\\u0000"', '"~"', "[true, false]", "[nan, 1]",
    '"omega"', '"stretch"', '"chaotic"', '"9 kPa"', '"rotation"', "+5", "01", "5.", "yes", "None",
    *(value_text(text) for text in CODE),
)  # fmt: skip
#: Names of keys and tables, known and unknown.
NAMES: Final = (
    "verb", "store", "point_seconds", "actuator", "system", "drive", "over", "options", "kind",
    "b", "m", "omega", "temperature", "material", "dissipation", "heat", "magnet", "si", "sobol",
    "count", "from", "to", "values", "dim", "seed", "ranges", "periods", "initial", "tolerance",
    "duration", "__class__", "progress", "over.sobol", "actuator.si", '"a.b"', '""', "x y", "é",
    "model_config", "given", "state_box", "rng", "client", "scales", "physical_sizes", "edges",
)  # fmt: skip


def files(seed: int) -> Iterator[bytes]:
    """Spoilt files without end."""
    rng = Random(seed)
    while True:
        lines = rng.choice(SOUND_FILES).split("\n")
        for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
            rng.choice(_CHANGES)(rng, lines)
        content = "\n".join(lines).encode("utf-8", "surrogatepass")
        yield _spoilt_bytes(rng, content) if rng.random() < 0.15 else content


def _other_value(rng: Random, lines: list[str]) -> None:
    k = rng.randrange(len(lines))
    key, equals, _ = lines[k].partition("=")
    if equals:
        lines[k] = f"{key}= {rng.choice(VALUES)}"


def _other_key(rng: Random, lines: list[str]) -> None:
    k = rng.randrange(len(lines))
    _, equals, value = lines[k].partition("=")
    if equals:
        lines[k] = f"{rng.choice(NAMES)} ={value}"


def _other_table(rng: Random, lines: list[str]) -> None:
    k = rng.randrange(len(lines))
    lines.insert(k, f"[{rng.choice(NAMES)}]")


def _further_key(rng: Random, lines: list[str]) -> None:
    lines.insert(rng.randrange(len(lines)), f"{rng.choice(NAMES)} = {rng.choice(VALUES)}")


def _removed(rng: Random, lines: list[str]) -> None:
    if len(lines) > 1:
        del lines[rng.randrange(len(lines))]


def _repeated(rng: Random, lines: list[str]) -> None:
    k = rng.randrange(len(lines))
    lines.insert(rng.randrange(len(lines)), lines[k])


def _exchanged(rng: Random, lines: list[str]) -> None:
    j, k = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[j], lines[k] = lines[k], lines[j]


def _other_entry(rng: Random, lines: list[str]) -> None:
    """A word within a line is another one."""
    k = rng.randrange(len(lines))
    words = lines[k].split(" ")
    words[rng.randrange(len(words))] = rng.choice((*VALUES, *NAMES))
    lines[k] = " ".join(words)


def _other_character(rng: Random, lines: list[str]) -> None:
    k = rng.randrange(len(lines))
    j = rng.randrange(len(lines[k]) + 1)
    character = rng.choice("=[]{}\"'.,#\t\\ 0-eé\u202e\x7f\x00\r")
    lines[k] = lines[k][:j] + character + lines[k][j + rng.randrange(2) :]


def _deep(rng: Random, lines: list[str]) -> None:
    depth = rng.choice((5, 13, 40, 3000))
    text = rng.choice(
        (
            f"deep = {'[' * depth}{']' * depth}",
            f"{'.'.join('a' * depth)} = 1",
            f"b = {'{a=' * depth}1{'}' * depth}",
        )
    )
    lines.insert(rng.randrange(len(lines)), text)


_CHANGES: Final[tuple[Callable[[Random, list[str]], None], ...]] = (
    _other_value, _other_value, _other_value, _other_key, _other_table, _further_key,
    _further_key, _removed, _repeated, _exchanged, _other_entry, _other_entry, _other_character,
    _deep,
)  # fmt: skip


def _spoilt_bytes(rng: Random, content: bytes) -> bytes:
    """Other bytes, a cut, another encoding, other ends of lines."""
    k = rng.randrange(len(content) + 1)
    return rng.choice(
        (
            content[:k],
            content[:k] + bytes([rng.randrange(256)]) + content[k + 1 :],
            content.replace(b"\n", b"\r\n"),
            content.replace(b"\n", b"\r"),
            b"\xef\xbb\xbf" + content,
            content.decode("utf-8", "replace").encode("utf-16"),
            bytes(rng.randrange(256) for _ in range(100)),
            b"",
        )
    )

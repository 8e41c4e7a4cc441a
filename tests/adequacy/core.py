"""What counts as the numeric core, whose coverage and mutation score are stated.

The core is what decides a number that a user gets: the formulas of models, the equations, the
code written from them, the integrator, the analysis, the verbs and the change of units.  Not
in it are files and datasets, command, server, page, pictures, and the store of sweeps.

Machine code that the package compiles is no Python, so that coverage cannot see its lines, nor
a mutant change them.  The Python that writes it is in the core: both run with an empty cache,
so that equations are derived and kernels are written and compiled under measurement, and a
wrong line of it is a wrong kernel, which tests compare with exact solutions and with the slow
reference in NumPy.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

#: The repository.
ROOT: Final = Path(__file__).parents[2]
#: The package, whose files are named relative to it.
PACKAGE: Final = Path("src/remanent")
#: Packages and files of the numeric core, relative to the package.
NUMERIC_CORE: Final = (
    "models",
    "derivation",
    "codegen",
    "integrate",
    "analysis",
    "studies/control",
    "studies/ensemble",
    "studies/inference",
    "studies/motion",
    "studies/orbits",
    "studies/regimes",
    "studies/response",
    "studies/statics",
    "results/rescale.py",
    "results/si.py",
    "results/si_units.py",
    "_field.py",
    "_instructions.py",
    "_load_schedule.py",
    "_roots.py",
)


def is_core(file: str) -> bool:
    """Whether a file, relative to the package, belongs to the numeric core."""
    return any(file == part or file.startswith(f"{part}/") for part in NUMERIC_CORE)


def core_files(root: Path = ROOT) -> list[str]:
    """The files of the numeric core, relative to the package, in order."""
    package = root / PACKAGE
    files = (path.relative_to(package).as_posix() for path in package.rglob("*.py"))
    return sorted(filter(is_core, files))


def package_of(file: str) -> str:
    """The package of a file: its folder in the package, or the package itself."""
    return file.split("/", 1)[0] if "/" in file else "remanent"


def by_package(files: Iterable[str]) -> dict[str, list[str]]:
    """Files by their package."""
    groups: dict[str, list[str]] = {}
    for file in sorted(files):
        groups.setdefault(package_of(file), []).append(file)
    return groups

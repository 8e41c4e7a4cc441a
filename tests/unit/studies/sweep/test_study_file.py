"""A study file is the study that it says, or is refused with every fault that it has.

Law: Study files.
"""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.studies.sweep.faults import StudyFileError
from remanent.studies.sweep.study import Study, study_from_plain, verbs_of_studies
from remanent.studies.sweep.study_file import StudyFile, read_study
from remanent.studies.sweep.verb_checks import message_for_file
from tests.contracts.public import examples
from tests.contracts.sound_calls import SOUND
from tests.contracts.study_text import study_text

SIMULATE = """
verb = "simulate"
[actuator]
[drive]
kind = "SineSquared"
b = 0.4
omega = 1.25
[over]
temperature = [300, 350]
[options]
duration = 1.0
"""
SIZES = """
shear_modulus = "100 kPa"
density = "2000 kg/m^3"
half_length = "5 mm"
half_thickness = "0.5 mm"
remanence = "143 mT"
"""
DRIVES = examples(Drive)  # type: ignore[type-abstract]
MATERIALS = examples(Material)  # type: ignore[type-abstract]
ELEMENTS = examples(Dissipation)
FILM = rm.Actuator.from_si(
    shear_modulus="100 kPa",
    density="2000 kg/m^3",
    half_length="5 mm",
    half_thickness="0.5 mm",
    remanence="143 mT",
)


def read(folder: Path, text: str) -> StudyFile:
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return read_study(file)


def refusal(folder: Path, text: str) -> list[str]:
    """The lines of the message, without the first."""
    with pytest.raises(StudyFileError) as raised:
        read(folder, text)
    first, *lines = str(raised.value).split("\n")
    assert first == f"study.toml has {'a fault' if len(lines) == 1 else f'{len(lines)} faults'}:"
    return lines


def sound_study(verb: str) -> Study:
    """A study by the sound call of a verb."""
    arguments = dict(SOUND[verb]())
    function = getattr(rm, verb)
    system = arguments.pop("system", None) or arguments.pop("actuator")
    drive = arguments.pop("drive", None)
    over = arguments.pop("over", {"temperature": [293.0, 300.0]})
    assert set(arguments) <= set(inspect.signature(function).parameters)
    return Study(verb, system, drive, over, {k: v for k, v in arguments.items() if v is not None})


@pytest.mark.parametrize("verb", verbs_of_studies())
def test_every_verb_has_a_file(verb: str, tmp_path: Path) -> None:
    """Law: a study, written as a file and read, is an equal study; so is its plain data."""
    study = sound_study(verb)
    assert study_from_plain(study.plain).text == study.text
    assert read(tmp_path, study_text(study.plain)).study.text == study.text


@pytest.mark.parametrize("name", sorted({*DRIVES} - {"Loads"}))
def test_every_drive_has_a_file(name: str, tmp_path: Path) -> None:
    """Each public drive is written with its kind and its fields."""
    study = Study(
        "simulate",
        rm.Actuator(),
        DRIVES[name],
        {"temperature": [300.0]},
        {"duration": 0.1},
    )
    found = read(tmp_path, study_text(study.plain)).study
    assert found.drive == study.drive
    assert found.text == study.text


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_has_a_file(name: str, tmp_path: Path) -> None:
    """Each public material is written with its kind and its fields."""
    actuator = rm.Actuator(material=MATERIALS[name])
    study = Study("equilibria", actuator, None, {"temperature": [300.0]}, {})
    assert read(tmp_path, study_text(study.plain)).study.system == actuator


@pytest.mark.parametrize("name", ELEMENTS)
@pytest.mark.parametrize("shift", [None, rm.WLF(8.0, 200.0), rm.Arrhenius(6000.0)])
def test_every_element_has_a_file(name: str, shift: Any, tmp_path: Path) -> None:
    """Each dissipative element is written with its kind, its fields and its shift."""
    element = ELEMENTS[name].replace(shift=shift)
    actuator = rm.Actuator(dissipation=(element, element), heat=rm.Heat(2e-4, 0.1))
    study = Study("equilibria", actuator, None, {"dissipation.1.shift.c1": [0.1]}, {})
    if shift != rm.WLF(8.0, 200.0):
        study = Study("equilibria", actuator, None, {"temperature": [300.0]}, {})
    assert read(tmp_path, study_text(study.plain)).study.system == actuator


@pytest.mark.parametrize("kind", [rm.LagrangianSystem, rm.FirstOrderSystem])
def test_systems_of_ones_own_have_a_file(kind: Any, tmp_path: Path) -> None:
    """[system] holds the formulas; the parameters vary under their names."""
    system = kind.example()
    (name, *_) = system.parameter_values()
    study = Study("simulate", system, rm.Constant(0.1), {name: [0.1, 0.2]}, {"duration": 0.1})
    assert read(tmp_path, study_text(study.plain)).study.text == study.text


def test_several_loads_have_a_table_each(tmp_path: Path) -> None:
    """[drive.NAME] holds the drive of one load; its fields have the name of the load."""
    found = read(
        tmp_path,
        """
        verb = "simulate"
        [system]
        kind = "LagrangianSystem"
        coordinates = "x"
        kinetic = "x_rate**2/2"
        potential = "x**2/2 - pressure*x - voltage*x**2"
        loads = ["pressure", "voltage"]
        [drive.pressure]
        kind = "Constant"
        m = 0.5
        [drive.voltage]
        kind = "Sine"
        m = 0.1
        omega = 2.0
        [over]
        "voltage.m" = [0.1, 0.2]
        [options]
        duration = 1
        """,
    ).study
    assert found.drive == rm.Loads({"pressure": rm.Constant(0.5), "voltage": rm.Sine(0.1, 2.0)})
    assert found.grid.shape == (2,)


def test_ranges_are_those_of_numpy(tmp_path: Path) -> None:
    """Law: linear as `numpy.linspace`, log as `numpy.geomspace`, both ends among the values."""
    text = SIMULATE.replace(
        "temperature = [300, 350]",
        "b = { from = 0.2, to = 1.2, count = 64 }\n"
        'omega = { from = 0.8, to = 2.0, count = 7, spacing = "log" }',
    )
    over = read(tmp_path, text).study.over
    np.testing.assert_array_equal(over["b"], np.linspace(0.2, 1.2, 64))
    np.testing.assert_array_equal(over["omega"], np.geomspace(0.8, 2.0, 7))


def test_a_range_is_an_option_too(tmp_path: Path) -> None:
    """A list of numbers among the options may be written as a range."""
    text = SIMULATE.replace("simulate", "frequency_response").replace(
        "[options]", "[options]\nomega = { from = 1.0, to = 1.4, count = 5 }"
    )
    assert read(tmp_path, text).study.options["omega"] == np.linspace(1.0, 1.4, 5).tolist()


def test_an_option_is_no_dimension(tmp_path: Path) -> None:
    """A `dim` there says something that cannot be done."""
    text = SIMULATE.replace("simulate", "frequency_response").replace(
        "[options]", '[options]\nomega = { from = 1.0, to = 1.4, count = 5, dim = "case" }'
    )
    with pytest.raises(StudyFileError, match=r"\[options\] omega.dim: must be left out"):
        read(tmp_path, text)


def test_values_of_one_dim_go_together(tmp_path: Path) -> None:
    """Fields with one `dim` are paired; the others give all combinations with them."""
    text = SIMULATE.replace(
        "temperature = [300, 350]",
        'temperature = [300, 350]\nb = { values = [0.5, 0.2, 0.4], dim = "case" }\n'
        'omega = { from = 1, to = 2, count = 3, dim = "case" }',
    )
    study = read(tmp_path, text).study
    assert study.grid.dims == ("temperature", "case")
    assert study.over["b"].values.tolist() == [0.5, 0.2, 0.4]
    xr.testing.assert_identical(study.over["omega"], xr.DataArray([1.0, 1.5, 2.0], dims="case"))


SOBOL = SIMULATE.replace(
    "temperature = [300, 350]",
    "[over.sobol]\ncount = COUNT\nranges = { b = [0.2, 1.2], omega = [0.8, 2.0] }",
)


def test_quasi_random_points_are_evenly_spread(tmp_path: Path) -> None:
    """Law: of 2^m points each of 2^m equal intervals of each range holds one; more go on."""
    few = read(tmp_path, SOBOL.replace("COUNT", "64")).study
    many = read(tmp_path, SOBOL.replace("COUNT", "128")).study
    assert few.grid.dims == ("draw",)
    for name, low, width in (("b", 0.2, 1.0), ("omega", 0.8, 1.2)):
        cells = np.floor((few.over[name].values - low) / width * 64)
        assert sorted(cells) == list(range(64))
        np.testing.assert_array_equal(many.over[name].values[:64], few.over[name].values)
    other = read(tmp_path, SOBOL.replace("COUNT", "64\nseed = 1")).study
    assert (other.over["b"].values != few.over["b"].values).all()


def test_units_are_those_of_the_actuator(tmp_path: Path) -> None:
    """Law: a quantity in a file is the number that the actuator gives for it."""
    found = read(
        tmp_path,
        f"""
        verb = "simulate"
        [actuator]
        dissipation = [{{ kind = "Rayleigh", eta = "20 Pa s" }}]
        [actuator.si]
        {SIZES}
        temperature = "76.85 degC"
        [drive]
        kind = "SineSquared"
        b = "140 mT"
        omega = "50 Hz"
        [over]
        omega = {{ from = "20 Hz", to = "80 Hz", count = 3 }}
        b = ["100 mT", "0.2 T"]
        temperature = ["300 K", 350]
        [options]
        duration = "20 ms"
        """,
    ).study
    drive, system = found.drive, found.system
    assert isinstance(drive, rm.SineSquared)
    assert isinstance(system, rm.Actuator)
    assert system.scales == FILM.scales
    assert system.temperature == pytest.approx(350.0, rel=1e-15)
    assert system.parameter_values()["dissipation.0.eta"] == FILM.viscosity("20 Pa s")
    assert drive.b == float(np.sqrt(FILM.load("140 mT")))
    assert drive.omega == FILM.frequency("50 Hz")
    assert found.over["omega"].tolist() == pytest.approx(
        [FILM.frequency(f"{f} Hz") for f in (20, 50, 80)], rel=1e-15
    )
    assert found.over["b"].tolist() == pytest.approx(
        [np.sqrt(FILM.load("100 mT")), np.sqrt(FILM.load("200 mT"))], rel=1e-15
    )
    assert found.over["temperature"].tolist() == [300.0, 350.0]


def test_numbers_stand_beside_sizes(tmp_path: Path) -> None:
    """[actuator] holds what [actuator.si] leaves out."""
    text = SIMULATE.replace(
        "[actuator]", f"[actuator]\ntemperature = 350\nprestress = 0.5\n[actuator.si]\n{SIZES}"
    )
    assert read(tmp_path, text).study.system == FILM.replace(temperature=350.0, prestress=0.5)


def test_the_store_lies_beside_the_file(tmp_path: Path) -> None:
    """Its path is relative to the file, and both settings may be left out."""
    found = read(tmp_path, f'store = "out/chart.zarr"\npoint_seconds = 60\n{SIMULATE}')
    assert (found.store, found.point_seconds) == (tmp_path / "out" / "chart.zarr", 60.0)
    found = read(tmp_path, SIMULATE)
    assert (found.store, found.point_seconds) == (None, None)


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    """One message names table and key of each fault, in every table, and what the verb refuses."""
    lines = refusal(
        tmp_path,
        """
        verb = "classify"
        store = "../chart.zarr"
        colour = 3
        [actuator]
        dissipation = [{ kind = "Rayleigh", eta = 0.1 }, { kind = "Zener", modulus = 1.0 }]
        material = { kind = "Gent", jm = -50 }
        [drive]
        kind = "SineSquared"
        b = 1979-05-27
        omgea = 1.25
        [over]
        b = { from = 0.2, to = 1.2 }
        omega = [1.2, 1.1]
        [options]
        tolerence = 1e-8
        """,
    )
    assert [line.partition(":")[0] for line in sorted(lines)] == [
        "[actuator] dissipation.1.relaxation_time",
        "[actuator] material.jm",
        "[drive] b",
        "[drive] omega",
        "[drive] omgea",
        "[options] periods",
        "[options] tolerence",
        "[over] b",
        "[over] omega",
        "colour",
        "store",
    ]


def test_what_the_verb_refuses_is_told_at_once(tmp_path: Path) -> None:
    """Each refused option and field is named, although the verb itself stops at the first."""
    lines = refusal(
        tmp_path,
        """
        verb = "classify"
        [actuator]
        [drive]
        kind = "SineSquared"
        b = 0.3
        omega = 1.25
        [over]
        b = [0.2, 0.3]
        omgea = [1.0, 1.1]
        temperature = [-5, 300]
        [options]
        periods = -500
        tolerance = 5
        rng = 1.5
        """,
    )
    assert [line.partition(":")[0] for line in sorted(lines)] == [
        "[options] periods",
        "[options] rng",
        "[options] tolerance",
        "[over] omgea",
        "[over] temperature",
    ]
    assert any("Did you mean `omega`?" in line for line in lines)


def test_the_verb_is_asked_of_what_has_no_faults(tmp_path: Path) -> None:
    """A fault in one table does not hide what the verb has against another."""
    for before, after, place in (
        ("b = 0.4", "b = true", "[drive] b"),
        ("b = 0.4", "q = 0.4", "[drive] q"),
        ("[actuator]", "[actuator]\nc = -1", "[actuator] c"),
        ("temperature = [300, 350]", "temperature = []", "[over] temperature"),
        ("temperature = [300, 350]", "temprature = [1]\nb = [0.1]", "[over] temprature"),
        ("[options]", "[options]\nperiod = 3", "[options] period"),
    ):
        text = SIMULATE.replace("duration = 1.0", "duration = -1.0").replace(before, after)
        lines = refusal(tmp_path, text)
        places = {line.partition(":")[0] for line in lines} - {"[drive] b"}
        assert places | {place} == {place, "[options] duration"}


def test_what_a_verb_says_later_has_its_place_too() -> None:
    """An error of a verb that runs is told with the table and the key that it is about."""
    study = sound_study("classify")
    for name, place in {
        "periods": "[options] periods",
        "over['temperature']": "[over] temperature",
        "drive": "[drive]",
        "system": "[actuator]",
        "dissipation.0.eta": "[actuator] dissipation.0.eta",
    }.items():
        error = rm.InputError(name, must="be 1", got=2, why="It is.", fix="Pass 1.")
        assert message_for_file(error, study) == f"{place}: must be 1; got 2. It is. Write 1."


def test_nothing_is_computed(tmp_path: Path) -> None:
    """A file whose points would take hours is read at once: the verb is stopped before it runs."""
    text = SIMULATE.replace("duration = 1.0", "duration = 1e6\ntolerance = 1e-12")
    assert read(tmp_path, text).study.options["duration"] == 1e6


def test_warnings_name_the_file(tmp_path: Path) -> None:
    """What is allowed but looks like a mistake draws one warning that says in which file."""
    text = SIMULATE.replace("[actuator]", "[actuator]\ntemperature = 25")
    with pytest.warns(rm.InputWarning, match=r"study\.toml: .*Celsius") as caught:
        read(tmp_path, text)
    assert len(caught) == 1


def test_the_package_does_not_import_pydantic() -> None:
    """Whoever reads no study file does not pay for what checks it."""
    code = "import sys, remanent, remanent.studies.sweep.study; print('pydantic' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"

"""Studies that `remanent new` writes to start from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import remanent as rm
from remanent.cli.new import EXAMPLES, text_of_example
from remanent.studies.sweep.study import Study
from remanent.studies.sweep.study_file import read_study


def example(name: str, folder: Path) -> Study:
    """An example, read as `remanent run` does."""
    file = folder / f"{name}.toml"
    file.write_text(text_of_example(name, name), encoding="utf-8")
    described = read_study(file)
    assert described.store == folder / f"{name}.zarr"
    return described.study


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_can_be_run(name: str, tmp_path: Path) -> None:
    """Its first point has a result."""
    study = example(name, tmp_path)
    point = study.result_of(tuple(slice(0, 1) for _ in study.grid.shape))
    assert (point.status == rm.Status.OK).all()


def test_the_atlas_serves_every_temperature(tmp_path: Path) -> None:
    """Hotter by theta is the same under b sqrt(theta), S theta and omega sqrt(theta)."""
    study = example("atlas", tmp_path)
    part = (slice(0, 2), slice(1, 3), slice(2, 8, 5), slice(4, 20, 15))
    chart = study.result_of(part)
    over = study.grid.over(part)
    theta = 1.4
    assert study.drive is not None
    hot = rm.Actuator(temperature=theta * 293.0)
    scale = {"c": 1.0, "prestress": theta, "b": np.sqrt(theta), "omega": np.sqrt(theta)}
    same = rm.classify(
        hot, study.drive, over={k: v * scale[k] for k, v in over.items()}, **study.options
    )
    assert (chart.regime.values == same.regime.values).all()
    known = ~np.isnan(chart.rotation_number.values)
    assert known.any()
    difference = np.abs(chart.rotation_number.values - same.rotation_number.values)
    error = chart.rotation_number_error.values + same.rotation_number_error.values
    assert (difference[known] <= error[known]).all()

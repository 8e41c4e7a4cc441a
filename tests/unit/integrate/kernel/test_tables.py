"""Tables of the load at the nodes of steps."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import remanent as rm
from remanent._typing import FloatArray
from remanent.integrate.kernel import tables

NODES = (0.0, 0.25, 0.6, 1.0)


def waves(phase: FloatArray) -> FloatArray:
    """Two waveforms."""
    return np.stack([np.sin(2.0 * np.pi * phase), np.exp(-phase)])


@pytest.mark.parametrize("part", [slice(0, 16), slice(3, 90), slice(64, 128), slice(131, 300)])
@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_rows_of_a_long_cycle_are_those_of_its_whole_tables(
    part: slice, shift: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bit for bit, within a block and across blocks, up to the last that is not full."""
    whole = tables.CycleTables(waves, shift).rows(NODES, 300, part)
    monkeypatch.setattr(tables, "_MOST_DOUBLE_STEPS_OF_WHOLE_TABLES", 200)
    monkeypatch.setattr(tables, "_DOUBLE_STEPS_PER_BLOCK", 64)
    cut = tables.CycleTables(waves, shift).rows(NODES, 300, part)
    assert cut[1].shape == (part.stop - part.start, len(NODES), 3)
    for ours, other in zip(cut, whole, strict=True):
        np.testing.assert_array_equal(ours, other)


def test_a_motion_that_escapes_early_takes_no_memory_for_the_rest_of_its_run() -> None:
    """x'' = x^2 is infinite soon; refining a run of 1000 needs no tables of all its steps."""
    falling = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="-x**3/3", rest={"x": 1.0}
    )
    rm.simulate(falling, rm.Constant(0.0), duration=0.5)  # what is compiled is not counted
    tracemalloc.start()
    motion = rm.simulate(falling, rm.Constant(0.0), times=[1.0, 1000.0])
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 2.0 < float(motion.horizon) < 3.0
    assert int(motion.status) != int(rm.Status.OK)
    assert most < 3e8


def test_tables_are_the_load_at_the_nodes_of_each_step() -> None:
    """Also where a table is filled in several goes, and starts within a cycle."""
    steps, shift = 4000, 0.3
    _, coarse = tables.build_waveform_tables(waves, NODES, steps, shift)
    phase = (np.arange(steps)[:, None] + np.array(NODES)) / steps + shift
    phase = np.where(phase > 1.0, phase - 1.0, phase)
    np.testing.assert_array_equal(coarse[..., 0], phase)
    np.testing.assert_array_equal(np.moveaxis(coarse[..., 1:], -1, 0), waves(phase))


def test_memory_of_tables_does_not_grow_with_the_number_of_resolutions() -> None:
    """A chart with chaos asks for every long resolution once; only the last table is kept."""
    cycle = tables.CycleTables(waves)
    tracemalloc.start()
    longest = sum(table.nbytes for table in cycle(NODES, 9000))
    for double_steps in range(8000, 9000, 50):
        cycle(NODES, double_steps)
    kept, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 1.1 * longest
    assert most < 2.5 * longest

"""Machine code on disk is only a way to save time: fresh, stored or damaged, equal bits."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.kernel import compile as module
from remanent.integrate.kernel.options import KernelOptions
from remanent.integrate.maps.period_map import PeriodMap
from remanent.integrate.methods.runge_kutta import default_method
from tests.unit.integrate.handmade import Oscillator, Q, V, problem, turning

TIMES = np.linspace(0.0, 20.0, 41)[None]


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache on disk."""
    monkeypatch.setenv("REMANENT_CACHE_DIR", str(tmp_path / "cache"))
    forget()
    return tmp_path / "cache"


def forget() -> None:
    module._cached_kernel.cache_clear()


def computed() -> np.ndarray:
    """States of a Duffing oscillator by a kernel that is not in memory."""
    forget()
    asked = problem(Oscillator(-Q - 0.3 * Q**3 - 0.01 * V, {}), (1.7, 0.2), 20.0)
    states = integrate(asked, Request(times=TIMES), tolerance=1e-10).states
    assert states is not None
    return states


def entries(cache: Path) -> list[Path]:
    return sorted((cache / "kernel").iterdir())


def forbid(*_: object) -> bytes:
    raise AssertionError("compiled again")


def test_a_stored_kernel_gives_the_bits_of_a_fresh_one(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second time nothing is compiled, and nothing changes."""
    fresh = computed()
    assert entries(cache)
    monkeypatch.setattr(module, "_compile_source", forbid)
    np.testing.assert_array_equal(computed(), fresh)


def test_machine_code_writes_into_no_record_that_is_too_short() -> None:
    """A cycle of four double steps, every fine step of which is kept: eight states."""
    field = problem(Oscillator(-Q, {}), (1.0, 0.0), 1.0).field
    kernel = module.compiled_kernel(field, default_method(), KernelOptions())
    layout, lane_count = kernel.layout, kernel.lane_count
    lanes = np.zeros((1, layout.slot_count, lane_count))
    tables = np.zeros((8, 1, 3)), np.zeros((4, 1, 3))
    record = np.zeros((7, 1, layout.state_count, lane_count))
    with pytest.raises(ValueError, match="8 are needed"):
        kernel(lanes, tables, record, cycles=1, every=1)


def test_states_are_kept_in_order_however_often_machine_code_returns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """q'' = -q after 1 ... 9 eighths of a turn: one call of a kernel and nine give one path."""
    eighth = np.array([0.25 * np.pi])
    oscillator = PeriodMap(problem(Oscillator(-Q, {}), (1.0, 0.0), 1.0).field, turning)

    def path() -> np.ndarray:
        image = oscillator(
            np.array([[1.0, 0.0]]),
            np.zeros((1, 0)),
            eighth,
            tolerance=1e-12,
            cycles=9,
            visited=True,
        )
        assert image.visited_states is not None
        return np.asarray(image.visited_states[0])

    angle = eighth * np.arange(1, 10)
    whole = path()
    np.testing.assert_allclose(whole, np.stack([np.cos(angle), -np.sin(angle)], 1), atol=1e-10)
    monkeypatch.setattr(module, "_STEPS_PER_CALL", 1)
    np.testing.assert_array_equal(path(), whole)


@pytest.mark.parametrize("damage", ["flipped", "truncated", "empty"])
def test_a_damaged_kernel_is_made_again(cache: Path, damage: str) -> None:
    """It is not loaded, but replaced by a sound one."""
    fresh = computed()
    sound = {path: path.read_bytes() for path in entries(cache)}
    for path, content in sound.items():
        bad = bytearray(content)
        bad[len(bad) // 2] ^= 1
        path.write_bytes({"flipped": bytes(bad), "truncated": content[:-7], "empty": b""}[damage])
    np.testing.assert_array_equal(computed(), fresh)
    assert {path: path.read_bytes() for path in entries(cache)} == sound


def test_without_a_usable_cache_kernels_are_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file in the place of the directory stops nothing."""
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("REMANENT_CACHE_DIR", str(blocked))
    assert np.isfinite(computed()).all()


def test_another_safety_is_another_kernel(cache: Path) -> None:
    """What decides the machine code is part of its key."""
    computed()
    before = len(entries(cache))
    forget()
    asked = problem(Oscillator(-Q - 0.3 * Q**3 - 0.01 * V, {}), (1.7, 0.2), 20.0)
    integrate(asked, Request(wants_extremes=True), tolerance=1e-10)
    assert len(entries(cache)) > before


SCRIPT = """
import remanent as rm
ds = rm.simulate(rm.Actuator(c=0.3), rm.SineSquared(0.4, 1.25), duration=10)
print(ds.stretch.values.tobytes().hex()[-64:], float(ds.error))
"""


@pytest.mark.slow
def test_two_processes_may_start_at_once(tmp_path: Path) -> None:
    """With one empty cache between them both succeed, with the same bits."""
    environment = {**os.environ, "REMANENT_CACHE_DIR": str(tmp_path / "shared")}
    command = [sys.executable, "-W", "error", "-c", SCRIPT]
    running = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    found = [process.communicate(timeout=120)[0] for process in running]
    assert [process.returncode for process in running] == [0, 0]
    assert found[0] == found[1] != ""
    assert not list((tmp_path / "shared" / "kernel").glob(".new-*"))

"""A run that is interrupted stops at the next call of a kernel, and calls are short."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
import sympy as sp

from remanent.integrate.ensemble import segments
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.ensemble.work_sizes import DEFAULT_WORK_SIZES
from remanent.integrate.kernel.compile import Kernel, compiled_kernel, host_processor
from remanent.integrate.kernel.options import KernelOptions
from remanent.integrate.methods.adams import adams_method
from remanent.integrate.methods.runge_kutta import default_method
from tests.unit.integrate.handmade import Oscillator, Q, problem


class InterruptionError(Exception):
    """Raised by a progress display."""


def test_nothing_is_computed_after_an_interruption(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every worker finishes the call it is in, at most, and no chunk that waits begins."""
    raised, late = threading.Event(), []
    call = Kernel.__call__

    def counted(self: Kernel, *args: Any, **options: Any) -> None:
        if raised.is_set():
            late.append(1)
        call(self, *args, **options)

    def report(_share: float) -> None:
        raised.set()
        raise InterruptionError

    monkeypatch.setattr(Kernel, "__call__", counted)
    count = 40_000  # for most of which the second attempt would follow
    asked = problem(Oscillator(-Q - Q**3, {}), np.ones((count, 2)), 5.0, period=1.0)
    begun = threading.active_count()
    with pytest.raises(InterruptionError):
        integrate(asked, Request(strobe_cycles=1), tolerance=1e-12, workers=2, progress=report)
    assert len(late) <= 2
    assert threading.active_count() <= begun + 2


@pytest.mark.parametrize("longest", [64, 2048, 2**15])
@pytest.mark.parametrize("double_steps", [6, 100, 5000])
def test_segments_are_short(longest: int, double_steps: int) -> None:
    """No segment takes more steps of a trajectory than it may, but for whole cycles."""
    for cycles, strobe in ((1, 0), (100, 0), (100, 1)):
        calls = list(segments._cut_piece(cycles, double_steps, strobe, longest, single=False))
        assert sum(n * (part.stop - part.start) for _, n, part, _ in calls) == cycles * double_steps
        for _, n, part, has_past in calls:
            taken = 2 * n * (part.stop - part.start)
            assert (
                taken <= max(longest, 2 * double_steps if strobe or not has_past else 0) or n == 1
            )


@pytest.mark.parametrize("trajectories", [1, 16, 1000, 4096])
def test_segments_are_shorter_the_more_they_do(trajectories: int) -> None:
    """Fewer steps for more trajectories, for dearer rates and methods, and where all is kept."""

    def steps(rate: Any, method: Any, count: int = trajectories, **given: Any) -> int:
        kernel = compiled_kernel(
            problem(Oscillator(rate, {}), np.ones((1, 2)), 1.0).field, method, KernelOptions()
        )
        return DEFAULT_WORK_SIZES.fine_steps_per_segment(
            kernel, count, **{"recorded": False, **given}
        )

    cheap = steps(-Q, adams_method(8))
    assert steps(-Q, adams_method(8), 4 * trajectories) <= cheap
    assert steps(-Q, default_method()) <= cheap
    assert steps(-sp.exp(Q), adams_method(8)) <= cheap
    kept = steps(-Q, adams_method(8), recorded=True)
    assert kept <= cheap
    lanes = host_processor().lane_count
    assert kept * max(trajectories, lanes) <= max(2**17, 64 * trajectories)

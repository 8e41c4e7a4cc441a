"""Kernels written for other processors of the family x86-64 give results within their errors.

The processor that runs the tests may have wider vectors than a user's.  Code for plain x86-64, for
AVX2 with fused multiply-adds and for AVX-512 is made here, and run where the processor can.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr
from llvmlite import binding
from scipy.special import ellipj, ellipk

import remanent as rm
from remanent.integrate.kernel import compile as compiling
from remanent.integrate.kernel.compile import TargetProcessor, host_processor
from remanent.studies.sweep.study import code_identity

#: Instruction sets from the oldest to the widest: LLVM's name of a processor, and what it can do.
INSTRUCTION_SETS = {
    "plain": ("x86-64", ()),
    "avx": ("sandybridge", ("avx",)),
    "avx2": ("haswell", ("avx", "avx2", "fma")),
    "avx512": ("skylake-avx512", ("avx", "avx2", "fma", "avx512f", "avx512vl", "avx512dq")),
}
TOLERANCE = 1e-9


def processor(name: str) -> TargetProcessor:
    """The processor that code is made for; the test is left out where this one cannot run it."""
    cpu, features = INSTRUCTION_SETS[name]
    host = host_processor()
    if not host.triple.startswith(("x86_64", "amd64")):
        pytest.skip(f"this processor is none of the family x86-64: {host.triple}")
    missing = [feature for feature in features if not host.has_feature(feature)]
    if missing:
        pytest.skip(f"this processor cannot run {', '.join(missing)}")
    return TargetProcessor(host.triple, cpu, ",".join(f"+{feature}" for feature in features))


@contextmanager
def kernels_for(target: TargetProcessor) -> Iterator[None]:
    """Kernels are made for another processor than this one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiling, "host_processor", lambda: target)
        compiling._cached_kernel.cache_clear()
        try:
            yield
        finally:
            compiling._cached_kernel.cache_clear()


def alike(one: TargetProcessor, other: TargetProcessor) -> bool:
    """Whether code for both may round in the same way."""
    fused = one.has_feature("fma") == other.has_feature("fma")
    return fused and one.lane_count == other.lane_count


def response() -> xr.Dataset:
    """A driven, damped actuator at several frequencies: regular motion."""
    return rm.simulate(
        rm.Actuator(dissipation=rm.Rayleigh(0.05)), rm.SineSquared(0.4, 1.0),
        times=np.linspace(0.0, 60.0, 31), tolerance=TOLERANCE,
        over={"omega": np.linspace(0.8, 1.6, 11)},
    )  # fmt: skip


def duffing(amplitude: float, times: np.ndarray[tuple[int], np.dtype[np.float64]]) -> xr.Dataset:
    """x'' + x + x^3 = 0 from rest at an amplitude."""
    system = rm.LagrangianSystem(
        coordinates=("x",), kinetic="x_rate**2/2", potential="x**2/2 + x**4/4"
    )
    return rm.simulate(
        system, rm.Constant(0.0), times=times, initial=(amplitude, 0.0), tolerance=TOLERANCE
    )


def test_lanes_follow_the_width_of_vectors() -> None:
    """Two vectors of doubles a group: 2, 4 or 8 in each."""
    widths = {
        name: TargetProcessor("x86_64", cpu, ",".join(f"+{f}" for f in features)).lane_count
        for name, (cpu, features) in INSTRUCTION_SETS.items()
    }
    assert widths == {"plain": 4, "avx": 8, "avx2": 8, "avx512": 16}


@pytest.mark.slow
@pytest.mark.parametrize("name", INSTRUCTION_SETS)
def test_trajectories_agree_with_those_of_this_processor_within_their_errors(name: str) -> None:
    """States and stretches differ by less than both stated errors together."""
    target = processor(name)
    here = response()
    with kernels_for(target):
        there = response()
    assert (there.status == rm.Status.OK).all()
    for variable in ("stretch", "stretch_rate", "thickness_stretch"):
        difference = abs(there[variable] - here[variable]).max("time")
        assert (difference <= here.error + there.error).all()
    assert float(there.error.max()) <= TOLERANCE
    # Other instructions round otherwise, and groups of other sizes step otherwise.
    if not alike(target, host_processor()):
        assert not there.stretch.equals(here.stretch)


@pytest.mark.slow
@pytest.mark.parametrize("name", INSTRUCTION_SETS)
def test_an_exact_solution_is_met_within_the_stated_error(name: str) -> None:
    """Duffing's free oscillation is x = a cn(w t, k), w^2 = 1 + a^2, k^2 = a^2/(2 w^2)."""
    amplitude, times = 1.5, np.linspace(0.0, 40.0, 81)
    frequency = np.sqrt(1.0 + amplitude**2)
    modulus = amplitude**2 / (2.0 * frequency**2)
    assert 4.0 * ellipk(modulus) / frequency < times[-1]  # several periods
    exact = amplitude * ellipj(frequency * times, modulus)[1]
    with kernels_for(processor(name)):
        motion = duffing(amplitude, times)
    error = float(np.abs(motion["x"] - exact).max())
    assert error <= float(motion.error) <= TOLERANCE


@pytest.mark.slow
def test_code_of_plain_x86_64_has_no_wider_vectors() -> None:
    """What is made for the oldest processor is not secretly made for this one."""
    plain, host = processor("plain"), host_processor()
    source = """
    define void @add(ptr %a) {
      %x = load <8 x double>, ptr %a
      %y = fadd <8 x double> %x, %x
      store <8 x double> %y, ptr %a
      ret void
    }
    """
    module = binding.parse_assembly(source)
    written = {one: one.create_target_machine().emit_assembly(module) for one in (plain, host)}
    assert "ymm" not in written[plain]
    assert "zmm" not in written[plain]
    assert "xmm" in written[plain]


def test_the_processor_is_part_of_what_a_store_was_begun_by() -> None:
    """A store that was begun on another kind of processor is told apart, and so are its kernels."""
    here = code_identity()["processor"]
    assert host_processor().cpu in here
    a, b = (TargetProcessor("x86_64", "x86-64", features) for features in ("", "+avx"))
    assert a != b

"""LLVM assembly to a function that Python can call, with the object code kept on disk."""

from __future__ import annotations

import ctypes
import hashlib
import math
import os
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite
import numpy as np
from llvmlite import binding

from remanent import _cache
from remanent._field import Field
from remanent._threads import raise_if_stopped
from remanent._typing import FloatArray
from remanent.integrate.kernel.kernel import KERNEL_FUNCTION_NAME, kernel_source
from remanent.integrate.kernel.layout import SlotLayout
from remanent.integrate.kernel.options import KernelOptions, Method, build_slot_layout
from remanent.integrate.kernel.partial_steps import (
    PARTIAL_STEPS_FUNCTION_NAME,
    partial_steps_source,
)
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

_C_SIGNATURE = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4, *[ctypes.c_int64] * 6)
_C_SIGNATURE_OF_PARTIAL_STEPS = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 2, ctypes.c_int64)
#: Held while LLVM works, and while the process forks: a child that was forked in the middle of
#: a compilation would wait for ever for a thread that it does not have.
_COMPILE_LOCK = threading.RLock()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=_COMPILE_LOCK.acquire,
        after_in_parent=_COMPILE_LOCK.release,
        after_in_child=_COMPILE_LOCK.release,
    )
#: Steps of single trajectories that machine code does before it comes back: about 0.1 s.
_STEPS_PER_CALL = 1_000_000
#: Levels to which LLVM optimises a source, and one of more letters: that of many states with all
#: their tangents, or of fewer in wide vectors.
_SPEED_LEVEL, _SPEED_LEVEL_OF_LARGE = 3, 1
_LARGE_SOURCE_LETTERS = 1_000_000


@dataclass(frozen=True)
class Kernel:
    """Machine code for one field, method and set of options.

    Attributes
    ----------
    lane_count
        Trajectories per group.
    layout
        Slots of a trajectory.
    """

    field: Field
    method: Method
    options: KernelOptions
    lane_count: int
    layout: SlotLayout
    _machine_function: Callable[..., None]
    _execution_engine: Any

    def __call__(
        self,
        lanes: FloatArray,
        tables: tuple[FloatArray, FloatArray],
        record: FloatArray | None = None,
        *,
        cycles: int,
        every: int = 0,
        first_cycle: int = 0,
        first_step: int = 0,
        double_steps: int | None = None,
    ) -> None:
        """Advance all groups by at most `cycles` cycles, in place, without the GIL.

        Parameters
        ----------
        lanes : array (group, slot, lane)
        tables : pair of arrays (step, node, 1 + waveform)
            The load at the nodes of the fine and of the coarse steps of a cycle, from
            :func:`~remanent.integrate.kernel.tables.build_waveform_tables`.
        cycles : int
            Most cycles; a group stops when all its trajectories have ended.
        every : int
            Fine steps between records; 0 for none.
        record : array (record, group, state, lane), optional
            Filled with the state of the fine solution after every `every` fine steps of this
            call.
        first_cycle, first_step : int
            Cycles of the piece before this call, and fine steps of each cycle before those in
            the tables.  Times are counted from the start of the piece.
        double_steps : int, optional
            In a cycle, where lanes have their own: the most of any of them.  The tables are then
            those of several numbers of steps, one after the other.
        """
        fine, coarse = tables
        groups = lanes.shape[0]
        double_steps = coarse.shape[0] if double_steps is None else double_steps
        if (
            lanes.shape[1:] != (self.layout.slot_count, self.lane_count)
            or not lanes.flags.c_contiguous
        ):
            raise ValueError(f"wrong shape of lanes: {lanes.shape}")
        if fine.shape[0] != 2 * coarse.shape[0]:
            raise ValueError("fine and coarse tables do not belong together")
        if every:
            needed = 2 * double_steps * cycles // every
            if record is None or record.shape[1:] != (
                groups,
                self.layout.state_count,
                self.lane_count,
            ):
                raise ValueError("wrong shape of record")
            if record.shape[0] < needed or not record.flags.c_contiguous:
                raise ValueError(f"record holds {record.shape[0]} states; {needed} are needed")
        # Short calls: between two of them Python handles signals, and threads can be stopped.
        stride = self._cycles_per_call(groups, double_steps, every)
        for begin in range(0, max(cycles, 1), stride):
            raise_if_stopped()
            written = 2 * double_steps * begin // every if every else 0
            part = lanes if record is None else record[written:]
            addresses = (a.__array_interface__["data"][0] for a in (lanes, fine, coarse, part))
            self._machine_function(
                *addresses,
                groups,
                min(stride, cycles - begin),
                double_steps,
                every,
                first_cycle + begin,
                first_step,
            )

    def _cycles_per_call(self, groups: int, double_steps: int, every: int) -> int:
        """Cycles that the machine code may do in one go; whole records fit into them."""
        steps_per_cycle = max(2 * double_steps, 1)
        steps_of_all = max(groups, 1) * self.lane_count * steps_per_cycle
        most = max(1, _STEPS_PER_CALL // steps_of_all)
        if not every:
            return most
        cycles_to_whole_records = every // math.gcd(every, steps_per_cycle)
        return -(-most // cycles_to_whole_records) * cycles_to_whole_records


@dataclass(frozen=True)
class PartialSteps:
    """Machine code for single steps of one field, each of a state, load and length of its own."""

    field: Field
    method: RungeKuttaMethod
    lane_count: int
    _machine_function: Callable[..., None]
    _execution_engine: Any

    def __call__(
        self,
        h: FloatArray,
        loads: Sequence[FloatArray],
        states: FloatArray,
        parameters: Sequence[FloatArray],
    ) -> FloatArray:
        """The states after one step each, without the GIL.

        Parameters
        ----------
        h : array (step,)
            Lengths of the steps, tau.
        loads : sequence (node,) of array (1 + waveform, step)
            Phase and waveforms at the nodes of the method.
        states : array (step, state)
            To start from.
        parameters : sequence of array (step,)
            In the order of ``field.parameter_names``.

        Returns
        -------
        array (step, state)
        """
        numbers = [h, *(row for load in loads for row in load), *states.T, *parameters]
        groups = -(-h.size // self.lane_count)
        starts = np.zeros((len(numbers), groups * self.lane_count))
        for row, values in zip(starts, numbers, strict=True):
            row[: h.size] = values
        ends = np.empty((states.shape[1], groups * self.lane_count))
        addresses = (a.__array_interface__["data"][0] for a in (starts, ends))
        self._machine_function(*addresses, groups)
        return ends[:, : h.size].T


@dataclass(frozen=True)
class KernelPair:
    """Two kernels that work on the same trajectories, one after the other.

    Attributes
    ----------
    start_kernel
        Needs no past: for the beginning of every piece of smooth load.
    run_kernel
        Faster, from past rates.
    """

    start_kernel: Kernel
    run_kernel: Kernel

    @property
    def layout(self) -> SlotLayout:
        """Slots of a trajectory, the same for both."""
        return self.start_kernel.layout

    @property
    def lane_count(self) -> int:
        """Trajectories per group."""
        return self.start_kernel.lane_count


@dataclass(frozen=True)
class TargetProcessor:
    """The processor that code is made for."""

    triple: str
    cpu: str
    features: str

    @property
    def vector_size(self) -> int:
        """Doubles in a vector of the widest kind."""
        return 8 if self.has_feature("avx512f") else 4 if self.has_feature("avx") else 2

    @property
    def lane_count(self) -> int:
        """Trajectories per group: two vectors, to hide latencies."""
        return 2 * self.vector_size

    def lane_count_for(self, trajectory_count: int | None) -> int:
        """The same for so many trajectories: one vector, where no more are needed, is faster."""
        few = trajectory_count is not None and trajectory_count <= self.vector_size
        return self.vector_size if few else self.lane_count

    @property
    def has_reciprocal_estimates(self) -> bool:
        """Whether there is an instruction for estimates of reciprocals."""
        return self.has_feature("avx512f")

    def has_feature(self, feature: str) -> bool:
        """Whether the processor can do this."""
        return f"+{feature}" in self.features.split(",")

    def kernel_source(
        self, field: Field, method: Method, options: KernelOptions, lane_count: int | None = None
    ) -> str:
        """LLVM assembly of a kernel for this processor, by default with its usual groups."""
        lanes = lane_count or self.lane_count
        return kernel_source(field, method, options, lanes, estimates=self.has_reciprocal_estimates)

    def create_target_machine(self, level: int = _SPEED_LEVEL) -> Any:
        return binding.Target.from_triple(self.triple).create_target_machine(
            cpu=self.cpu, features=self.features, opt=level, reloc="pic", jit=True
        )


@cache
def host_processor() -> TargetProcessor:
    """The machine that this runs on."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return TargetProcessor(
        triple=binding.get_process_triple(),
        cpu=binding.get_host_cpu_name(),
        features=binding.get_host_cpu_features().flatten(),
    )


def compiled_kernel(
    field: Field, method: Method, options: KernelOptions, *, trajectory_count: int | None = None
) -> Kernel:
    """The kernel of a field, from memory, from disk, or compiled now.

    Parameters
    ----------
    field, method, options : Field, Method, KernelOptions
    trajectory_count : int, optional
        For how many trajectories.  For a few it is made with smaller groups: faster, and compiled
        in less time.  Each trajectory has the same bits.
    """
    lane_count = host_processor().lane_count_for(trajectory_count)
    with _COMPILE_LOCK:
        return _cached_kernel(
            _FieldByFingerprint(field), method.name, _MethodByName(method), options, lane_count
        )


@cache
def _cached_kernel(
    key: _FieldByFingerprint,
    _name: str,
    method: _MethodByName,
    options: KernelOptions,
    lane_count: int,
) -> Kernel:
    target = host_processor()
    code = _object_code(
        _kernel_cache_key(key.field, method.method, options, lane_count, target),
        lambda: target.kernel_source(key.field, method.method, options, lane_count),
        target,
    )
    address, engine = _load_object_code(code, KERNEL_FUNCTION_NAME, target)
    layout, call = build_slot_layout(key.field, options), _C_SIGNATURE(address)
    return Kernel(key.field, method.method, options, lane_count, layout, call, engine)


def compiled_partial_steps(field: Field, method: RungeKuttaMethod) -> PartialSteps:
    """The partial steps of a field, from memory, from disk, or compiled now."""
    with _COMPILE_LOCK:
        return _cached_partial_steps(_FieldByFingerprint(field), method.name, _MethodByName(method))


@cache
def _cached_partial_steps(
    key: _FieldByFingerprint, _name: str, by_name: _MethodByName
) -> PartialSteps:
    target, field, method = host_processor(), key.field, by_name.method
    assert isinstance(method, RungeKuttaMethod)
    code = _object_code(
        _kernel_cache_key(field, method, PARTIAL_STEPS_FUNCTION_NAME, target.lane_count, target),
        lambda: partial_steps_source(
            field, method, target.lane_count, estimates=target.has_reciprocal_estimates
        ),
        target,
    )
    address, engine = _load_object_code(code, PARTIAL_STEPS_FUNCTION_NAME, target)
    call = _C_SIGNATURE_OF_PARTIAL_STEPS(address)
    return PartialSteps(field, method, target.lane_count, call, engine)


class _FieldByFingerprint:
    """A field that hashes and compares by its fingerprint."""

    def __init__(self, field: Field) -> None:
        self.field = field

    def __hash__(self) -> int:
        return hash(self.field.fingerprint)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _FieldByFingerprint)
            and self.field.fingerprint == other.field.fingerprint
        )


class _MethodByName:
    """Carries a method past the cache, which knows it by its name."""

    def __init__(self, value: Method) -> None:
        self.method = value

    def __hash__(self) -> int:
        return hash(self.method.name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _MethodByName) and self.method.name == other.method.name


def _object_code(key: str, source: Callable[[], str], target: TargetProcessor) -> bytes:
    """What is stored under a key, or made from a source now."""
    stored = _cache.load_bytes("kernel", key)
    if stored is not None:
        return stored
    code = _compile_source(source(), target)
    _cache.store_bytes("kernel", key, code)
    return code


def _compile_source(source: str, target: TargetProcessor) -> bytes:
    # Of straight-line code of many states the last level makes little, in twice the time.
    level = _SPEED_LEVEL if len(source) <= _LARGE_SOURCE_LETTERS else _SPEED_LEVEL_OF_LARGE
    machine = target.create_target_machine(level)
    module = binding.parse_assembly(source)
    module.verify()
    tuning = binding.create_pipeline_tuning_options(speed_level=level)
    builder = binding.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def _load_object_code(code: bytes, name: str, target: TargetProcessor) -> tuple[int, Any]:
    """The address of a function, which is good as long as the engine lives."""
    engine = binding.create_mcjit_compiler(
        binding.parse_assembly(""), target.create_target_machine()
    )
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine.get_function_address(name), engine


def _kernel_cache_key(
    field: Field,
    method: Method,
    options: KernelOptions | str,
    lane_count: int,
    target: TargetProcessor,
) -> str:
    """Of a kernel with these options, or of another function of this name."""
    parts = (
        field.fingerprint,
        method.name,
        options,
        lane_count,
        target,
        llvmlite.__version__,
        _kernel_writer_digest(),
    )
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


@cache
def _kernel_writer_digest() -> str:
    """A digest of the code that writes kernels: a change of it makes new ones."""
    return _cache.source_digest("_field.py", "integrate/methods", "integrate/kernel")

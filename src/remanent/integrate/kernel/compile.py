"""LLVM assembly to a function that Python can call, with the object code kept on disk."""

from __future__ import annotations

import ctypes
import hashlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite
from llvmlite import binding

from remanent import _cache
from remanent._field import Field
from remanent._typing import FloatArray
from remanent.integrate.kernel.kernel import NAME, kernel_source
from remanent.integrate.kernel.layout import Layout
from remanent.integrate.kernel.options import Method, Options, layout_of

_SIGNATURE = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4, *[ctypes.c_int64] * 6)
_LOCK = threading.Lock()


@dataclass(frozen=True)
class Kernel:
    """Machine code for one field, method and set of options.

    Attributes
    ----------
    width
        Trajectories per group.
    layout
        Slots of a trajectory.
    """

    field: Field
    method: Method
    options: Options
    width: int
    layout: Layout
    _call: Callable[..., None]
    _engine: Any

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
    ) -> None:
        """Advance all groups by at most `cycles` cycles, in place, without the GIL.

        Parameters
        ----------
        lanes : array (group, slot, lane)
        tables : pair of arrays (step, node, 1 + waveform)
            The load at the nodes of the fine and of the coarse steps of a cycle, from
            :func:`~remanent.integrate.kernel.tables.waveform_tables`.
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
        """
        fine, coarse = tables
        groups, double_steps = lanes.shape[0], coarse.shape[0]
        if lanes.shape[1:] != (self.layout.size, self.width) or not lanes.flags.c_contiguous:
            raise ValueError(f"wrong shape of lanes: {lanes.shape}")
        if fine.shape[0] != 2 * double_steps:
            raise ValueError("fine and coarse tables do not belong together")
        if every:
            needed = 2 * double_steps * cycles // every
            if record is None or record.shape[1:] != (groups, self.layout.states, self.width):
                raise ValueError("wrong shape of record")
            if record.shape[0] < needed or not record.flags.c_contiguous:
                raise ValueError(f"record holds {record.shape[0]} states; {needed} are needed")
        pointers = (lanes, fine, coarse, lanes if record is None else record)
        addresses = (array.__array_interface__["data"][0] for array in pointers)
        self._call(*addresses, groups, cycles, double_steps, every, first_cycle, first_step)


@dataclass(frozen=True)
class Kernels:
    """Two kernels that work on the same trajectories, one after the other.

    Attributes
    ----------
    start
        Needs no past: for the beginning of every piece of smooth load.
    run
        Faster, from past rates.
    """

    start: Kernel
    run: Kernel

    @property
    def layout(self) -> Layout:
        """Slots of a trajectory, the same for both."""
        return self.start.layout

    @property
    def width(self) -> int:
        """Trajectories per group."""
        return self.start.width


@dataclass(frozen=True)
class Target:
    """The processor that code is made for."""

    triple: str
    cpu: str
    features: str

    @property
    def width(self) -> int:
        """Trajectories per group: two vectors of the widest kind, to hide latencies."""
        return 2 * (8 if self.has("avx512f") else 4 if self.has("avx") else 2)

    @property
    def estimates(self) -> bool:
        """Whether there is an instruction for estimates of reciprocals."""
        return self.has("avx512f")

    def has(self, feature: str) -> bool:
        """Whether the processor can do this."""
        return f"+{feature}" in self.features.split(",")

    def source(self, field: Field, method: Method, options: Options) -> str:
        """LLVM assembly of a kernel for this processor."""
        return kernel_source(field, method, options, self.width, estimates=self.estimates)

    def machine(self) -> Any:
        return binding.Target.from_triple(self.triple).create_target_machine(
            cpu=self.cpu, features=self.features, opt=3, reloc="pic", jit=True
        )


@cache
def host() -> Target:
    """The machine that this runs on."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return Target(
        triple=binding.get_process_triple(),
        cpu=binding.get_host_cpu_name(),
        features=binding.get_host_cpu_features().flatten(),
    )


def compiled(field: Field, method: Method, options: Options) -> Kernel:
    """The kernel of a field, from memory, from disk, or compiled now."""
    with _LOCK:
        return _compiled(_ByFingerprint(field), method.name, _Box(method), options)


@cache
def _compiled(key: _ByFingerprint, _name: str, method: _Box, options: Options) -> Kernel:
    target = host()
    call, engine = _load(_object_code(key.field, method.value, options, target), target)
    layout = layout_of(key.field, options)
    return Kernel(key.field, method.value, options, target.width, layout, call, engine)


class _ByFingerprint:
    """A field that hashes and compares by its fingerprint."""

    def __init__(self, field: Field) -> None:
        self.field = field

    def __hash__(self) -> int:
        return hash(self.field.fingerprint)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _ByFingerprint) and self.field.fingerprint == other.field.fingerprint
        )


class _Box:
    """Carries a method past the cache, which knows it by its name."""

    def __init__(self, value: Method) -> None:
        self.value = value

    def __hash__(self) -> int:
        return hash(self.value.name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Box) and self.value.name == other.value.name


def _object_code(field: Field, method: Method, options: Options, target: Target) -> bytes:
    key = _key(field, method, options, target)
    stored = _cache.load_bytes("kernel", key)
    if stored is not None:
        return stored
    code = _compile(target.source(field, method, options), target)
    _cache.store_bytes("kernel", key, code)
    return code


def _compile(source: str, target: Target) -> bytes:
    machine = target.machine()
    module = binding.parse_assembly(source)
    module.verify()
    tuning = binding.create_pipeline_tuning_options(speed_level=3)
    builder = binding.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def _load(code: bytes, target: Target) -> tuple[Callable[..., None], Any]:
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), target.machine())
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return _SIGNATURE(engine.get_function_address(NAME)), engine


def _key(field: Field, method: Method, options: Options, target: Target) -> str:
    parts = (field.fingerprint, method.name, options, target, llvmlite.__version__, _sources())
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


@cache
def _sources() -> str:
    """A digest of the code that writes kernels: a change of it makes new ones."""
    return _cache.source_digest("_field.py", "integrate/methods", "integrate/kernel")

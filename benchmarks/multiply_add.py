"""The most arithmetic that a core can do: a loop of independent fused multiply-adds.

This is the yardstick of the row ``kernel``.  Its rate follows from the passes that the source
asks for, so that it does not depend on how often LLVM unrolls the loop.
"""

from __future__ import annotations

import ctypes
import statistics
import time

import numpy as np
from llvmlite import binding, ir

from remanent.integrate.kernel.compile import TargetProcessor
from remanent.integrate.kernel.lanes import DOUBLE_TYPE, INTEGER_TYPE, Writer

#: Chains that wait for nothing but themselves: enough to hide the latency of one.
CHAINS = 6
#: Passes of the loop that is timed.
_PASSES = 4_000_000


def source(lane_count: int) -> str:
    """LLVM assembly of ``void loop(double *values, long passes)``."""
    module = ir.Module(name="multiply_add")
    signature = ir.FunctionType(ir.VoidType(), [DOUBLE_TYPE.as_pointer(), INTEGER_TYPE])
    function = ir.Function(module, signature, "loop")
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    begin = function.append_basic_block("begin")
    builder.branch(begin)
    builder.position_at_end(begin)
    values, passes = function.args
    w = Writer(builder, lane_count)
    places = [w.integer_constant(k * lane_count) for k in range(CHAINS + 2)]
    factor, term = w.load_lanes(values, places[-2]), w.load_lanes(values, places[-1])
    chains = [w.new_cell_with(w.load_lanes(values, k)) for k in places[:-2]]
    with w.loop(passes):
        # One multiply-add of a vector for every chain.
        for chain in chains:
            chain.set(chain.get() * factor + term)
    for chain, k in zip(chains, places, strict=False):
        w.store_lanes(chain.get(), values, k)
    builder.ret_void()
    return str(module)


def lanes_per_second(target: TargetProcessor, repeats: int) -> float:
    """Multiply-adds of single numbers that one core does in a second, the median of runs."""
    module = binding.parse_assembly(source(target.lane_count))
    machine = target.create_target_machine()
    builder = binding.create_pass_builder(
        machine, binding.create_pipeline_tuning_options(speed_level=3)
    )
    builder.getModulePassManager().run(module, builder)
    engine = binding.create_mcjit_compiler(module, machine)
    signature = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)
    loop = signature(engine.get_function_address("loop"))
    values = np.full((CHAINS + 2) * target.lane_count, 0.5)
    times = []
    for _ in range(repeats + 1):  # the first is for the caches
        begin = time.thread_time()
        loop(values.ctypes.data, _PASSES)
        times.append(time.thread_time() - begin)
    return _PASSES * CHAINS * target.lane_count / statistics.median(times[1:])

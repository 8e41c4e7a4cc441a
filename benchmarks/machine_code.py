"""What a compiled kernel does in every step, read from its assembly.

Only blocks that every pass of the busiest innermost loop goes through count: those that
dominate its jumps back.  Work done now and then (turns, horizons, records) is left out.

Which loops LLVM unrolls, and how often, depends on the processor.  An unrolled pass holds
several steps, and its assembly does not say how many.  The assembly that is counted is
therefore made without unrolling, so that one pass is one step; unrolling repeats the same
arithmetic and changes nothing in the number of operations of a step.

Only instructions of x86-64 with AVX are understood; on other processors nothing is counted.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field

from llvmlite import binding

from remanent.integrate.kernel.compile import TargetProcessor

_LABEL = re.compile(r"^(\.?\w+):")
_JUMP = re.compile(r"^\s+(j\w+)\s+(\.?\w+)")
_ARITHMETIC = re.compile(r"^\s+v(fn?m(?:add|sub)|mul|add|sub|div)\d*pd\s.*%([xyz])mm\d+")
#: Numbers in double precision in a register of 128, 256 and 512 bits.
_LANES = {"x": 2, "y": 4, "z": 8}


@dataclass
class Block:
    """Instructions between two labels, and the blocks that may follow."""

    work: Counter[str] = field(default_factory=Counter)
    following: list[int] = field(default_factory=list)


def assembly(source: str, target: TargetProcessor, *, unroll: bool = False) -> str:
    """Assembly of LLVM source, made by the passes that kernels are compiled with.

    Parameters
    ----------
    unroll
        Whether loops may be unrolled, as in the code that runs; off, so that a pass is a step.
    """
    machine = target.create_target_machine()
    module = binding.parse_assembly(source)
    tuning = binding.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_unrolling = unroll
    builder = binding.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return str(machine.emit_assembly(module))


def work_per_pass(text: str) -> Counter[str]:
    """Operations in one pass of the busiest loop, summed over lanes, by kind.

    Kinds are ``fma``, ``mul``, ``add`` (subtractions, too) and ``div``.
    """
    blocks = _blocks(text)
    dominators = _dominators(blocks)
    loops = _loops(blocks, dominators)
    busiest: Counter[str] = Counter()
    for head, latches in loops.items():
        if not (_body(blocks, head, latches) - {head}) & loops.keys():  # an innermost loop
            always = set.intersection(*(dominators[k] for k in latches)) - dominators[head]
            work = sum((blocks[k].work for k in {head} | always), Counter[str]())
            busiest = max(busiest, work, key=_total)
    return busiest


def _loops(blocks: list[Block], dominators: list[set[int]]) -> dict[int, set[int]]:
    """Heads of loops, with the blocks that jump back to them."""
    loops: dict[int, set[int]] = {}
    for k, block in enumerate(blocks):
        for head in block.following:
            # A jump to a block that dominates it closes a loop.  Blocks that nothing leads to
            # are "dominated" by all and close none.
            if head in dominators[k] and 0 in dominators[k] and len(dominators[k]) < len(blocks):
                loops.setdefault(head, set()).add(k)
    return loops


def _body(blocks: list[Block], head: int, latches: set[int]) -> set[int]:
    """The blocks of a loop: those that reach a jump back without passing its head."""
    body, waiting = {head}, list(latches)
    while waiting:
        k = waiting.pop()
        if k not in body:
            body.add(k)
            waiting.extend(j for j, block in enumerate(blocks) if k in block.following)
    return body


def _total(work: Counter[str]) -> int:
    return sum(work.values())


def _blocks(text: str) -> list[Block]:
    """Split at labels and after jumps; an unknown target ends the function."""
    pieces: list[list[str]] = [[]]
    names: dict[str, int] = {}
    for line in text.splitlines():
        if label := _LABEL.match(line):
            pieces.append([])
            names[label[1]] = len(pieces) - 1
        else:
            pieces[-1].append(line)
            if _JUMP.match(line):
                pieces.append([])
    blocks = [Block(_work(piece)) for piece in pieces]
    for (k, block), piece in zip(enumerate(blocks), pieces, strict=True):
        jump = _JUMP.match(piece[-1]) if piece else None
        if jump and jump[2] in names:
            block.following.append(names[jump[2]])
        falls = not (jump and jump[1] == "jmp") and not any("\tretq" in line for line in piece)
        if falls and k + 1 < len(blocks):
            block.following.append(k + 1)
    return blocks


def _work(lines: list[str]) -> Counter[str]:
    work: Counter[str] = Counter()
    for line in lines:
        if instruction := _ARITHMETIC.match(line):
            operation, register = instruction.groups()
            kind = "fma" if operation.startswith("f") else operation.replace("sub", "add")
            work[kind] += _LANES[register]
    return work


def _dominators(blocks: list[Block]) -> list[set[int]]:
    """For every block those that each way from the start to it goes through."""
    predecessors: list[list[int]] = [[] for _ in blocks]
    for k, block in enumerate(blocks):
        for j in block.following:
            predecessors[j].append(k)
    everything = set(range(len(blocks)))
    dominators = [{0}, *(set(everything) for _ in blocks[1:])]
    changed = True
    while changed:
        changed = False
        for k in range(1, len(blocks)):
            # What nothing leads to stays "everything" and so restricts nobody.
            new = {k} | everything.intersection(*(dominators[j] for j in predecessors[k]))
            changed, dominators[k] = changed or new != dominators[k], new
    return dominators

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Instruction list: the stack-machine code between compiler and backends.

The machine has a stack of BOOL results, whose top is the *current result*, and a second stack of
saved results (the *memory* of MPS).  Each network starts with both empty and ends with one result.

===========================  ======================================================================
LD LDN x                     push x, or its negation
AND ANDN OR ORN x            combine the current result with x
LDP ANDP ORP x, m            as LD AND OR with the rising edge of x; m holds the last x
LDF ANDF ORF x, m            the same with the falling edge; m holds the last NOT x
ANB ORB                      pop a result and combine it with the one below
MPS                          save the current result in the memory
MRD MPP                      current result := the saved one; MPP removes it from the memory
LRD LPP                      as MRD MPP, but push (as LD does), so that ORB can join the two
DRP                          drop the current result
ST STN x                     x := current result, or its negation
S R x                        x := TRUE, or FALSE, if the current result is TRUE
STP STF x, m                 x := rising, or falling, edge of the current result; m holds the last
CAL type instance            call a function block: current result -> power input, output -> result
FUN type                     call a function: current result -> EN, ENO or OUT -> result
NOT                          negate the current result
MOV type x, y                y := x, whatever the current result is
IF ... ELSE ... FI           pop the result: execute the first part if TRUE, else the second
LOOP ... POOL                repeat until BRK leaves
BRK                          pop the result: if TRUE leave the innermost loop
RET                          pop the result: if TRUE leave the routine
JMP label                    pop the result: if TRUE go on with the network of that label
RUN composite instance       as EXE, for an imported function block: nothing happens when that ends
EXE composite instance       execute the instance's routine if the current result is TRUE; when
                             that ends, release the routine's timers once
===========================  ======================================================================

IEC 61131-3 (tables 52 and 53) has LD to R and CAL; ANB, ORB, MPS, MRD, MPP and the pulse forms are
those of Mitsubishi's lists; LRD, LPP, DRP and EXE are ours (a branch that needs the root's power
inside a parallel one).  EXE leaves the result as it is: ENO is EN.  JMP goes from the end of a
network to the start of one, where both stacks are empty.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from ladder_ros.compiler.symbols import Operand, Ref, Target
from ladder_ros.model.types import DataType


class Op(Enum):
    """An operator."""

    LD = 'LD'
    LDN = 'LDN'
    LDP = 'LDP'
    LDF = 'LDF'
    AND = 'AND'
    ANDN = 'ANDN'
    ANDP = 'ANDP'
    ANDF = 'ANDF'
    OR = 'OR'
    ORN = 'ORN'
    ORP = 'ORP'
    ORF = 'ORF'
    ANB = 'ANB'
    ORB = 'ORB'
    MPS = 'MPS'
    MRD = 'MRD'
    MPP = 'MPP'
    LRD = 'LRD'
    LPP = 'LPP'
    DRP = 'DRP'
    ST = 'ST'
    STN = 'STN'
    S = 'S'
    R = 'R'
    STP = 'STP'
    STF = 'STF'
    CAL = 'CAL'
    FUN = 'FUN'
    EXE = 'EXE'
    RUN = 'RUN'
    NOT = 'NOT'
    MOV = 'MOV'
    IF = 'IF'
    ELSE = 'ELSE'
    FI = 'FI'
    LOOP = 'LOOP'
    BRK = 'BRK'
    POOL = 'POOL'
    RET = 'RET'
    JMP = 'JMP'

    __hash__ = object.__hash__  # Enum's own is Python code, and members are looked up all the time


CONTACTS: Mapping[Op, tuple[Op, str]] = {
    Op(join.value + mode): (join, mode)
    for join in (Op.LD, Op.AND, Op.OR) for mode in ('', 'N', 'P', 'F')}
"""What reads a variable: how its value joins the current result, and which of its values that is.

N is the negation, P the rising and F the falling edge.
"""
EDGES: Mapping[Op, str] = {
    op: op.value[-1] for op in (*CONTACTS, Op.STP, Op.STF) if op.value[-1] in 'PF'}
"""What has a memory, and which edge it gives: P or F."""
LOADS = frozenset({op for op, (join, _) in CONTACTS.items() if join is Op.LD})
STORES = frozenset({Op.ST, Op.STN, Op.S, Op.R, Op.STP, Op.STF})
ALWAYS_WRITE = frozenset({Op.ST, Op.STN, Op.STP, Op.STF})
CONTROL = frozenset({Op.IF, Op.ELSE, Op.FI, Op.LOOP, Op.BRK, Op.POOL, Op.RET, Op.JMP})
BARE = CONTROL - {Op.JMP} | {
    Op.ANB, Op.ORB, Op.MPS, Op.MRD, Op.MPP, Op.LRD, Op.LPP, Op.DRP, Op.NOT}


@dataclass(frozen=True, slots=True, kw_only=True)
class Call:
    """What CAL, FUN and EXE call.

    ``name`` is the block's type, or for EXE the composite.  ``instance`` is the path of the
    function block or composite instance (the routine's name); ``type`` what a function's generic
    pins stand for.  ``inputs`` are all but the power input; ``outputs`` those that are written to
    a variable.
    """

    name: str
    instance: str = ''
    type: DataType = DataType.BOOL
    inputs: tuple[tuple[str, Operand], ...] = ()
    outputs: tuple[tuple[str, Target], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruction:
    """An operator and what it works on.

    ``component`` is the path of the component whose evaluation ends here, or empty; ``target`` is
    what MOV writes; ``label`` is where JMP goes.
    """

    op: Op
    operand: Operand | None = None
    memory: Ref | None = None
    target: Target | None = None
    call: Call | None = None
    label: str = ''
    component: str = ''


def named_operands(instruction: Instruction) -> Iterator[tuple[Operand, bool]]:
    """Yield each operand that an instruction names, and whether the instruction writes it.

    What is bound to a composite's parameters counts as read; the state of a function block, which
    its call writes, is not named.
    """
    if instruction.operand is not None:
        yield instruction.operand, instruction.op in STORES
    if instruction.memory is not None:
        yield instruction.memory, True
    if instruction.target is not None:
        yield instruction.target, True
    if instruction.call is not None:
        for _, operand in instruction.call.inputs:
            yield operand, False
        for _, target in instruction.call.outputs:
            yield target, True


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """The code of a rung; jumps to one of its ``labels`` go on with it."""

    rung: str
    code: tuple[Instruction, ...]
    comment: str = ''
    labels: tuple[str, ...] = ()
    notable: tuple[Instruction, ...] = field(init=False, compare=False, repr=False)
    """Those instructions that do more than look at or write a variable, which most do not."""
    coils: tuple[Instruction, ...] = field(init=False, compare=False, repr=False)
    """Those that write a variable whatever power is."""

    def __post_init__(self) -> None:
        """Find what is notable, and the coils."""
        object.__setattr__(self, 'coils', tuple([
            i for i in self.code if i.op in ALWAYS_WRITE and i.component]))
        object.__setattr__(self, 'notable', tuple([
            i for i in self.code if i.call is not None or i.memory is not None
            or i.target is not None or i.label or (
                type(i.operand) is Ref and '%' in i.operand.path)]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Routine:
    """The code of a program body, or of one instance of an enabled composite."""

    name: str
    networks: tuple[Network, ...]
    is_body: bool = True

    def instructions(self) -> Iterator[Instruction]:
        """Yield every instruction in order."""
        for network in self.networks:
            yield from network.code

    def notable(self) -> Iterator[Instruction]:
        """Yield every notable instruction in order."""
        for network in self.networks:
            yield from network.notable

    def labels(self) -> dict[str, int]:
        """Return the number of the network that each label names."""
        return {label: number for number, network in enumerate(self.networks)
                for label in network.labels}


@dataclass(frozen=True, slots=True, kw_only=True)
class InstructionList:
    """The code of a program: a routine a body, and one an instance of an enabled composite."""

    routines: tuple[Routine, ...]


LOOP_LIMIT = 1_000_000
"""Most rounds that the loops of one rung, or of one Structured Text body, may make in a scan.

As many jumps backwards may a routine make.
"""


class LoopError(RuntimeError):
    """A loop that does not end: the watchdog of a scan."""


def matching(code: Sequence[Instruction], place: int, step: int) -> int:
    """Return where what opens (step 1) or closes (step -1) at ``place`` ends or starts.

    From IF and ELSE that is the ELSE or FI, from LOOP the POOL, from POOL the LOOP.
    """
    depth = 0
    opening, closing = {Op.IF, Op.LOOP}, {Op.FI, Op.POOL}
    if step < 0:
        opening, closing = closing, opening
    while True:
        place += step
        op = code[place].op
        if depth == 0 and (op in closing or op is Op.ELSE):
            return place
        depth += (op in opening) - (op in closing)


def active_flag(instance: str) -> Ref:
    """Return the hidden variable that says whether an enabled composite was executed last time."""
    return Ref(path=f'{instance}.%active', type=DataType.BOOL)

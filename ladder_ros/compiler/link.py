# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Link: the code of each POU -> one instruction list, and the list of its components.

Each program body is a routine; each instance of an enabled composite is one, made from the
composite's code by putting absolute paths for its names and parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.checks import DEPTH_LIMIT
from ladder_ros.compiler.il import (
    Call,
    Instruction,
    InstructionList,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.symbols import (
    Element,
    is_address,
    is_temporary,
    Literal,
    Operand,
    Ref,
    substitute,
    Target,
)
from ladder_ros.compiler.wiring import describe
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import ComponentEntry, Slot
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import Component, Instance
from ladder_ros.model.program import Composite, composite_key, is_body_key, pou_key, Program
from ladder_ros.model.types import DataType
from ladder_ros.nouns import maker

_instruction = maker(Instruction)
_network = maker(Network)
_ref = maker(Ref)
Code = Mapping[str, Sequence[Network]]
"""The networks of each POU, by its key."""

ROUTINE_LIMIT = 100_000
"""Most routines: bodies, and calls of functions and composites, which multiply where they nest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Linked:
    """A program's code, and where each routine's came from; ``made`` is by kind and name."""

    code: InstructionList
    made: Mapping[tuple[bool, str], tuple[_Frame, Sequence[Network], Routine]]


def link_code(program: Program, code: Code, earlier: Linked | None = None) -> Linked:
    """Return the program's instruction list: bodies first, then the routines they execute.

    Networks of ``earlier`` that would be made again are taken over.  Raises LadderError: L0207 for
    a POU that calls itself, L0401 where calls in calls are too many.
    """
    composites = {c.name.casefold(): c for c in program.composites}
    routines: list[Routine] = []
    made: dict[tuple[bool, str], tuple[_Frame, Sequence[Network], Routine]] = {}
    for body in program.bodies:
        pending = [_Frame(name=body.name, key=pou_key(body), path=body.name)]
        while pending:
            frame = pending.pop()
            is_body = is_body_key(frame.key)
            known = _known(frame, earlier.made.get((is_body, frame.name)) if earlier else None)
            networks = tuple([
                known.get(id(network)) or _place(network, frame) for network in code[frame.key]])
            routine = Routine(name=frame.name, networks=networks, is_body=is_body)
            routines.append(routine)
            made[is_body, frame.name] = frame, code[frame.key], routine
            for size, limit, unit in (
                (len(routines), ROUTINE_LIMIT, 'calls'),
                (len(frame.chain), DEPTH_LIMIT, 'levels of calls in calls'),
            ):
                if size > limit:
                    raise LadderError.of('L0401', body.location, count=f'over {limit} {unit}',
                                         limit=f'{limit} {unit}')
            pending.extend(reversed([
                _enter(instruction, composites, frame.chain)
                for instruction in routine.notable()
                if instruction.op in (Op.EXE, Op.RUN)]))
    routines.sort(key=lambda routine: not routine.is_body)
    return Linked(code=InstructionList(routines=tuple(routines)), made=made)


def _known(
    frame: _Frame, earlier: tuple[_Frame, Sequence[Network], Routine] | None,
) -> Mapping[int, Network]:
    """Return what networks (by ``id``) became in an earlier program in the same frame."""
    if earlier is None or earlier[0] != frame:
        return {}
    return {id(network): placed
            for network, placed in zip(earlier[1], earlier[2].networks, strict=True)}


def belongs_to_body(path: str) -> bool:
    """Say whether a path is the compiler's own, of something that belongs to one body."""
    return path.startswith('%') and not is_address(path)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Frame:
    """A routine to be made: its POU, prefix and bindings of its names, its components' path."""

    name: str
    key: str
    path: str
    prefix: str = ''
    bindings: Mapping[str, Operand] = field(default_factory=dict)
    chain: tuple[str, ...] = ()


def _enter(
    instruction: Instruction, composites: Mapping[str, Composite], outer: tuple[str, ...],
) -> _Frame:
    call = instruction.call
    assert call is not None
    composite = composites[call.name.casefold()]
    if composite.name in outer:
        chain = ' -> '.join((*outer, composite.name))
        raise LadderError.of('L0207', composite.location, name=composite.name, chain=chain)
    bindings: dict[str, Operand] = {
        name.casefold(): _ref(path=name, type=DataType.BOOL) for name in composite.externals}
    bindings.update((name.casefold(), operand) for name, operand in call.inputs)
    return _Frame(
        name=call.instance, key=pou_key(composite), prefix=f'{call.instance}.',
        path=instruction.component or call.instance, bindings=bindings,
        chain=(*outer, composite.name))


def _place(network: Network, frame: _Frame) -> Network:
    """Return a network of a POU as one instance of the POU executes it."""
    is_plain = not (frame.prefix or frame.bindings)

    def operand(old: Operand) -> Operand:
        if isinstance(old, Element):
            index = operand(old.index)
            assert not isinstance(index, Element), 'a subscript is a value'
            return replace(old, first=ref(old.first), index=index)
        if isinstance(old, Literal) or (is_plain and not old.path.startswith('%')):
            return old
        if is_temporary(old.path):
            return old
        if belongs_to_body(old.path) and not frame.prefix:
            # Bodies share the program's names, but not what the compiler adds for their rungs.
            kind, _, rest = old.path.partition('.')
            return _ref(path=f'{kind}.{frame.name}.{rest}', type=old.type)
        return substitute(old, frame.prefix, frame.bindings)

    def ref(old: Ref) -> Ref:
        new = operand(old)
        assert isinstance(new, Ref), 'what is written is a variable'
        return new

    def target(old: Target) -> Target:
        new = operand(old)
        assert not isinstance(new, Literal), 'what is written is a variable'
        return new

    def call(old: Call) -> Call:
        return replace(
            old, instance=instance(old.instance) if old.instance else '',
            inputs=tuple((pin, operand(value)) for pin, value in old.inputs),
            outputs=tuple((pin, target(written)) for pin, written in old.outputs))

    def instance(old: str) -> str:
        """Name an instance; one that is passed in, or global, keeps its own path."""
        new = operand(_ref(path=old, type=DataType.BOOL))
        return new.path if isinstance(new, Ref) else frame.prefix + old

    def instruction(old: Instruction) -> Instruction:
        if old.memory is None and old.target is None and old.call is None and not old.label:
            about, component = old.operand, old.component
            if about is None and not component:
                return old
            if about is not None and not (
                    is_plain and type(about) is Ref and about.path[:1] != '%'):
                about = operand(about)
            return _instruction(
                op=old.op, operand=about, component=start + component if component else '')
        return _instruction(
            op=old.op, operand=operand(old.operand) if old.operand is not None else None,
            memory=ref(old.memory) if old.memory is not None else None,
            target=target(old.target) if old.target is not None else None,
            call=call(old.call) if old.call is not None else None, label=old.label,
            component=start + old.component if old.component else '')

    start = f'{frame.path}/{network.rung}/'
    return _network(
        rung=network.rung, code=tuple([instruction(old) for old in network.code]),
        comment=network.comment, labels=network.labels)


class _Drawn:
    """The components of a program by their paths.

    Those in rungs are the program's: a graph that was taken over from an earlier program has
    components of that one, which stood in other lines of the file.
    """

    def __init__(self, program: Program, graphs: Mapping[str, Sequence[Aov]]) -> None:
        self._rungs = {(pou_key(pou), rung.id): rung
                       for pou in program.pous for rung in pou.rungs if rung.wires is None}
        self._known: dict[tuple[str, str], Mapping[str, Component]] = {
            (key, aov.rung): {symbol.path: symbol.component for symbol in aov.symbols}
            for key, aovs in graphs.items() for aov in aovs
            if (key, aov.rung) not in self._rungs}

    def component(self, pou: str, rung: str, path: str) -> Component:
        """Return a component; a path has the instances of inline composites that it is in."""
        place = pou, rung
        known = self._known.get(place)
        if known is None:
            known = self._known[place] = {c.id: c for c in self._rungs[place].components}
        component = known.get(path)
        if component is not None:
            return component
        instance, inner, rest = path.split('/', 2)
        outer = known[instance]
        assert isinstance(outer, Instance)
        return self.component(composite_key(outer.composite), inner, rest)


def list_components(
    program: Program, code: InstructionList, graphs: Mapping[str, Sequence[Aov]],
    slots: Mapping[str, Slot],
) -> tuple[ComponentEntry, ...]:
    """Return every component instance that does something, in the order of the code."""
    drawn = _Drawn(program, graphs)
    key_of = {(True, body.name): pou_key(body) for body in program.bodies}
    start_of = {(True, body.name): f'{body.name}/' for body in program.bodies}
    entries: list[ComponentEntry] = []
    for routine in code.routines:
        routine_id = (routine.is_body, routine.name)
        key, start = key_of[routine_id], start_of[routine_id]
        for network in routine.networks:
            above = len(start) + len(network.rung) + 1
            for instruction in network.code:
                if instruction.op in (Op.EXE, Op.RUN) and instruction.call is not None:
                    inner = (False, instruction.call.instance)
                    key_of[inner] = composite_key(instruction.call.name)
                    start_of[inner] = f'{instruction.component or instruction.call.instance}/'
                if not instruction.component:
                    continue
                component = drawn.component(key, network.rung, instruction.component[above:])
                entries.append(ComponentEntry(
                    index=len(entries), path=instruction.component, kind=describe(component),
                    location=component.location, slots=tuple(_slots_of(instruction, slots))))
    return tuple(entries)


def _slots_of(instruction: Instruction, slots: Mapping[str, Slot]) -> Iterator[int]:
    for operand in (instruction.operand, instruction.memory):
        if isinstance(operand, Element):
            operand = operand.first
        if isinstance(operand, Ref) and not is_temporary(operand.path):
            yield slots[operand.path.casefold()].index
    call = instruction.call
    if call is not None and call.instance and instruction.op is Op.CAL:
        for pin in CATALOGUE[call.name].state:
            yield slots[f'{call.instance}.{pin.name}'.casefold()].index
    if call is not None:
        for _, bound in (*call.inputs, *call.outputs):
            if isinstance(bound, Ref) and not is_temporary(bound.path):
                yield slots[bound.path.casefold()].index

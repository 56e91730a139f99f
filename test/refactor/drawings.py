# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs to refactor: written in short, random ones with repeats, and what runs them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from compiler.agreement import Machine
from hypothesis import strategies as st
from support.random_rungs import Case, cases, Wishes

from ladder_ros.executable import SlotClass
from ladder_ros.model.component import Block, Instance
from ladder_ros.model.places import base, names_in, renamed_rung
from ladder_ros.model.program import Body, Program, Rung, RunKind, Variable
from ladder_ros.model.types import DataType
from ladder_ros.source.xml_to_model import parse_program

PROGRAMS = Path(__file__).resolve().parents[2] / 'programs'

KINDS = {'/': 'nc', 'P': 'rising', 'N': 'falling', 'S': 'set', 'R': 'reset', '~': 'negated'}


def program(*rungs: str, declared: str = '', composites: str = '') -> Program:
    """Return a program of rungs in short: ``a /b | c -> k Sm``.

    Components stand in series, rows of contacts in parallel are parted by ``|``, coils follow the
    arrow and stand below each other; ``TON:t1:T#1s`` is a timer.  Variables are local BOOLs,
    unless ``declared`` says otherwise.
    """
    drawn = [_rung(str(number), text) for number, text in enumerate(rungs, 1)]
    found = parse_program(
        f'<ladder version="1" name="example"><composites>{composites}</composites>'
        f'<variables>{declared}</variables><body name="main">{"".join(drawn)}</body></ladder>'
        .encode())
    known = {variable.name.casefold() for variable in found.variables}
    instances = {c.instance.casefold() for body in found.bodies for rung in body.rungs
                 for c in rung.components if isinstance(c, (Block, Instance))}
    names = dict.fromkeys(name for body in found.bodies for name in names_in(body.rungs))
    return replace(found, variables=(*found.variables, *(
        Variable(name=name, type=DataType.BOOL, initial=False) for name in names
        if name not in known | instances)))


def outputs(*names: str, kind: str = 'output', type_: str = 'BOOL') -> str:
    """Declare variables of a class."""
    return ''.join(f'<variable name="{name}" class="{kind}" type="{type_}"/>' for name in names)


def _rung(identifier: str, text: str) -> str:
    left, _, right = text.partition('->')
    rows = [row.split() for row in left.split('|')]
    coils = right.split()
    width = max(len(row) for row in rows)
    parts = []
    for y, row in enumerate(rows):
        for x, word in enumerate(row):
            last = x == len(row) - 1 and len(row) == width
            up = ' up="right"' if last and y else ''
            down = ' down="right"' if last and y < len(rows) - 1 else ''
            parts.append(_left(f'c{y}_{x}', word, x, y, up + down))
        if len(row) < width:
            up = ' up="right"' if y else ''
            down = ' down="right"' if y < len(rows) - 1 else ''
            parts.append(f'<row id="r{y}" x="{len(row)}" y="{y}" width="{width - len(row)}"'
                         f'{up}{down}/>')
    for y, word in enumerate(coils):
        sides = (' up="left"' if y else '') + (' down="left"' if y < len(coils) - 1 else '')
        kind, operand = _kind(word)
        parts.append(f'<coil id="k{y}" x="{width}" y="{y}" operand="{operand}"{kind}{sides}/>')
    return f'<rung id="{identifier}" width="{width + 1}">{"".join(parts)}</rung>'


def _left(identifier: str, word: str, x: int, y: int, sides: str) -> str:
    if word.startswith('TON:'):
        _, instance, preset = word.split(':')
        return (f'<block id="{identifier}" x="{x}" y="{y}" height="2" type="TON" '
                f'instance="{instance}"{sides}><input pin="PT" operand="{preset}"/></block>')
    kind, operand = _kind(word)
    return f'<contact id="{identifier}" x="{x}" y="{y}" operand="{operand}"{kind}{sides}/>'


def _kind(word: str) -> tuple[str, str]:
    if word[0] in KINDS:
        return f' kind="{KINDS[word[0]]}"', word[1:]
    return '', word


# -- random programs with repeats -----------------------------------------------------------------

@st.composite
def repeating(draw: st.DrawFn) -> Case:
    """Generate a program in which some rungs stand again, with other names."""
    case = draw(cases(Wishes(composites=draw(st.booleans()), max_rows=3, max_width=5)))
    main = next(body for body in case.program.bodies if body.run is RunKind.CYCLIC)
    first = draw(st.integers(0, len(main.rungs) - 1))
    chosen = main.rungs[first:first + draw(st.integers(1, 3))]
    program, rungs = case.program, list(main.rungs)
    for copy in range(draw(st.integers(1, 3))):
        program, again = _copied(program, chosen, copy)
        rungs += again
    return replace(case, program=_with_body(program, replace(main, rungs=tuple(rungs))))


def _copied(
    program: Program, rungs: Sequence[Rung], copy: int,
) -> tuple[Program, list[Rung]]:
    """Return rungs with fresh instances and about half of their local variables renamed."""
    variables = {variable.name.casefold(): variable for variable in program.variables}
    names: dict[str, str] = {}
    added: list[Variable] = []
    for number, name in enumerate(dict.fromkeys(names_in(tuple(rungs)))):
        variable = variables.get(name)
        if variable is None:
            names[name] = f'{name}copy{copy}'
        elif number % 2 and not variable.address:
            names[name] = f'{variable.name}copy{copy}'
            added.append(replace(variable, name=names[name]))
    return replace(program, variables=(*program.variables, *added)), [
        replace(renamed_rung(rung, names), id=f'{rung.id}copy{copy}') for rung in rungs]


def _with_body(program: Program, body: Body) -> Program:
    return replace(program, bodies=tuple(
        body if other.name == body.name else other for other in program.bodies))


# -- running --------------------------------------------------------------------------------------

def assert_same_run(old: Program, new: Program, case: Case) -> None:
    """Run both and compare every variable that both have, after each scan."""
    __tracebackhide__ = True
    first, second = Machine(old), Machine(new)
    known = {slot.path.casefold() for slot in second.executable.slots}
    for number, (now, written) in enumerate(case.scans):
        for machine in (first, second):
            machine.scan(now, **{name: value for name, value in written.items()
                                 if name.casefold() in known})
        got, want = second.variables(), first.variables()
        different = {name: (want[name], got[name]) for name in got.keys() & want.keys()
                     if repr(got[name]) != repr(want[name])}
        assert not different, f'scan {number}'


def moved_to(new: Program) -> Mapping[str, str]:
    """Return where each old slot of a program went, by the paths that its ``was`` gives."""
    executable = Machine(new).executable
    return {old: slot.path for slot in executable.slots for old in slot.was
            if slot.slot_class is not SlotClass.SYSTEM}


def uses(program: Program, composite: str) -> int:
    """Count the instances of a composite."""
    pous = (*program.composites, *program.bodies)
    return Counter(
        component.composite for pou in pous for rung in pou.rungs for component in rung.components
        if isinstance(component, Instance))[composite]


def names_of(program: Program) -> set[str]:
    """Return the names of a program's variables."""
    return {base(variable.name) for variable in program.variables}

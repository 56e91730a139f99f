# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The editing operations (paper 3, section 3): Program, Edit -> Program.

Rules take the place of checks afterwards: what comes out compiles, every rung has an output,
every branch ends in one (a coil, a block or a composite), and a rung is at most as wide as
allowed, or as it was.  A refusal is a coded error.  The edited rung is drawn anew from its graph;
other rungs stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from typing_extensions import assert_never

from ladder_ros.compiler.access_keys import access_key
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.diagnostics import did_you_mean, LadderError, raise_errors
from ladder_ros.edit.edits import (
    AddOutput,
    AddParallel,
    AddSeries,
    CopyRung,
    Delete,
    DeleteRung,
    Edit,
    MoveRung,
    NewRung,
    Part,
    Place,
    Set,
    SetRung,
    Where,
)
from ladder_ros.edit.parts import (
    changed_component,
    checked_id,
    checked_text,
    free_name,
    made_component,
    with_power_pin,
    without_idle_pins,
)
from ladder_ros.edit.rung_lists import copied, moved
from ladder_ros.edit.sketch import LEFT, RIGHT, Sketch
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Row,
)
from ladder_ros.model.program import (
    Composite,
    is_inline,
    Pou,
    pou_key,
    Program,
    Rung,
    with_pou,
)

COLUMNS = 11
"""How wide a rung may become (paper 3: eleven columns, the last one for outputs and blocks)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Edited:
    """A changed program, and where the change is."""

    program: Program
    place: Place


def apply_edit(program: Program, edit: Edit, *, columns: int = COLUMNS) -> Edited:
    """Return the program with one edit done.

    Raises LadderError: L0621 for a name that is not there, L0622 where the rung would become wider
    than ``columns``, L0623 for a part that may not stand there, L0624 for what may not be deleted,
    L0625 for an edit that makes no sense, L0626 for a program of another editor, or what is wrong
    with the names in it.
    """
    if program.dialect != 'native':
        raise LadderError.of('L0626', program.location, name=program.name)
    pou = _pou(program, edit.pou)
    match edit:
        case NewRung():
            return _new_rung(program, pou, edit)
        case SetRung():
            rung = _rung(pou, edit.rung)
            return _with_rung(program, pou, rung, replace(
                rung, comment=checked_text(edit.comment, rung.location)))
        case DeleteRung():
            rung = _rung(pou, edit.rung)
            if len(pou.rungs) == 1:
                raise LadderError.of('L0624', rung.location, name=f'rung {rung.id}',
                                     reason=f'it is the only one of {pou.name}')
            rungs = tuple(r for r in pou.rungs if r is not rung)
            return _checked(program, replace(pou, rungs=rungs), Place(pou=pou.name))
        case MoveRung():
            rung = _rung(pou, edit.rung)
            rungs = moved(pou.rungs, rung, _before(pou, edit.before))
            return _checked(program, replace(pou, rungs=rungs),
                            Place(pou=pou.name, rung=rung.id))
        case CopyRung():
            rung = _rung(pou, edit.rung)
            new = replace(copied(rung, pou), id=_rung_id(pou, edit.copy, rung))
            rungs = moved((*pou.rungs, new), new, _before(pou, edit.before))
            return _checked(program, replace(pou, rungs=rungs),
                            Place(pou=pou.name, rung=new.id))
        case AddSeries() | AddParallel() | AddOutput() | Delete() | Set():
            return _RungEditor(program=program, pou=pou, rung=_rung(pou, edit.rung),
                               columns=columns).apply(edit)
        case _:
            assert_never(edit)


# -- the edited part of a program ----------------------------------------------------------------

def _pou(program: Program, name: str) -> Pou:
    pous: list[Pou] = [*program.bodies, *program.composites]
    for pou in pous:
        if pou.name.casefold() == name.casefold():
            if pou.statements:
                raise LadderError.of('L0626', pou.location, name=pou.name)
            if isinstance(pou, Composite) and pou.library:
                raise LadderError.of(
                    'L0625', pou.location, expected=f'edit the library {pou.library}',
                    reason=f'{pou.name} belongs to a library')
            return pou
    known = [pou.name for pou in pous]
    raise LadderError.of('L0621', program.location, what='body or composite', name=name,
                         known=', '.join(known), hint=did_you_mean(name, known))


def _rung(pou: Pou, id: str) -> Rung:
    for rung in pou.rungs:
        if rung.id.casefold() == id.casefold():
            return rung
    known = [rung.id for rung in pou.rungs]
    raise LadderError.of('L0621', pou.location, what=f'rung in {pou.name}:', name=id,
                         known=', '.join(known), hint=did_you_mean(id, known))


def _before(pou: Pou, id: str) -> Rung | None:
    return _rung(pou, id) if id else None


def _rung_id(pou: Pou, wanted: str, like: Rung | None) -> str:
    taken = [rung.id for rung in pou.rungs]
    if wanted:
        return checked_id(wanted, taken, pou.location)
    return free_name('' if like is None or like.id.isdigit() else f'{like.id}_', taken)


def _checked(program: Program, pou: Pou, place: Place) -> Edited:
    """Return the changed program if all its names still mean something."""
    changed = with_pou(program, pou)
    raise_errors(resolve_symbols(changed)[1])
    return Edited(program=changed, place=place)


def _with_rung(program: Program, pou: Pou, old: Rung, new: Rung) -> Edited:
    rungs = tuple(new if rung is old else rung for rung in pou.rungs)
    return _checked(program, replace(pou, rungs=rungs), Place(pou=pou.name, rung=new.id))


def _is_output(component: Component) -> bool:
    return isinstance(component, (Coil, Block, Instance))


def _parameters(program: Program, part: Part) -> int:
    for composite in program.composites:
        if composite.name.casefold() == part.type.casefold():
            return len(composite.parameters)
    return 0


def _new_rung(program: Program, pou: Pou, edit: NewRung) -> Edited:
    component = made_component(edit.part, (), pou.location, _parameters(program, edit.part))
    if not _is_output(component) and not is_inline(pou):
        raise LadderError.of('L0623', pou.location, name=component.id, reason=(
            'a new rung begins with its output'), remedy='give it a coil or a block')
    id = _rung_id(pou, edit.rung, None)
    place = pou.location
    component = replace(component, location=place, placement=replace(
        component.placement, x=0, y=0))
    rung = Rung(id=id, width=component.placement.width, components=(component,),
                comment=checked_text(edit.comment, place), location=place)
    rungs = moved((*pou.rungs, rung), rung, _before(pou, edit.before))
    return _checked(program, replace(pou, rungs=rungs),
                    Place(pou=pou.name, rung=id, component=component.id))


# -- within a rung ------------------------------------------------------------------------------

@dataclass(slots=True, kw_only=True)
class _RungEditor:
    """Edits one rung."""

    program: Program
    pou: Pou
    rung: Rung
    columns: int

    def apply(self, edit: AddSeries | AddParallel | AddOutput | Delete | Set) -> Edited:
        if isinstance(edit, Set):
            return self._set(edit)
        sketch = self._sketch()
        last = set(sketch.last_components())
        if isinstance(edit, Delete):
            self._delete(sketch, edit)
            name = ''
        else:
            component = self._made(edit.part)
            if isinstance(edit, AddSeries):
                vertex = self._add_series(sketch, edit, component)
            elif isinstance(edit, AddParallel):
                vertex = self._add_parallel(sketch, edit, component)
            else:
                vertex = self._add_output(sketch, edit, component)
            self._check_part(sketch, vertex)
            name = component.id
        self._check_ends(sketch, last, edit)
        return self._drawn(sketch, name)

    def refusal(
        self, code: str, component: Component | None = None, **facts: Any,
    ) -> LadderError:
        place = component.location if component is not None else self.rung.location
        return LadderError.of(code, place, **facts)

    # -- there and back ---------------------------------------------------------------------------

    def _sketch(self) -> Sketch:
        symbols, found = resolve_symbols(self.program)
        raise_errors(found)
        wiring, found = analyse_connections(
            self.rung, ends_in_output=not is_inline(self.pou))
        raise_errors(found)
        aov, found = build_aov(wiring, symbols.of_rung(pou_key(self.pou), self.rung.id))
        raise_errors(found)
        return Sketch.of(aov)

    def _drawn(self, sketch: Sketch, name: str) -> Edited:
        """Return the program with the rung drawn from the graph."""
        for vertex, component in sketch.components.items():
            if isinstance(component, Block):
                sketch.components[vertex] = without_idle_pins(
                    component, sketch.power_pins(vertex))
        components = tuple(sketch.components[vertex] for vertex in sketch.order)
        listed = replace(self.rung, components=components)
        pou = replace(self.pou, rungs=tuple(
            listed if rung is self.rung else rung for rung in self.pou.rungs))
        program = with_pou(self.program, pou)
        symbols, found = resolve_symbols(program)
        raise_errors(found)
        aov = sketch.to_aov(self.rung.id, self.rung.comment,
                            symbols.of_rung(pou_key(pou), self.rung.id))
        drawn = draw_rung(aov, rung_id=self.rung.id, comment=self.rung.comment,
                          access_key=access_key(program, pou))
        if drawn.width > max(self.columns, self.rung.width):
            raise self.refusal('L0622', rung=self.rung.id, width=drawn.width, limit=self.columns)
        rung = replace(drawn, location=self.rung.location)
        found = analyse_connections(rung, ends_in_output=not is_inline(self.pou))[1]
        raise_errors(found)
        rungs = tuple(rung if one is listed else one for one in pou.rungs)
        return Edited(program=with_pou(program, replace(pou, rungs=rungs)),
                      place=Place(pou=pou.name, rung=rung.id, component=name))

    # -- operations -------------------------------------------------------------------------------

    def _made(self, part: Part) -> Component:
        ids = [c.id for c in self.rung.components]
        return made_component(part, ids, self.rung.location, _parameters(self.program, part))

    def _find(self, sketch: Sketch, id: str) -> int:
        for vertex, component in sketch.components.items():
            if component.id.casefold() == id.casefold():
                return vertex
        known = [component.id for component in sketch.components.values()]
        raise self.refusal('L0621', what=f'component in rung {self.rung.id}:', name=id,
                          known=', '.join(known), hint=did_you_mean(id, known))

    def _add_series(self, sketch: Sketch, edit: AddSeries, component: Component) -> int:
        id, dot, pin = edit.target.partition('.')
        target = self._find(sketch, id)
        if dot:
            return self._feed_pin(sketch, target, pin, component)
        place = sketch.order.index(target)
        if edit.where is Where.BEFORE:
            (link,) = sketch.into(target)
            line = link.source
        else:
            (link,) = sketch.out_of(target)
            line, place = link.target, place + 1
        if not edit.joint:
            return sketch.insert_into(link, component, place)
        if line >= 0 or line == RIGHT:
            raise self.refusal('L0625', sketch.components[target], reason=(
                f'no vertical line is {edit.where.value} {id}'), expected='leave out joint')
        return sketch.insert_into_line(line, component)

    def _feed_pin(self, sketch: Sketch, target: int, name: str, component: Component) -> int:
        """Lead power to a further pin of a block through a component, or put it in there."""
        block = sketch.components[target]
        kind = CATALOGUE.get(block.type.upper()) if isinstance(block, Block) else None
        pin = kind.input(name) if kind else None
        if kind is None or pin is None or not isinstance(block, Block):
            raise self.refusal('L0621', block, what=f'power pin of {block.id}:', name=name,
                               hint='', known=', '.join(
                                   p.name for p in kind.inputs) if kind else 'none')
        place = sketch.order.index(target)
        if pin.name == kind.power_input:
            return sketch.insert_into(sketch.into(target)[0], component, place)
        for link in sketch.into(target, pin.name):
            return sketch.insert_into(link, component, place)
        sketch.components[target] = with_power_pin(block, pin.name)
        vertex = sketch.add_component(component, place)
        sketch.connect(LEFT, vertex)
        sketch.connect(vertex, target, '', pin.name)
        return vertex

    def _add_parallel(self, sketch: Sketch, edit: AddParallel, component: Component) -> int:
        first = self._find(sketch, edit.target)
        last = self._find(sketch, edit.until) if edit.until else first
        if last not in sketch.reached_from([first]):
            raise self.refusal('L0625', sketch.components[first], reason=(
                f'power does not lead from {edit.target} to {edit.until}'),
                expected='name the first and the last component of a span of power')
        if any(link.target_pin for link in sketch.out_of(last)):
            raise self.refusal('L0625', sketch.components[last], reason=(
                f'{sketch.components[last].id} leads to a pin of a block'),
                expected='add it in series, or in parallel to less')
        return sketch.insert_beside(first, last, component)

    def _add_output(self, sketch: Sketch, edit: AddOutput, component: Component) -> int:
        target = self._find(sketch, edit.target)
        if not _is_output(component):
            raise self.refusal('L0623', sketch.components[target], name=component.id, reason=(
                'a branch to the right rail ends in an output'),
                remedy='give it a coil or a block; then add contacts before it')
        behind = sketch.out_of(target)[0].target
        if behind == RIGHT:
            joint = sketch.joint_before(target)
        else:
            joint = sketch.joint_after(target)
        return sketch.branch_off(joint, component)

    def _delete(self, sketch: Sketch, edit: Delete) -> None:
        target = self._find(sketch, edit.target)
        component = sketch.components[target]
        for pin in sketch.power_pins(target):
            raise self.refusal('L0624', component, name=component.id, reason=(
                f'power is led to or from its pin {pin}: delete that first'))
        sketch.remove(target)
        if not is_inline(self.pou):
            sketch.drop_idle_lines()

    def _set(self, edit: Set) -> Edited:
        known = {c.id.casefold(): c for c in self.rung.components}
        component = known.get(edit.target.casefold())
        if component is None or isinstance(component, (Row, Column)):
            names = [c.id for c in self.rung.components if not isinstance(c, (Row, Column))]
            raise self.refusal('L0621', what=f'component in rung {self.rung.id}:',
                              name=edit.target, known=', '.join(names),
                              hint=did_you_mean(edit.target, names))
        new = changed_component(component, edit, component.location)
        rung = replace(self.rung, components=tuple(
            new if c is component else c for c in self.rung.components))
        edited = _with_rung(self.program, self.pou, self.rung, rung)
        return replace(edited, place=replace(edited.place, component=component.id))

    # -- rules ------------------------------------------------------------------------------------

    def _check_part(self, sketch: Sketch, vertex: int) -> None:
        """Refuse a coil before something that is no coil: outputs stand in the last columns."""
        component = sketch.components[vertex]
        if not isinstance(component, Coil):
            return
        behind = sketch.out_of(vertex)[0].target
        if behind != RIGHT and not isinstance(sketch.components.get(behind), Coil):
            raise self.refusal('L0623', name=component.id, reason=(
                'a coil stands at the right rail'), remedy='add an output branch for it')

    def _check_ends(
        self, sketch: Sketch, last: set[int], edit: AddSeries | AddParallel | AddOutput | Delete,
    ) -> None:
        """Refuse a rung without an output, and a branch that ends in a contact."""
        if is_inline(self.pou):
            if not sketch.components:
                raise self.refusal('L0624', name=edit.target, reason='the rung would be empty')
            if sketch.is_shorted:
                raise self.refusal('L0624', name=edit.target, reason=(
                    'lines alone would join the rails'))
            return
        for vertex in sketch.last_components():
            component = sketch.components[vertex]
            if _is_output(component) or (vertex in last and isinstance(component, Contact)):
                continue
            if isinstance(edit, Delete):
                raise self.refusal('L0624', component, name=edit.target, reason=(
                    f'the branch would end in {component.id} without an output: '
                    'delete what leads to the output first'))
            raise self.refusal('L0623', component, name=component.id, reason=(
                'a branch ends in an output'), remedy='put it before the output')
        if not any(_is_output(component) for component in sketch.components.values()):
            raise self.refusal('L0624', name=edit.target,
                              reason='it is the only output: delete the rung')

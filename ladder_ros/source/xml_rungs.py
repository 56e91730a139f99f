# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs of program files, and the components in them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from ladder_ros.diagnostics import Location
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
    Row,
    Side,
)
from ladder_ros.model.program import Rung
from ladder_ros.nouns import maker
from ladder_ros.source import grammar
from ladder_ros.source.grammar import RULES
from ladder_ros.source.xml_form import Form, shown
from ladder_ros.source.xml_tree import Element

_T = TypeVar('_T')
_argument = maker(Argument)
_coil = maker(Coil)
_contact = maker(Contact)
_instance = maker(Instance)
_location = maker(Location)
_rung = maker(Rung)


_LOOK = frozenset((
    'id', 'operand', 'x', 'y', 'width', 'height', 'up', 'down', 'kind', 'comment'))
_SHORT = 1000
"""Characters of an id, an operand and a comment that together keep every limit of attributes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Look:
    """What contacts or coils may have in common; ``make`` makes one of them."""

    make: Callable[..., Contact | Coil]
    placement: Placement
    kind: ContactKind | CoilKind
    cell: tuple[int, int] | None


_ALIKE = 4096
_PLACEMENTS: dict[tuple[object, ...], Placement] = {}
"""Good placements, by their texts: many components stand in the same place of their rungs."""
_LOOKS: dict[tuple[object, ...], _Look] = {}
"""What contacts and coils without mistakes say but for their names and comments, by its texts."""


def _remember(
    known: dict[tuple[object, ...], _T], key: tuple[object, ...], value: _T,
) -> None:
    """Keep a value that depends on the key alone; all programs draw alike."""
    if len(known) >= _ALIKE:
        known.clear()
    known[key] = value


class RungReader:
    """Reads rungs.

    ``uses`` are composites' names, each with its place and whether in a drawing.  ``read`` are the
    rungs that were drawn, in their order; those that were taken over from an earlier reading and
    stand elsewhere now are also in ``moved``: the earlier ones, by ``id``.
    """

    def __init__(self, form: Form, known: Iterable[Sequence[Rung]] = ()) -> None:
        """Begin a file; ``known`` are the earlier rungs that each drawn one can be, if any."""
        self._form = form
        self._known = iter(known)
        self.read: list[Rung] = []
        self.moved: dict[int, Rung] = {}
        self.uses: list[tuple[str, Location, bool]] = []

    def rung(self, element: Element) -> Rung:
        """Return a rung."""
        self._form.count(element, 'rungs', grammar.MAX_RUNGS)
        known = next(self._known, ())
        rung = self._taken_over(element, known) if known else self._drawn(element)
        self.read.append(rung)
        return rung

    def _taken_over(self, element: Element, known: Sequence[Rung]) -> Rung:
        """Return a rung of an earlier reading, at the place where it is now."""
        file, pou = self._form.file, self._form.pou
        rung = next((rung for rung in known if rung.location.pou == pou), known[0])
        place = rung.location
        by = element.line - (place.line or 0)
        if by or place.pou != pou or place.file != file:
            moved = _moved(rung, file, pou, by)
            self.moved[id(moved)] = rung
            rung = moved
        self._count(rung.components)
        self.uses += [(component.composite, component.location, False)
                      for component in rung.components if isinstance(component, Instance)]
        return rung

    def _drawn(self, element: Element) -> Rung:
        rule = RULES['rung']
        self._form.rung_id = shown(element.attributes.get('id', ''))
        self._form.check(element, rule)
        identifier, place = self._form.identifier(element), self._form.here(element)
        width = self._form.size(element, 'width')
        children = self._form.children(element, rule)
        components = tuple([self._component(child) for child in children])
        self._count(components)
        self._form.rung_id = ''
        return _rung(
            id=identifier, width=width, components=components,
            comment=element.attributes.get('comment', ''), location=place)

    def _count(self, components: Sequence[Component]) -> None:
        count = self._form.count_all
        count('components', grammar.MAX_COMPONENTS, [1] * len(components), components)
        count('cells', grammar.MAX_CELLS, [
            component.placement.width * component.placement.height for component in components],
            components)

    def alone(self, element: Element) -> Rung:
        """Return the rung that an instance fills: it stands for both."""
        self._form.count(element, 'rungs', grammar.MAX_RUNGS)
        rule = RULES['body/instance']
        self._form.rung_id = shown(element.attributes.get('rung', ''))
        self._form.check(element, rule)
        identifier, place = self._form.identifier(element, 'rung'), self._form.here(element)
        self._form.cell = (0, 0)
        placement = self._placement(element)
        instance = self._instance(
            element, grammar.INSTANCE_ALONE, placement,
            [self._argument(child) for child in self._form.children(element, rule)])
        self._count((instance,))
        self._form.cell = None
        self._form.rung_id = ''
        return _rung(
            id=identifier, width=placement.width, components=(instance,),
            comment=element.attributes.get('comment', ''), location=place)

    def _component(self, element: Element) -> Component:
        get = element.attributes.get
        identifier, operand, comment = get('id'), get('operand'), get('comment')
        key = (element.tag, get('x'), get('y'), get('width'), get('height'), get('up'),
               get('down'), get('kind'), len(element.attributes) - (comment is not None))
        look = _LOOKS.get(key)
        if (look is None or identifier is None or operand is None or element.children
                or element.text_line is not None
                or len(identifier) + len(operand) + len(comment or '') > _SHORT):
            return self._unknown(element, key)
        self._form.cell = look.cell
        component = look.make(
            id=self._form.identifiers.get(identifier) or self._form.identifier(element),
            operand=self._form.operands.get(operand) or self._form.operand(element),
            placement=look.placement, kind=look.kind, comment=comment or '',
            location=self._form.here(element))
        self._form.cell = None
        return component

    def _unknown(self, element: Element, key: tuple[object, ...]) -> Component:
        """Return a component that has no known look, or more than that."""
        found = len(self._form.findings.diagnostics)
        component = self._placed(element)
        if isinstance(component, (Contact, Coil)) and element.attributes.keys() <= _LOOK and (
                found == len(self._form.findings.diagnostics)):
            _remember(_LOOKS, key, _Look(
                make=_contact if isinstance(component, Contact) else _coil,
                placement=component.placement, kind=component.kind, cell=self._form.cell))
        self._form.cell = None
        return component

    def _placement(self, element: Element) -> Placement:
        get = element.attributes.get
        x, y = get('x'), get('y')
        key = (element.tag == 'column', x, y, get('width'), get('height'), get('up'), get('down'))
        place = _PLACEMENTS.get(key)
        if place is None:
            before = len(self._form.findings.diagnostics)
            place = self._new_placement(element)
            if len(self._form.findings.diagnostics) == before and not (x is None or y is None):
                _remember(_PLACEMENTS, key, place)
        else:
            self._form.cell = (place.x, place.y)
        return place

    def _new_placement(self, element: Element) -> Placement:
        attributes = element.attributes
        x, y = attributes.get('x', ''), attributes.get('y', '')
        if grammar.NUMBER.fullmatch(x) and grammar.NUMBER.fullmatch(y):
            self._form.cell = (int(x), int(y))
        # A vertical line stands on a grid line and covers no cell.
        width = 0 if element.tag == 'column' else self._form.size(element, 'width')
        height = self._form.size(element, 'height')
        return Placement(
            x=self._form.number(element, 'x'), y=self._form.number(element, 'y'),
            width=width, height=height, up=self._form.word(element, 'up', Side.NONE),
            down=self._form.word(element, 'down', Side.NONE))

    def _placed(self, element: Element) -> Component:
        rule = RULES[element.tag]
        placement = self._placement(element)
        self._form.check(element, rule)
        identifier, place = self._form.identifier(element), self._form.here(element)
        name = element.attributes.get('name', '')
        comment = element.attributes.get('comment', '')
        specification = ''
        inner: dict[str, list[Argument]] = defaultdict(list)
        for child in self._form.children(element, rule) if element.children else ():
            if child.tag == 'specification':
                specification = self._form.specification(child)
            else:
                inner[child.tag].append(self._argument(child))
        match element.tag:
            case 'contact':
                return _contact(
                    id=identifier, placement=placement, operand=self._form.operand(element),
                    kind=self._form.word(element, 'kind', ContactKind.NORMALLY_OPEN),
                    was=self._form.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case 'coil':
                return _coil(
                    id=identifier, placement=placement, operand=self._form.operand(element),
                    kind=self._form.word(element, 'kind', CoilKind.COIL),
                    was=self._form.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case 'row':
                return Row(
                    id=identifier, placement=placement, name=name, comment=comment,
                    specification=specification, location=place)
            case 'column':
                return Column(
                    id=identifier, placement=placement, name=name, comment=comment,
                    specification=specification, location=place)
            case 'block':
                return Block(
                    id=identifier, placement=placement, type=self._form.operand(element, 'type'),
                    instance=self._form.optional_name(element, 'instance'),
                    inputs=tuple(inner['input']), outputs=tuple(inner['output']),
                    was=self._form.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case _:
                instance = self._instance(element, identifier, placement, inner['argument'])
                return instance if not (name or comment or specification) else replace(
                    instance, name=name, comment=comment, specification=specification)

    def _instance(
        self, element: Element, identifier: str, placement: Placement,
        arguments: Iterable[Argument],
    ) -> Instance:
        """Return a composite in use."""
        place = self._form.here(element)
        composite = self._form.operand(element, 'composite')
        self.uses.append((composite, place, False))
        return _instance(
            id=identifier, placement=placement, composite=composite,
            instance=self._form.name(element, 'instance'),
            arguments=(*self._bound(element), *arguments), was=self._form.was(element),
            location=place)

    def _bound(self, element: Element) -> tuple[Argument, ...]:
        """Return the arguments that an instance gives in short."""
        value = element.attributes.get('bind')
        if value is None:
            return ()
        pairs = grammar.BINDING.findall(value)
        # As we write it, which is seen faster than by the whole expression.
        is_plain = ' '.join([f'{pin}={operand}' for pin, operand in pairs]) == value
        if not is_plain and not grammar.BIND.fullmatch(value):
            self._form.bad_value(
                element, 'bind', 'write parameter=operand with blanks between them: '
                                 'Floor=served_1 Delay=T#2s; for text in quotes write <argument>s')
            return ()
        place = self._form.here(element)
        return tuple([_argument(pin=pin, operand=operand, location=place)
                      for pin, operand in pairs])

    def _argument(self, element: Element) -> Argument:
        rule = RULES[element.tag]
        self._form.check(element, rule)
        pin = self._form.operand(element, 'parameter' if element.tag == 'argument' else 'pin')
        attributes = element.attributes
        given = [key for key in ('operand', 'source', 'row') if key in attributes]
        if len(given) != 1:
            may = [key for key in ('operand', 'source', 'row') if key in rule.allowed]
            self._form.report('L0218', element, f'it has {" and ".join(given) or "none"}', pin=pin,
                        help=f'give it one of {", ".join(may)}')
        return _argument(
            pin=pin, operand=self._form.operand(element),
            source=self._form.operand(element, 'source'),
            row=self._form.number(element, 'row') if 'row' in attributes else None,
            location=self._form.here(element))


def _moved(rung: Rung, file: str, pou: str, by: int) -> Rung:
    """Return a rung that was read as it is so many lines further down, in a file and POU."""

    def place(old: Location) -> Location:
        return _location(file=file, line=(old.line or 0) + by, pou=pou, rung=old.rung,
                         cell=old.cell)

    def arguments(old: tuple[Argument, ...]) -> tuple[Argument, ...]:
        return tuple([replace(argument, location=place(argument.location)) for argument in old])

    def moved(old: Component) -> Component:
        if isinstance(old, Contact):
            return _contact(
                id=old.id, placement=old.placement, operand=old.operand, kind=old.kind,
                was=old.was, name=old.name, comment=old.comment,
                specification=old.specification, location=place(old.location))
        if isinstance(old, Block):
            return replace(old, inputs=arguments(old.inputs), outputs=arguments(old.outputs),
                           location=place(old.location))
        if isinstance(old, Instance):
            return replace(
                old, arguments=arguments(old.arguments), location=place(old.location))
        return replace(old, location=place(old.location))

    return _rung(
        id=rung.id, width=rung.width, components=tuple([moved(c) for c in rung.components]),
        comment=rung.comment, location=place(rung.location))

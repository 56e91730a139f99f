# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Write PLCopen TC6 XML 2.01: POUs, drawings with positions, types, configuration.

What is written here is decided elsewhere (``compiler.program_to_plcopen``): a :class:`Project`
holds drawings with wires, and texts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
import re

from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    PinEdge,
)
from ladder_ros.model.derived import (
    Array,
    elementary,
    Enumeration,
    Initial,
    leaves,
    Structure,
    Subrange,
    Type,
)
from ladder_ros.model.program import Order, Rung, Wire
from ladder_ros.model.st_printing import print_statements
from ladder_ros.model.types import DataType, format_literal, NS_PER_MS, Value
from ladder_ros.source.xml_lines import escape, quote

RAIL_X = 20
_NOT_XML = re.compile('[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
_CODE = 'http://www.3s-software.com/plcopenxml/stcode'
"""Where CODESYS keeps the statements of an EXECUTE box."""

_DATE = '2026-01-01T00:00:00'


@dataclass(frozen=True, slots=True, kw_only=True)
class Declaration:
    """A variable; ``type`` is a data type, or the name of a function block."""

    name: str
    type: Type | str
    section: str
    """A section of TC6: inputVars, outputVars, inOutVars, localVars, externalVars."""
    initial: Initial = None
    address: str = ''
    retain: bool = False
    constant: bool = False
    comment: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class PouText:
    """A POU: ``body`` is a drawing with wires or statements as text."""

    name: str
    kind: str
    """program, functionBlock or function."""
    declarations: tuple[Declaration, ...]
    body: Rung | str
    result: Type | None = None
    comment: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class RunText:
    """A program instance and the task that runs it; ``interval`` in nanoseconds."""

    name: str
    pou: str
    task: str
    interval: int
    priority: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Project:
    """All that is written."""

    name: str
    pous: tuple[PouText, ...]
    globals: tuple[Declaration, ...]
    runs: tuple[RunText, ...]
    pins: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = field(default_factory=dict)
    """Inputs and outputs of the project's own POUs by casefolded name; in-outs are inputs."""


def write_project(project: Project) -> str:
    """Return the project as the text of a file, to be saved as UTF-8."""
    return _NOT_XML.sub('?', '\n'.join(_Writer(project).lines())) + '\n'


class _Writer:
    def __init__(self, project: Project) -> None:
        self.project = project
        self.types: dict[str, list[str]] = {}

    def lines(self) -> Iterator[str]:
        pous = [line for pou in self.project.pous for line in self.pou(pou)]
        instances = list(self.configuration())
        name = quote(self.project.name)
        yield '<?xml version="1.0" encoding="UTF-8"?>'
        yield ('<project xmlns="http://www.plcopen.org/xml/tc6_0201" '
               'xmlns:xhtml="http://www.w3.org/1999/xhtml">')
        yield ('  <fileHeader companyName="ladder_ros" productName="ladder_ros" '
               f'productVersion="1" creationDateTime="{_DATE}"/>')
        yield f'  <contentHeader name={name} modificationDateTime="{_DATE}">'
        yield '    <coordinateInfo>'
        for language in ('fbd', 'ld', 'sfc'):
            yield f'      <{language}><scaling x="10" y="10"/></{language}>'
        yield '    </coordinateInfo>'
        yield '  </contentHeader>'
        yield '  <types>'
        yield '    <dataTypes>'
        for lines in self.types.values():
            yield from lines
        yield '    </dataTypes>'
        yield '    <pous>'
        yield from pous
        yield '    </pous>'
        yield '  </types>'
        yield from instances
        yield '</project>'

    # -- POUs -------------------------------------------------------------------------------

    def pou(self, pou: PouText) -> Iterator[str]:
        yield f'      <pou name={quote(pou.name)} pouType="{pou.kind}">'
        yield '        <interface>'
        if pou.result is not None:
            yield f'          <returnType>{self.type(pou.result)}</returnType>'
        yield from self.sections(pou.declarations, '          ')
        yield '        </interface>'
        yield '        <body>'
        if isinstance(pou.body, str):
            yield (f'          <ST><xhtml:p>{escape(pou.body)}</xhtml:p></ST>')
        else:
            yield '          <LD>'
            yield from self.drawing(pou.body)
            yield '          </LD>'
        yield '        </body>'
        yield from _documentation(pou.comment, '        ')
        yield '      </pou>'

    def sections(self, declarations: Sequence[Declaration], indent: str) -> Iterator[str]:
        groups: dict[tuple[str, bool, bool], list[Declaration]] = {}
        for one in declarations:
            groups.setdefault((one.section, one.constant, one.retain), []).append(one)
        for (section, constant, retain), found in groups.items():
            flags = ' constant="true"' if constant else ''
            flags += ' retain="true"' if retain else ''
            yield f'{indent}<{section}{flags}>'
            for one in found:
                yield from self.variable(one, f'{indent}  ')
            yield f'{indent}</{section}>'

    def variable(self, one: Declaration, indent: str) -> Iterator[str]:
        at = f' address={quote(one.address)}' if one.address else ''
        yield f'{indent}<variable name={quote(one.name)}{at}>'
        yield f'{indent}  <type>{self.type(one.type)}</type>'
        if not isinstance(one.type, str):
            given = {suffix: (leaf, value) for suffix, leaf, value in leaves(
                one.type, one.initial)}
            plain = {suffix: (leaf, value) for suffix, leaf, value in leaves(one.type)}
            if given != plain:
                yield f'{indent}  <initialValue>{_value(one.type, given, "")}</initialValue>'
        yield from _documentation(one.comment, f'{indent}  ')
        yield f'{indent}</variable>'

    def type(self, type_: Type | str) -> str:
        if isinstance(type_, str):
            return f'<derived name={quote(type_)}/>'
        if isinstance(type_, DataType):
            return '<string/>' if type_ is DataType.STRING else f'<{type_.value}/>'
        if isinstance(type_, Array):
            bounds = ''.join(
                f'<dimension lower="{low}" upper="{high}"/>' for low, high in type_.bounds)
            return f'<array>{bounds}<baseType>{self.type(type_.element)}</baseType></array>'
        if isinstance(type_, Subrange):
            base = f'<{type_.base.value}/>'
            kind = 'Signed' if type_.low < 0 else 'Unsigned'
            return (f'<subrange{kind}><range lower="{type_.low}" upper="{type_.high}"/>'
                    f'<baseType>{base}</baseType></subrange{kind}>')
        name = type_.name or f'structure_{len(self.types) + 1}'
        if name not in self.types:
            self.types[name] = []
            self.types[name] = list(self.data_type(name, type_))
        return f'<derived name={quote(name)}/>'

    def data_type(self, name: str, type_: Structure | Enumeration) -> Iterator[str]:
        yield f'      <dataType name={quote(name)}>'
        if isinstance(type_, Enumeration):
            values = ''.join(f'<value name={quote(known)} value="{number}"/>'
                             for known, number in type_.values)
            yield f'        <baseType><enum><values>{values}</values></enum></baseType>'
        else:
            yield '        <baseType><struct>'
            for part in type_.fields:
                yield from self.variable(Declaration(
                    name=part.name, type=part.type, section='', initial=part.initial),
                    '          ')
            yield '        </struct></baseType>'
        yield '      </dataType>'

    def configuration(self) -> Iterator[str]:
        yield '  <instances>'
        yield '    <configurations>'
        yield '      <configuration name="config">'
        yield '        <resource name="resource1">'
        tasks: dict[str, list[RunText]] = {}
        for run in self.project.runs:
            tasks.setdefault(run.task, []).append(run)
        for name, runs in tasks.items():
            milliseconds, rest = divmod(runs[0].interval, NS_PER_MS)
            part = f'.{rest:06}'.rstrip('0') if rest else ''
            yield (f'          <task name={quote(name)} priority="{runs[0].priority}" '
                   f'interval="T#{milliseconds}{part}ms">')
            for run in runs:
                yield (f'            <pouInstance name={quote(run.name)} '
                       f'typeName={quote(run.pou)}/>')
            yield '          </task>'
        yield '        </resource>'
        yield from self.sections(self.project.globals, '        ')
        yield '      </configuration>'
        yield '    </configurations>'
        yield '  </instances>'

    # -- drawings ---------------------------------------------------------------------------

    def drawing(self, rung: Rung) -> Iterator[str]:
        wires: dict[tuple[str, str], list[Wire]] = {}
        pins: dict[str, dict[str, None]] = {}
        for wire in rung.wires or ():
            wires.setdefault((wire.target.component, wire.target.pin), []).append(wire)
            pins.setdefault(wire.target.component, {})[f'in {wire.target.pin}'] = None
            if wire.source.component:
                pins.setdefault(wire.source.component, {})[f'out {wire.source.pin}'] = None
        bottom = max((c.placement.y + c.placement.height for c in rung.components), default=40)
        right = max((c.placement.x + c.placement.width for c in rung.components), default=100)
        ids = _local_ids(rung.components)
        places = {c.id: c for c in rung.components}
        if rung.comment:
            yield (f'            <comment localId="{ids["comment"]}" height="20" '
                   f'width="300"><position x="0" y="0"/><content><xhtml:p>'
                   f'{escape(rung.comment)}</xhtml:p></content></comment>')
        yield (f'            <leftPowerRail localId="{ids[""]}" width="3" '
               f'height="{bottom + 20}"><position x="{RAIL_X}" y="0"/>'
               '<connectionPointOut formalParameter=""><relPosition x="3" y="20"/>'
               '</connectionPointOut></leftPowerRail>')
        shapes = _Shapes(ids=ids, wires=wires, places=places, pins=pins, project=self.project)
        is_numbered, order = _is_numbered(rung), 0
        for component in rung.components:
            number = 0
            if is_numbered and isinstance(
                component, (Coil, OutVariable, Jump, Label, Block, Instance)):
                order += 1
                number = order
            yield from shapes.component(component, number)
        ends = [ids[c.id] for c in rung.components if isinstance(c, Coil)]
        yield (f'            <rightPowerRail localId="{ids["right"]}" width="3" '
               f'height="{bottom + 20}"><position x="{right + 60}" y="0"/>'
               '<connectionPointIn><relPosition x="0" y="20"/>'
               + ''.join(f'<connection refLocalId="{end}"/>' for end in ends)
               + '</connectionPointIn></rightPowerRail>')


def _is_numbered(rung: Rung) -> bool:
    """Say whether numbers must tell the order: where neither positions nor the document do."""
    spots = {(c.placement.x, c.placement.y) for c in rung.components}
    return rung.order is Order.DOCUMENT and (
        len(spots) > 1 or any(isinstance(c, Jump) and c.at_once for c in rung.components))


def _local_ids(components: Sequence[Component]) -> dict[str, str]:
    """Return a number for every component, the rails and the comment."""
    ids: dict[str, str] = {}
    taken: set[str] = set()
    for component in components:
        if component.id.isdecimal() and component.id not in taken:
            ids[component.id] = component.id
            taken.add(component.id)
    last = max((int(number) for number in taken), default=0)
    for name in (*(c.id for c in components), '', 'right', 'comment'):
        if name not in ids:
            last += 1
            ids[name] = str(last)
    return ids


@dataclass(frozen=True, slots=True, kw_only=True)
class _Shapes:
    ids: Mapping[str, str]
    wires: Mapping[tuple[str, str], Sequence[Wire]]
    places: Mapping[str, Component]
    pins: Mapping[str, Mapping[str, None]]
    project: Project

    def component(self, component: Component, order: int) -> Iterator[str]:
        """Yield an element; ``order`` is its place among the statements, 0 for none."""
        place = component.placement
        number = f' executionOrderId="{order}"' if order else ''
        head = (f'localId="{self.ids[component.id]}" width="{max(place.width, 1)}" '
                f'height="{max(place.height, 1)}"{number}')
        at = f'<position x="{place.x}" y="{place.y}"/>'
        match component:
            case Contact():
                yield (f'            <contact {head}{_contact(component.kind)}>{at}'
                       f'{self.taken(component, "")}{self.given(component)}'
                       f'<variable>{escape(component.operand)}</variable></contact>')
            case Coil():
                yield (f'            <coil {head}{_coil(component.kind)}>{at}'
                       f'{self.taken(component, "")}{self.given(component)}'
                       f'<variable>{escape(component.operand)}</variable></coil>')
            case InVariable():
                yield (f'            <inVariable {head}{_negated(component.negated)}>{at}'
                       f'{self.given(component)}'
                       f'<expression>{escape(component.operand)}</expression></inVariable>')
            case OutVariable():
                yield (f'            <outVariable {head}{_negated(component.negated)}>{at}'
                       f'{self.taken(component, "")}'
                       f'<expression>{escape(component.operand)}</expression></outVariable>')
            case Jump():
                tag = f'jump label={quote(component.label)}' if component.label else 'return'
                yield (f'            <{tag} {head}>{at}'
                       f'{self.taken(component, "")}{_inverted(component)}</{tag.split()[0]}>')
            case Label():
                yield (f'            <label label={quote(component.label)} {head}>{at}'
                       '</label>')
            case Block() | Instance():
                yield from self.block(component, head, at)
            case _:
                pass

    def given(self, component: Component) -> str:
        place = component.placement
        return (f'<connectionPointOut><relPosition x="{place.width}" y="{_middle(component)}"/>'
                '</connectionPointOut>')

    def taken(self, component: Component, pin: str, at: int | None = None) -> str:
        """Return the connection point of a pin, with its connections."""
        y = _middle(component) if at is None else at
        end = (component.placement.x, component.placement.y + y)
        text = f'<connectionPointIn><relPosition x="0" y="{y}"/>'
        for wire in self.wires.get((component.id, pin), ()):
            name = f' formalParameter={quote(wire.source.pin)}' if wire.source.pin else ''
            start = self.start(wire)
            middle = (start[0] + end[0]) // 2
            points = [end, (middle, end[1]), (middle, start[1]), start]
            text += (f'<connection refLocalId="{self.ids[wire.source.component]}"{name}>'
                     + ''.join(f'<position x="{x}" y="{y}"/>' for x, y in points)
                     + '</connection>')
        return text + '</connectionPointIn>'

    def start(self, wire: Wire) -> tuple[int, int]:
        """Return where a wire starts on the page."""
        source = self.places.get(wire.source.component)
        if source is None:
            return RAIL_X + 3, 20
        place = source.placement
        if isinstance(source, (Block, Instance)):
            names = self.all_pins(source)[1]
            return place.x + place.width, place.y + pin_y(names.index(wire.source.pin))
        return place.x + place.width, place.y + _middle(source)

    def all_pins(self, block: Block | Instance) -> tuple[list[str], list[str]]:
        """Return the input and output pins of a block, in the order of its definition."""
        used = self.pins.get(block.id, {})
        ins = [key[3:] for key in used if key.startswith('in ')]
        outs = [key[4:] for key in used if key.startswith('out ')]
        type_ = block.type if isinstance(block, Block) else block.composite
        kind = CATALOGUE.get(type_.upper()) if isinstance(block, Block) else None
        if kind is not None:
            known_in = [pin.name for pin in kind.inputs_for(ins)]
            known_out = [pin.name for pin in kind.outputs]
        else:
            known = self.project.pins.get(type_.casefold(), ((), ()))
            known_in, known_out = ['EN', *known[0]], ['ENO', *known[1]]
        powered = 'EN' in ins or 'ENO' in outs
        left = [n for n in known_in if n != 'EN' or powered] + [
            n for n in ins if n not in known_in]
        right = [n for n in known_out if n != 'ENO' or powered] + [
            n for n in outs if n not in known_out]
        if powered and 'EN' not in left:
            left.insert(0, 'EN')
        if 'EN' in left[1:]:
            left.sort(key=lambda name: name != 'EN')
        if powered and 'ENO' not in right:
            right.insert(0, 'ENO')
        if 'ENO' in right[1:]:
            right.sort(key=lambda name: name != 'ENO')
        return left, right

    def block(self, block: Block | Instance, head: str, at: str) -> Iterator[str]:
        type_ = block.type if isinstance(block, Block) else block.composite
        name = f' instanceName={quote(block.instance)}' if block.instance else ''
        yield f'            <block {head} typeName={quote(type_)}{name}>{at}'
        ins, outs = self.all_pins(block)
        modifiers = {m.pin.casefold(): m for m in block.modifiers}

        def marks(pin: str) -> str:
            modifier = modifiers.get(pin.casefold())
            if modifier is None:
                return ''
            edge = '' if modifier.edge is PinEdge.NONE else f' edge="{modifier.edge.value}"'
            return _negated(modifier.negated) + edge

        # An in-out pin stands on both sides: editors leave out what is in inOutVariables.
        yield '              <inputVariables>'
        for index, pin in enumerate(ins):
            yield (f'                <variable formalParameter={quote(pin)}{marks(pin)}>'
                   f'{self.taken(block, pin, pin_y(index))}</variable>')
        yield '              </inputVariables>'
        yield '              <inOutVariables/>'
        yield '              <outputVariables>'
        for index, pin in enumerate(outs):
            yield (f'                <variable formalParameter={quote(pin)}{marks(pin)}>'
                   f'<connectionPointOut><relPosition x="{block.placement.width}" '
                   f'y="{pin_y(index)}"/></connectionPointOut></variable>')
        yield '              </outputVariables>'
        if isinstance(block, Block) and block.statements:
            text = escape('\n'.join(print_statements(block.statements)))
            yield (f'              <addData><data name="{_CODE}" handleUnknown="implementation">'
                   f'<STCode xmlns="">{text}</STCode></data></addData>')
        yield '            </block>'


def pin_y(index: int) -> int:
    """Return how far below a block's top its pin of that number is."""
    return 30 + 20 * index


def _middle(component: Component) -> int:
    return max(component.placement.height, 1) // 2


def _inverted(jump: Jump) -> str:
    """Return what says that a jump is negated: the format has no attribute for that."""
    if not jump.negated:
        return ''
    return ('<addData><data name="ladder_ros/negated" handleUnknown="implementation">'
            '<negated value="true"/></data></addData>')


def _negated(negated: bool) -> str:
    return ' negated="true"' if negated else ''


def _contact(kind: ContactKind) -> str:
    return {ContactKind.NORMALLY_OPEN: '', ContactKind.NORMALLY_CLOSED: ' negated="true"',
            ContactKind.RISING: ' edge="rising"', ContactKind.FALLING: ' edge="falling"'}[kind]


def _coil(kind: CoilKind) -> str:
    return {CoilKind.COIL: '', CoilKind.NEGATED: ' negated="true"',
            CoilKind.SET: ' storage="set"', CoilKind.RESET: ' storage="reset"',
            CoilKind.RISING: ' edge="rising"', CoilKind.FALLING: ' edge="falling"'}[kind]


def _documentation(text: str, indent: str) -> Iterator[str]:
    if text:
        yield f'{indent}<documentation><xhtml:p>{escape(text)}</xhtml:p></documentation>'


def _value(type_: Type, given: Mapping[str, tuple[DataType, Value]], at: str) -> str:
    """Return an initial value, or the part of it at a suffix, as an element."""
    if isinstance(type_, Structure):
        return '<structValue>' + ''.join(
            f'<value member={quote(part.name)}>'
            f'{_value(part.type, given, f"{at}.{part.name}")}</value>'
            for part in type_.fields) + '</structValue>'
    if isinstance(type_, Array):
        places = [suffix for suffix, _, _ in leaves(replace(type_, element=DataType.BOOL))]
        return '<arrayValue>' + ''.join(
            f'<value>{_value(type_.element, given, at + place)}</value>'
            for place in places) + '</arrayValue>'
    leaf, value = given[at]
    text = format_literal(value, elementary(type_) or leaf)
    if isinstance(type_, Enumeration):
        text = next((name for name, number in type_.values if number == value), text)
    return f'<simpleValue value={quote(text)}/>'

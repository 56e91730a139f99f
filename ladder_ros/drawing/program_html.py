# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A whole program as one HTML page, for reading offline and on paper.

The page is also well-formed XML, has no scripts and loads nothing.  What the program's author
wrote is text in it, never markup.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ladder_ros.diagnostics import Diagnostic, Location
from ladder_ros.drawing.captions import text_lines
from ladder_ros.drawing.glyphs import UNICODE
from ladder_ros.drawing.page_style import PAGE_STYLE
from ladder_ros.drawing.program_svg import PLAIN, pou_pictures, pou_prefix, ProgramStyle
from ladder_ros.drawing.rung_svg import component_anchor, Picture, rung_anchor
from ladder_ros.drawing.svg_sheet import anchor, markup, STYLE_SHEET
from ladder_ros.model.component import Instance
from ladder_ros.model.derived import Initial, initial_text, Type, type_name
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Pou,
    pou_key,
    Program,
    RunKind,
    Task,
    Variable,
)
from ladder_ros.model.references import Access, References, Use
from ladder_ros.model.types import format_time

Row = Sequence[str]
"""Cells of a table, as markup."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What a page tells: a program whose rungs are on our grid, and what is known of it.

    ``facts`` stand in the header; ``measures`` by casefolded composite below its specification;
    ``style`` is that of the drawings.
    """

    program: Program
    facts: Sequence[tuple[str, str]] = ()
    measures: Mapping[str, str] = field(default_factory=dict)
    diagnostics: Sequence[Diagnostic] = ()
    references: References = field(default_factory=dict)
    style: ProgramStyle = PLAIN


@dataclass(frozen=True, slots=True, kw_only=True)
class _Page:
    """A report, and what is on its page.

    ``pictures`` of the rungs by key of the POU.  ``named`` by casefolded POU, ``rungs`` by
    casefolded POU and id; ``places`` are the rung and the XML id of each component, by key of the
    POU, rung and id, and by key of the POU and id.  Of a body and a composite of one name,
    diagnostics lead to the body.
    """

    report: Report
    pous: tuple[Pou, ...]
    keyed: Mapping[str, Pou]
    named: Mapping[str, Pou]
    pictures: Mapping[str, tuple[Picture, ...]]
    rungs: frozenset[tuple[str, str]]
    places: Mapping[tuple[str, ...], tuple[str, str]]


def _page(report: Report) -> _Page:
    pous: tuple[Pou, ...] = (*report.program.bodies, *report.program.composites)
    places: dict[tuple[str, ...], tuple[str, str]] = {}
    pictures: dict[str, tuple[Picture, ...]] = {}
    for pou in pous:
        drawn = tuple(pou_pictures(report.program, pou, report.style))
        key = pou_key(pou)
        pictures[key] = tuple(picture for _, picture in drawn)
        for rung, picture in drawn:
            for component in picture.drawn:
                place = rung, component_anchor(
                    pou.name, rung, component, pou_prefix(pou))
                places.setdefault((key, rung, component), place)
                places.setdefault((key, component), place)
    return _Page(
        report=report, pous=pous, keyed={pou_key(pou): pou for pou in pous},
        named={pou.name.casefold(): pou for pou in reversed(pous)},
        pictures=pictures, places=places,
        rungs=frozenset((pou.name.casefold(), rung.id) for pou in pous for rung in pou.rungs))


def program_html(report: Report) -> str:
    """Return the page."""
    program, page = report.program, _page(report)
    title = markup(program.name)
    return '\n'.join([
        '<!DOCTYPE html>',
        '<html xmlns="http://www.w3.org/1999/xhtml" lang="en">',
        '<head>', '<meta charset="utf-8"/>',
        '<meta name="viewport" content="width=device-width, initial-scale=1"/>',
        f'<title>{title}</title>', f'<style>{PAGE_STYLE}\n{STYLE_SHEET}</style>', '</head>',
        '<body>', f'<h1>{title}</h1>', *_paragraphs(program.specification), *_facts(report),
        *_contents(page), *_diagnostics(page), *_tasks(page), *_variables(page),
        *(line for body in program.bodies for line in _body(page, body)),
        *(line for composite in program.composites for line in _composite(page, composite)),
        '</body>', '</html>', ''])


# Parts of the page

def _facts(report: Report) -> Iterator[str]:
    yield '<dl>'
    for name, value in report.facts:
        yield f'<dt>{markup(name)}</dt><dd>{markup(value)}</dd>'
    yield '</dl>'


def _contents(page: _Page) -> Iterator[str]:
    program = page.report.program
    sections = [('diagnostics', 'Diagnostics', page.report.diagnostics),
                ('tasks', 'Tasks', program.tasks), ('variables', 'Variables', program.variables)]
    links = [f'<a href="#section.{name}">{text}</a>' for name, text, there in sections if there]
    for what, pous in (('bodies', program.bodies), ('composites', program.composites)):
        if pous:
            names = ', '.join(_to_pou(pou) for pou in pous)
            links.append(f'{what}: {names}')
    yield '<nav>' + ' | '.join(links) + '</nav>'


def _diagnostics(page: _Page) -> Iterator[str]:
    if not page.report.diagnostics:
        return
    yield '<h2 id="section.diagnostics">Diagnostics</h2>'
    yield from table(('code', 'where', 'what is wrong', 'what to do'), (
        (f'<span class="{one.severity.value}">{one.severity.value}</span> {markup(one.code)}',
         _where(page, one.location),
         markup(one.message) + (f'<br/>{markup(one.label)}' if one.label else ''),
         markup(one.help)) for one in page.report.diagnostics))


def _tasks(page: _Page) -> Iterator[str]:
    tasks = page.report.program.tasks
    if not tasks:
        return
    yield '<h2 id="section.tasks">Tasks</h2>'
    yield from table(
        ('task', 'interval', 'at rising', 'priority', 'watchdog', 'bodies'),
        (_task_row(page.report.program, task) for task in tasks))


def _task_row(program: Program, task: Task) -> Row:
    bodies = (body for body in program.bodies if body.task.casefold() == task.name.casefold())
    watchdog = f'{format_time(task.watchdog)} \N{MULTIPLICATION SIGN} {task.sensitivity}'
    return (markup(task.name), format_time(task.interval) if task.interval else '',
            markup(task.single), str(task.priority), watchdog if task.watchdog else '',
            ', '.join(_to_pou(body) for body in bodies))


def _variables(page: _Page) -> Iterator[str]:
    if not page.report.program.variables:
        return
    yield '<h2 id="section.variables">Variables</h2>'
    yield from table(
        ('name', 'type', 'class', 'initial', 'address', 'comment', 'written at', 'read at'),
        (_variable_row(page, variable) for variable in page.report.program.variables))


def _variable_row(page: _Page, variable: Variable) -> Row:
    kinds = [variable.variable_class.value] + [
        name for name, holds in (('retain', variable.retain), ('constant', variable.constant))
        if holds]
    return (_name(variable.name, '', variable.name), markup(type_name(variable.type)),
            ', '.join(kinds), _initial(variable.type, variable.initial),
            markup(variable.address), markup(variable.comment),
            *_uses(page, '', variable.name))


def _body(page: _Page, body: Body) -> Iterator[str]:
    when = 'once at start' if body.run is RunKind.ONCE else 'cyclic'
    task = f', task {markup(body.task)}' if body.task else ''
    yield f'<h2 id="{_pou_anchor(body)}">Body {markup(body.name)} <small>{when}{task}</small></h2>'
    yield from _paragraphs(body.comment)
    yield from _instances(page, body, set())
    yield from _drawings(page, body)


def _composite(page: _Page, composite: Composite) -> Iterator[str]:
    """Yield the component viewer of paper 1: name, category, interfaces, specification."""
    held = ', holds while EN is FALSE' if composite.call is CallKind.BLOCK else ''
    name, kind = markup(composite.name), f'{composite.call.value}{held}'
    category = f', {markup(composite.category)}' if composite.category else ''
    yield (f'<h2 id="{_pou_anchor(composite)}">Composite {name} '
           f'<small>{kind}{category}</small></h2>')
    yield from _paragraphs(composite.specification)
    measure = page.report.measures.get(composite.name.casefold())
    if measure:
        yield f'<p class="quiet">{markup(measure)}</p>'
    uses = [_link(page, Use(access=Access.STATE, name=component.instance, pou=pou_key(pou),
                            rung=rung.id, component=component.id)) for pou in page.pous
            for rung in pou.rungs for component in rung.components
            if isinstance(component, Instance)
            and component.composite.casefold() == composite.name.casefold()]
    yield f'<p>Used at: {", ".join(uses) or "nowhere"}</p>'
    rows = [(parameter.direction.value, parameter.name, parameter.type, parameter.default,
             parameter.comment) for parameter in composite.parameters]
    rows += [('local', variable.name, variable.type, variable.initial, variable.comment)
             for variable in composite.variables]
    if rows:
        yield from table(
            ('interface', 'name', 'type', 'initial', 'comment', 'written at', 'read at'),
            ((what, _name(text, pou_key(composite), text), markup(type_name(type_)),
              _initial(type_, initial), markup(comment), *_uses(page, pou_key(composite), text))
             for what, text, type_, initial, comment in rows))
    yield from _instances(page, composite, {text.casefold() for _, text, _, _, _ in rows})
    yield from _drawings(page, composite)


def _instances(page: _Page, pou: Pou, declared: set[str]) -> Iterator[str]:
    """Yield a table of the blocks and composites that keep a state in a POU."""
    scope = pou_key(pou)
    rows = [(_name(uses[0].name, scope, key),
             _links(page, [use for use in uses if use.access is Access.STATE]),
             _links(page, [use for use in uses if use.access is not Access.STATE]))
            for (where, key), uses in page.report.references.items()
            if where == scope and key not in declared]
    if rows:
        yield from table(('instance', 'called at', 'used at'), rows)


def _drawings(page: _Page, pou: Pou) -> Iterator[str]:
    if pou.unsupported:
        yield f'<p class="error">cannot run: {markup(pou.unsupported)}</p>'
    for picture in page.pictures[pou_key(pou)]:
        yield from figure(picture)
    if pou.statements:
        yield '<pre>' + '\n'.join(map(markup, text_lines(pou.statements, UNICODE))) + '</pre>'


def figure(picture: Picture) -> Iterator[str]:
    """Yield a picture as part of a page."""
    width, height = picture.width, picture.height
    yield (f'<figure><svg xmlns="http://www.w3.org/2000/svg" class="ladder" width="{width}" '
           f'height="{height}" viewBox="0 0 {width} {height}">')
    yield from picture.elements
    yield '</svg></figure>'


# Small things

def _paragraphs(text: str) -> Iterator[str]:
    yield from (f'<p>{markup(line)}</p>' for line in text.strip().splitlines() if line.strip())


def table(header: Row, rows: Iterable[Row]) -> Iterator[str]:
    """Yield a table without the columns that are empty in all rows."""
    filled = list(rows)
    shown = [at for at in range(len(header)) if any(row[at] for row in filled)]
    yield '<table>'
    yield '<thead><tr>' + ''.join(f'<th>{header[at]}</th>' for at in shown) + '</tr></thead>'
    yield '<tbody>'
    for row in filled:
        yield '<tr>' + ''.join(f'<td>{row[at]}</td>' for at in shown) + '</tr>'
    yield '</tbody></table>'


def _initial(type_: Type, initial: Initial) -> str:
    return '' if initial is None else markup(initial_text(type_, initial))


def _name(text: str, scope: str, name: str) -> str:
    """Return a name that links can lead to."""
    place = f'variable.{anchor(scope, name.casefold())}'
    return f'<b id="{place}">{markup(text)}</b>'


def _uses(page: _Page, scope: str, name: str) -> tuple[str, str]:
    """Return the links to where a variable is written and read."""
    uses = page.report.references.get((scope, name.casefold()), ())
    return (_links(page, [u for u in uses if u.access in (Access.WRITE, Access.BOTH)]),
            _links(page, [u for u in uses if u.access is not Access.WRITE]))


def _links(page: _Page, uses: Iterable[Use]) -> str:
    return ', '.join(dict.fromkeys(_link(page, use) for use in uses))


def _link(page: _Page, use: Use) -> str:
    """Return a link to the component, where it is drawn; else to the POU."""
    key, rung, component = use.pou, use.rung, use.component
    pou = page.keyed[key]
    if not component:
        return _to_pou(pou)
    # A value that is written at a pin of an imported drawing belongs to the block.
    owner = component.partition('-')[0]
    keys: tuple[tuple[str, ...], ...] = (
        (key, rung, component), (key, component), (key, owner))
    found = next((page.places[one] for one in keys if one in page.places), None)
    if found is None:
        return _to_pou(pou)
    drawn, place = found
    text = markup(f'{pou.name}/{drawn}')
    return f'<a href="#{place}" title="{markup(component)}">{text}</a>'


def _pou_anchor(pou: Pou) -> str:
    return pou_prefix(pou) + anchor(pou.name)


def _to_pou(pou: Pou) -> str:
    return f'<a href="#{_pou_anchor(pou)}">{markup(pou.name)}</a>'


def _where(page: _Page, location: Location) -> str:
    """Return where a diagnostic belongs, as a link if that is on the page."""
    cell = f' cell ({location.cell[0]}, {location.cell[1]})' if location.cell else ''
    line = f'line {location.line}' if location.line is not None else ''
    text = markup('/'.join(filter(None, (location.pou, location.rung))) + cell or line)
    pou = page.named.get(location.pou.casefold())
    if pou is None:
        return text
    there = (pou.name.casefold(), location.rung) in page.rungs
    place = rung_anchor(pou.name, location.rung, pou_prefix(pou)) if there else _pou_anchor(pou)
    return f'<a href="#{place}">{text}</a>'

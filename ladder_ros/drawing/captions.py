# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is written beside drawings: headings, interfaces, texts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import wrap

from typing_extensions import assert_never

from ladder_ros.drawing.canvas import printable
from ladder_ros.drawing.glyphs import Glyphs
from ladder_ros.model.component import Block
from ladder_ros.model.derived import initial_text, type_name
from ladder_ros.model.program import Body, CallKind, Composite, Pou, Rung, RunKind
from ladder_ros.model.st import Statement
from ladder_ros.model.st_printing import print_statements

TEXT_WIDTH = 90


def inner_texts(rung: Rung, glyphs: Glyphs) -> Iterator[str]:
    """Yield the statements of the boxes that hold some."""
    for component in rung.components:
        if isinstance(component, Block) and component.statements:
            yield f'  {printable(component.id, glyphs)} {printable(component.type, glyphs)}:'
            yield from text_lines(component.statements, glyphs)


def text_lines(statements: Sequence[Statement], glyphs: Glyphs) -> Iterator[str]:
    """Yield statements as lines that stand below a header."""
    return (f'    {printable(line, glyphs)}' for line in print_statements(statements))


def titled(title: str, specification: str, glyphs: Glyphs) -> str:
    """Return a heading and, indented below it, the lines of a specification."""
    lines = [printable(title, glyphs)]
    for paragraph in specification.strip().splitlines():
        lines += wrap(printable(paragraph, glyphs), TEXT_WIDTH, initial_indent='    ',
                      subsequent_indent='    ', break_on_hyphens=False)
    return '\n'.join(lines)


def pou_header(pou: Pou, glyphs: Glyphs, imported: bool = False) -> str:
    """Return what a POU is, its specification and its interface, as lines."""
    order = f', order {pou.rungs[0].order.value}' if imported and pou.rungs else ''
    match pou:
        case Body():
            when = 'once at start' if pou.run is RunKind.ONCE else 'cyclic'
            task = f', task {pou.task}' if pou.task else ''
            return titled(f'body {pou.name} ({when}{task}{order})', pou.comment, glyphs)
        case Composite():
            category = f', {pou.category}' if pou.category else ''
            holds = ', holds while EN is FALSE' if pou.call is CallKind.BLOCK else ''
            title = f'composite {pou.name} ({pou.call.value}{holds}{order}{category})'
            return '\n'.join([titled(title, pou.specification, glyphs),
                              *_interface(pou, glyphs)])
        case _:
            assert_never(pou)


def _interface(composite: Composite, glyphs: Glyphs) -> Iterator[str]:
    """Yield a line for each parameter and variable, as IEC 61131-3 declares them."""
    rows = []
    for parameter in composite.parameters:
        default = '' if parameter.default is None else \
            f' := {initial_text(parameter.type, parameter.default)}'
        rows.append((parameter.direction.value, parameter.name,
                     f'{type_name(parameter.type)}{default}', parameter.comment))
    for variable in composite.variables:
        text = initial_text(variable.type, variable.initial)
        initial = f' := {text}' if text else ''
        rows.append(('local', variable.name, f'{type_name(variable.type)}{initial}',
                     variable.comment))
    names = max((len(name) for _, name, _, _ in rows), default=0)
    types = max((len(type_) for _, _, type_, _ in rows), default=0)
    for what, name, type_, comment in rows:
        text = f'    {what:<6} {name:<{names}} : {type_:<{types}}  {comment}'
        yield printable(text, glyphs).rstrip()

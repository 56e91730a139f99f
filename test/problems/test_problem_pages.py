# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every page of docs/problems holds an example, which gives that problem and prints what it shows.

The files and commands in a page are run (see ``support.documents``). Problems that no command
gives are made by calling what raises them, in ``problems.makers``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import re

import pytest
from support.documents import compare, fences, links, rewritten, ROOT

from ladder_ros.problems import PROBLEMS, Severity
from problems.makers import MAKERS

PAGES = ROOT / 'docs' / 'problems'
REPORTED = re.compile(r'\b(error|warning|hint) (L\d{4}): ')


def page(code: str) -> str:
    return (PAGES / f'{code}.md').read_text(encoding='utf-8')


def shown(code: str) -> str:
    blocks = fences(page(code))
    return ''.join(block.text for block in blocks if block.language in ('console', 'text'))


def needs_ros(code: str) -> bool:
    return code == 'L0610' or any(
        '$ plc_node' in block.text for block in fences(page(code)) if block.language == 'console')


def examples() -> list[object]:
    return [
        pytest.param(code, marks=[pytest.mark.ros] if needs_ros(code) else [])
        for code in sorted(PROBLEMS) if (PAGES / f'{code}.md').is_file()]


@pytest.mark.usefixtures('ros_domain_id')
@pytest.mark.parametrize('code', examples())
def test_page_when_its_example_is_run_then_it_shows_what_comes_out(
    code: str, tmp_path: Path, request: pytest.FixtureRequest,
) -> None:
    maker: Callable[[Path], str] | None = MAKERS.get(code)
    compare(PAGES / f'{code}.md', rewritten(page(code), tmp_path, maker), request)


@pytest.mark.parametrize('code', sorted(PROBLEMS))
def test_page_when_its_example_is_run_then_exactly_this_problem_comes_out(code: str) -> None:
    assert set(REPORTED.findall(shown(code))) == {(PROBLEMS[code].severity.value, code)}


@pytest.mark.parametrize('code', sorted(PROBLEMS))
def test_page_when_read_then_it_has_its_parts(code: str) -> None:
    headings = re.findall(r'^#+ .*', page(code), re.MULTILINE)
    assert headings[0].startswith(f'# {code}: ')
    assert headings[1:] == ['## Example', '## What to do']
    is_warning = PROBLEMS[code].severity is Severity.WARNING
    assert page(code).split('\n\n')[1].startswith('A warning. ') == is_warning


FAMILIES = {
    'L01': 'Files', 'L02': 'Names and types', 'L03': 'Drawings', 'L04': 'Compiling',
    'L05': 'Running and simulating', 'L06': 'The node, editing and refactoring',
}
INTRODUCTION = """\
# Problems

Everything that can be wrong with a program, a table of inputs or the parameters of the node has a
code, and each code has a page: what it means, an example, what to do. Codes never change their
meaning. An *error* keeps a program from running; a *warning* does not.
"""


def listing() -> str:
    lines = [INTRODUCTION]
    for family, title in FAMILIES.items():
        lines += [f'## {title}', '', '| code | | what |', '|---|---|---|']
        lines += [
            f'| [{code}]({code}.md) | {PROBLEMS[code].severity.value} '
            f'| {page(code).splitlines()[0][len(f"# {code}: "):]} |'
            for code in sorted(PROBLEMS) if code.startswith(family)]
        lines.append('')
    return '\n'.join(lines)


def test_list_of_problems_when_read_then_each_code_has_its_line_with_the_title_of_its_page(
    request: pytest.FixtureRequest,
) -> None:
    compare(PAGES / 'README.md', listing(), request)


def test_pages_when_read_then_their_links_lead_somewhere() -> None:
    broken = [
        (path.name, target) for path in PAGES.glob('*.md')
        for target in links(path.read_text(encoding='utf-8'))
        if '://' not in target and not (PAGES / target.partition('#')[0]).exists()]
    assert broken == []

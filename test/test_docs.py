# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""README and docs: what they show comes out, what they name exists, nothing is left out."""

from __future__ import annotations

from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING
import xml.etree.ElementTree as ElementTree

import pytest
from support.documents import (
    compare,
    fences,
    links,
    prose,
    rewritten,
    ROOT,
    transcript,
    with_package,
)
import yaml

from ladder_ros.cli.verbs import VERBS
from ladder_ros.compiler.il import Op

if TYPE_CHECKING:
    from conftest import StartProcess

README = ROOT / 'README.md'
PIPELINE = ROOT / 'docs' / 'pipeline.md'
EDITING = ROOT / 'docs' / 'editing.md'
REFACTORING = ROOT / 'docs' / 'refactoring.md'
SHOWING = [README, PIPELINE, EDITING, REFACTORING, ROOT / 'docs' / 'diff.md',
           ROOT / 'docs' / 'proving.md']
PAGES = sorted([README, ROOT / 'CONTRIBUTING.md', *(ROOT / 'docs').rglob('*.md')])


def text(path: Path) -> str:
    return path.read_text(encoding='utf-8')


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def anchor(heading: str) -> str:
    """Return the anchor that a heading gets on the usual forges."""
    return re.sub(r'[^\w\- ]', '', heading.strip().lower()).replace(' ', '-')


def anchors(page: str) -> set[str]:
    return {anchor(line.lstrip('#')) for line in prose(page).splitlines() if line.startswith('#')}


def rows(page: str, heading: str) -> list[list[str]]:
    """Return the cells of the first table behind a heading, without its head."""
    behind = re.split(rf'^#+ {re.escape(heading)}$', page, flags=re.MULTILINE)[1]
    table = re.search(r'(?:^\|.*\n)+', behind, re.MULTILINE)
    assert table is not None, f'no table behind {heading}'
    return [[cell.strip() for cell in re.split(r'(?<!\\)\|', line)[1:-1]]
            for line in table.group().splitlines()[2:]]


# -- what the pages show --------------------------------------------------------------------------

@pytest.mark.parametrize('path', SHOWING, ids=name_of)
def test_page_when_its_commands_are_run_then_it_shows_what_they_print(
    path: Path, tmp_path: Path, request: pytest.FixtureRequest,
) -> None:
    compare(path, rewritten(text(path), tmp_path), request)


@pytest.mark.parametrize('path', [README, PIPELINE], ids=name_of)
def test_page_when_its_commands_are_run_then_none_reports_a_problem(path: Path) -> None:
    shown = ''.join(block.text for block in fences(text(path)) if block.language == 'console')
    assert '$ ladder ' in shown
    assert re.findall(r'(?:error|warning) L\d{4}', shown) == []


def test_readme_when_its_picture_is_compared_then_the_example_is_drawn_so(tmp_path: Path) -> None:
    picture = next(block for block in fences(text(README)) if block.language == 'text')
    drawn = transcript('$ ladder show conveyor_counter', tmp_path)
    rungs = [rung.strip() for rung in picture.text.split('\n\n')]
    assert len(rungs) == 2
    assert [rung for rung in rungs if rung not in drawn] == []


def test_readme_when_its_shell_blocks_are_read_then_every_ladder_command_works(
    tmp_path: Path,
) -> None:
    commands = re.findall(
        r'^ros2 run ladder_ros (ladder .*)$',
        ''.join(block.text for block in fences(text(README)) if block.language == 'bash'),
        re.MULTILINE)
    commands += re.findall(r'`(ladder [a-z]+ PROGRAM[^`]*)`', text(README))
    (tmp_path / 'IN.csv').write_text('\n', encoding='utf-8')
    assert len(commands) >= 6
    for command in commands:
        printed = transcript(f'$ {command.replace("PROGRAM", "start_stop")}', tmp_path)
        assert 'error' not in printed, printed


def test_readme_when_its_shell_blocks_are_read_then_ladder_commands_are_in_consoles() -> None:
    for block in fences(text(README)):
        if block.language == 'bash':
            assert not re.search(r'^ladder ', block.text, re.MULTILINE), block.text


def test_readme_when_it_names_commands_of_dev_then_dev_has_them() -> None:
    usage = subprocess.run(
        ['sh', str(ROOT / 'dev'), 'help'], capture_output=True, text=True, check=True).stdout
    named = set(re.findall(r'\./dev ([a-z]+)', text(README)))
    assert {'demo', 'test'} <= named <= set(re.findall(r'^  ([a-z]+)\b', usage, re.MULTILINE))


# -- what the pages name --------------------------------------------------------------------------

@pytest.mark.parametrize('path', PAGES, ids=name_of)
def test_page_when_its_links_are_followed_then_each_leads_somewhere(path: Path) -> None:
    broken = []
    for target in links(text(path)):
        if '://' in target:
            continue
        place, _, part = target.partition('#')
        goal = (path.parent / place).resolve() if place else path
        if not goal.exists() or (part and part not in anchors(text(goal))):
            broken.append(target)
    assert broken == []


@pytest.mark.parametrize('path', PAGES, ids=name_of)
def test_page_when_it_names_files_of_the_project_then_they_exist(path: Path) -> None:
    folders = '|'.join(('programs', 'config', 'launch', 'docs', 'test', 'ladder_ros'))
    named = re.findall(rf'`((?:{folders})/[\w./-]*\w/?)`', prose(text(path)))
    assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.mark.parametrize('path', PAGES, ids=name_of)
def test_page_when_it_names_problem_codes_then_they_exist(path: Path) -> None:
    from ladder_ros.problems import PROBLEMS
    assert set(re.findall(r'\bL0[1-6]\d\d\b', text(path))) <= set(PROBLEMS)


@pytest.mark.parametrize('path', PAGES, ids=name_of)
def test_page_when_its_xml_and_yaml_are_read_then_they_are_well_formed(path: Path) -> None:
    if path.parent.name == 'problems':
        return  # mistakes are what those are about
    for block in fences(text(path)):
        if block.language == 'xml':
            ElementTree.fromstring(block.text.encode())
        elif block.language == 'yaml':
            assert isinstance(yaml.safe_load(block.text), dict)


def test_index_when_read_then_it_leads_to_every_page() -> None:
    docs = ROOT / 'docs'
    targets = links(text(docs / 'index.md'))
    linked = {(docs / target.partition('#')[0]).resolve() for target in targets}
    pages = {path for path in docs.rglob('*.md') if path.parent.name != 'problems'}
    assert pages - linked == {docs / 'index.md'}
    assert docs / 'problems' / 'README.md' in linked


# -- what the tables list -------------------------------------------------------------------------

def test_readme_when_its_table_of_commands_is_read_then_it_has_every_verb() -> None:
    listed = [shlex.split(row[0].strip('`'))[1] for row in rows(text(README), 'The command line')]
    assert listed == list(VERBS)


def test_pipeline_when_its_table_of_instructions_is_read_then_it_has_every_operator() -> None:
    cells = ' '.join(row[0] for row in rows(text(PIPELINE), 'Instructions'))
    listed = re.findall(r'`([A-Z]+)`', cells)
    assert sorted(listed) == sorted(Op.__members__)


@pytest.mark.parametrize(('path', 'heading'), [
    (README, 'Wiring topics'), (ROOT / 'docs' / 'ros.md', 'The I/O map')], ids=['readme', 'ros'])
def test_page_when_its_table_of_the_io_map_is_read_then_its_keys_are_real(
    path: Path, heading: str,
) -> None:
    from ladder_ros.ros.io_entries import IO_RULES
    listed = {name.strip('`'): row for row in rows(text(path), heading)
              for name in row[0].split(', ')}
    known = [rule.name for rule in IO_RULES]
    # The README shows the most usual ones, the page of the node all of them.
    assert list(listed) == [name for name in known if name in listed or path != README]
    for rule in (rule for rule in IO_RULES if rule.name in listed):
        _, who, default, _ = listed[rule.name]
        if rule.default not in ('', None):
            shown = str(rule.default).lower() if rule.kind is bool else str(rule.default)
            assert default == f'`{shown}`', rule.name
        for_whom = rule.description.partition(': ')[0]
        assert who in (for_whom, for_whom.lower()) or (
            who == 'both' and for_whom.startswith(('The ', 'default'))), rule.name


def test_node_page_when_its_table_of_parameters_is_read_then_it_has_every_parameter() -> None:
    from ladder_ros.ros.parameters import RULES
    listed = {row[0].strip('`'): row for row in rows(text(ROOT / 'docs' / 'ros.md'), 'Parameters')}
    assert list(listed) == [rule.name for rule in RULES]
    for rule in RULES:
        _, kind, default, changes, _ = listed[rule.name]
        assert kind == {str: 'string', float: 'number', bool: 'boolean', int: 'integer',
                        list: 'list of strings'}[rule.kind]
        assert changes == ('no' if rule.read_only else 'yes')
        if rule.default not in ('', []):
            shown = str(rule.default).lower() if rule.kind is bool else str(rule.default)
            assert default == f'`{shown}`'


def test_node_page_when_its_tables_of_packed_variables_are_read_then_each_key_is_there() -> None:
    from ladder_ros.ros.io_entries import PACKED_RULES
    listed = [name for row in rows(text(ROOT / 'docs' / 'ros.md'), 'Packed variables')
              for name in row[0].replace('`', '').split(', ')]
    assert listed == [rule.name for rule in PACKED_RULES]


def test_node_page_when_its_example_of_a_robot_is_read_then_it_is_the_file() -> None:
    example = (ROOT / 'config' / 'mobile_robot.yaml').read_text(encoding='utf-8')
    assert f'```yaml\n{example}```' in text(ROOT / 'docs' / 'ros.md')


def test_node_page_when_its_table_of_message_types_is_read_then_defaults_are_real() -> None:
    from ladder_ros.ros.conversions import DEFAULT_MESSAGE
    listed = {}
    for types, defaults, _ in rows(text(ROOT / 'docs' / 'ros.md'), 'Message types'):
        messages = defaults.partition(', in ')[0].split(', ')
        listed.update(zip(types.split(', '), messages, strict=True))
    assert listed == {str(type_): message for type_, message in DEFAULT_MESSAGE.items()}


# -- the README's own program on topics -----------------------------------------------------------

@pytest.mark.ros
@pytest.mark.usefixtures('ros_domain_id')
def test_readme_when_its_program_runs_on_topics_then_a_change_keeps_the_motor_on(
    tmp_path: Path, process: StartProcess,
) -> None:
    for block in fences(text(README)):
        if block.file:
            (tmp_path / block.file).write_text(block.text, encoding='utf-8')
    shutil.copy(ROOT / 'test' / 'support' / 'readme_operator.py', tmp_path)
    node = process('-m', 'ladder_ros.ros.node', '--ros-args', '--params-file', 'cell.yaml',
                   cwd=tmp_path, env=with_package())
    node.wait_for_output('2 inputs, 1 outputs')
    press = subprocess.run([sys.executable, 'press.py'], cwd=tmp_path, timeout=60)
    assert press.returncode == 0
    operator = subprocess.run(
        [sys.executable, 'readme_operator.py'], cwd=tmp_path, capture_output=True, text=True,
        timeout=60)
    assert operator.returncode == 0, operator.stdout + operator.stderr
    assert operator.stdout.split() == ['motor=True', 'changed=True', 'fan=True', 'motor=True']

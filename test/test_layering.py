# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The walls between the rooms, and the sizes of what stands in them, read from the source."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
import re
import sys

import pytest

from ladder_ros.problems import PROBLEMS

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = 'ladder_ros'
HEADER = [
    '# Copyright 2026 The ladder_ros developers',
    '# SPDX-License-Identifier: Apache-2.0',
]
MODULE_LINES = 600
FUNCTION_LINES = 60

# What a room may import of the package, as module prefixes; its own modules it may always import.
BASE = {'problems', 'diagnostics', 'garbage', 'nouns'}
DATA = BASE | {'model', 'executable'}
DOORS = BASE | {
    'checking', 'showing', 'converting', 'compiling', 'simulating', 'session', 'editing',
    'refactoring', 'comparing', 'proving', 'model.types', 'executable', 'runtime.clock',
    'resources',
}
MAY_IMPORT: dict[str, set[str]] = {
    '': set(),
    'problems': set(),
    'resources': set(),
    'garbage': set(),
    'nouns': set(),
    'own_module': {''},
    'diagnostics': {'problems'},
    'model': BASE,
    'source': BASE | {'model'},
    'drawing': BASE | {'model'},
    'executable': BASE | {'model'},
    'blocks': BASE | {'model'},
    'compiler': DATA | {'source', 'blocks'},
    'coordinates': DATA | {'compiler'},
    'edit': DATA | {'source', 'blocks', 'compiler', 'coordinates'},
    'refactor': DATA | {'source', 'blocks', 'compiler', 'coordinates', 'edit'},
    'runtime': BASE | {'model.types', 'executable'},
    'comparing': DATA | {'source', 'drawing', 'coordinates', 'refactor'},
    'proving_process': {'runtime', 'own_module'},
    # Does for the runtime what the compiler can, in another process.
    'background': DATA | {'source', 'blocks', 'compiler', 'runtime', 'own_module'},
    'checking': DATA | {'source', 'compiler'},
    'converting': DATA | {'source', 'compiler'},
    'compiling': DATA | {'source', 'compiler', 'runtime'},
    'simulating': DATA | {'runtime'},
    'preparing': DATA | {'source', 'runtime', 'background', 'compiling'},
    'session': DATA | {'runtime', 'background', 'compiling', 'preparing', 'proving_process'},
    'refactoring': DATA | {'source', 'drawing', 'compiler', 'coordinates', 'refactor'},
    'proving': DATA | {'source', 'compiler', 'refactor', 'runtime'},
    'showing': DATA | {'source', 'drawing', 'compiler', 'coordinates', 'refactor'},
    'editing': DATA | {'source', 'drawing', 'edit'},
    # What a recording of topics is for a program is the node's to say; that part needs no ROS.
    'cli': DOORS | {'ros.bag'},
    'ros': DOORS,
    'studio': DOORS,
    'demo': {'resources', 'own_module'},
}

# Libraries that are not Python's own, and the only places that may import them.
ROS_ROOMS = {'ros', 'demo'}
LIBRARIES: dict[str, set[str]] = {
    'typing_extensions': {''},  # everywhere
    'lark': {'source'},
    'lxml': {'source'},
    'yaml': {'ros'},
    'rosbags': {'ros.bag'},
    'llvmlite': {'compiler.llvm_machine'},
    'z3': {'refactor.equivalence'},
    'rclpy': ROS_ROOMS,
    'rosidl_runtime_py': ROS_ROOMS,
    'rosidl_parser': ROS_ROOMS,
    'ament_index_python': ROS_ROOMS,
    'launch': ROS_ROOMS,
    'launch_ros': ROS_ROOMS,
}
MESSAGE_PACKAGE = re.compile(r'\w+_(msgs|srvs|interfaces)')

# A scan is a function of its state, inputs and `now`: only the clock module reads a clock.
CLOCKS = {'time', 'datetime', 'sched'}
WITHOUT_CLOCK = ('problems', 'diagnostics', 'model', 'source', 'drawing', 'executable', 'blocks',
                 'compiler', 'coordinates', 'edit', 'runtime', 'background')

# Modules of the compiler that run it as others do, from outside.
USERS = {'pipeline', 'building', 'stages', 'backends', 'dump', 'rung_code'}
NOUNS = ('symbols', 'wiring', 'aov', 'tree', 'il')

# What puts the stages in order.
ORDER = {'pipeline', 'stages'}

# Stages know no other stage, but for parts of their own work: an imported drawing is put in order
# first, and the statements of an EXECUTE box in it are lowered by what lowers texts.
PARTS_OF = {'wires_to_aov': {'wires_to_order', 'st_to_il'}}


@dataclass(frozen=True, slots=True, kw_only=True)
class Import:
    """One imported module as a dotted name, and the line that asks for it."""

    target: str
    line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Module:
    """A module of the package: ``name`` is dotted, without the package's own name."""

    name: str
    path: Path
    text: str
    imports: tuple[Import, ...]

    @property
    def room(self) -> str:
        return self.name.partition('.')[0]


@cache
def modules() -> dict[str, Module]:
    """Read every module of the package, by name."""
    found = {}
    for path in sorted((ROOT / PACKAGE).rglob('*.py')):
        parts = path.relative_to(ROOT / PACKAGE).with_suffix('').parts
        name = '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)
        text = path.read_text(encoding='utf-8')
        imports = tuple(_imports(ast.parse(text, str(path)), name, path))
        found[name] = Module(name=name, path=path, text=text, imports=imports)
    return found


def _imports(tree: ast.Module, name: str, path: Path) -> Iterator[Import]:
    """Yield every import, those inside functions and of types only included."""
    package = [PACKAGE, *filter(None, name.split('.'))]
    if path.name != '__init__.py':
        package.pop()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(target=alias.name, line=node.lineno)
        elif isinstance(node, ast.ImportFrom):
            above = package[:len(package) - node.level + 1] if node.level else []
            base = '.'.join([*above, *filter(None, [node.module])])
            for alias in node.names:
                # `from ladder_ros.compiler import il` names a module, not a thing in one.
                inner = _as_path(f'{base}.{alias.name}')
                is_module = base.split('.')[0] == PACKAGE and (
                    inner.with_suffix('.py').is_file() or (inner / '__init__.py').is_file()
                )
                target = f'{base}.{alias.name}' if is_module else base
                yield Import(target=target, line=node.lineno)


def _as_path(dotted: str) -> Path:
    return ROOT.joinpath(*dotted.split('.'))


def _within(name: str, prefix: str) -> bool:
    return prefix == '' or name == prefix or name.startswith(prefix + '.')


def _inner(target: str) -> str | None:
    """Return a module's name inside the package; None for one of another package."""
    if not _within(target, PACKAGE):
        return None
    return target[len(PACKAGE) + 1:]


def _place(module: Module, item: Import) -> str:
    return f'{module.path.relative_to(ROOT)}:{item.line}'


def wall_breaches(module: Module) -> list[str]:
    """List the imports of the package's own modules that cross a wall."""
    breaches = []
    for item in module.imports:
        inner = _inner(item.target)
        if not inner or (module.room and _within(inner, module.room)):
            continue
        if not any(_within(inner, allowed) for allowed in MAY_IMPORT[module.room]):
            breaches.append(f'{_place(module, item)}: {module.room} may not import {inner}')
    return breaches


def library_breaches(module: Module) -> list[str]:
    """List the imports of other people's modules that have no business in this room."""
    breaches = []
    for item in module.imports:
        library = item.target.split('.')[0]
        if library == PACKAGE or library in sys.stdlib_module_names:
            continue
        homes = ROS_ROOMS if MESSAGE_PACKAGE.fullmatch(library) else LIBRARIES.get(library, set())
        if not any(_within(module.name, home) for home in homes):
            breaches.append(
                f'{_place(module, item)}: {library} belongs in {sorted(homes) or "no room yet"}'
            )
    return breaches


def compiler_breaches(module: Module) -> list[str]:
    """List the imports inside the compiler that mix data and stages."""
    def part(name: str) -> str:
        return name.split('.')[1] if name.count('.') else ''

    def runs_stages(name: str) -> bool:
        """Say whether a module puts stages in order: to run, to print, to write another form."""
        return name in ORDER | {'dump'} or name.startswith('program_to_')

    mine = part(module.name)
    breaches = []
    for item in module.imports:
        inner = _inner(item.target) or ''
        if (not inner.startswith('compiler.') or mine in USERS | {part(inner)}
                or runs_stages(mine)):
            continue
        other = part(inner)
        stage = '_to_' in other or other in ORDER
        if other in PARTS_OF.get(mine, ()):
            continue
        if other in ORDER or (stage and (mine in NOUNS or '_to_' in mine)):
            breaches.append(f'{_place(module, item)}: {mine} may not import {other}')
        elif mine in NOUNS and other not in NOUNS and other != f'{mine}_text':
            # A noun may print itself through its text form, and needs nothing else.
            breaches.append(f'{_place(module, item)}: the noun {mine} may not import {other}')
    return breaches


def long_functions(module: Module) -> list[str]:
    """List the functions that are too long; docstrings, being welcome, are not counted."""
    found = []
    for node in ast.walk(ast.parse(module.text)):
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        length = (node.end_lineno or node.lineno) - node.lineno + 1
        if ast.get_docstring(node) is not None:
            documentation = node.body[0]
            length -= (documentation.end_lineno or 0) - documentation.lineno + 1
        if length > FUNCTION_LINES:
            found.append(f'{module.path.relative_to(ROOT)}:{node.lineno}: {node.name} ({length})')
    return found


def python_files() -> list[Path]:
    folders = (PACKAGE, 'test', 'launch', 'benchmarks')
    files = [ROOT / 'setup.py']
    for folder in folders:
        files += sorted((ROOT / folder).rglob('*.py'))
    return files


@pytest.mark.parametrize('name', sorted(modules()))
def test_module_when_imports_are_read_then_no_wall_is_crossed(name: str) -> None:
    assert wall_breaches(modules()[name]) == []


@pytest.mark.parametrize('name', sorted(modules()))
def test_module_when_imports_are_read_then_libraries_stay_in_their_rooms(name: str) -> None:
    assert library_breaches(modules()[name]) == []


def test_compiler_when_imports_are_read_then_data_and_stages_are_apart() -> None:
    compiler = [module for module in modules().values() if module.room == 'compiler']
    assert [breach for module in compiler for breach in compiler_breaches(module)] == []


def test_clock_when_imports_are_read_then_only_the_clock_module_reads_one() -> None:
    readers = [
        _place(module, item)
        for module in modules().values()
        if module.room in WITHOUT_CLOCK and module.name != 'runtime.clock'
        for item in module.imports
        if item.target.split('.')[0] in CLOCKS
    ]
    assert readers == []


def test_rooms_when_listed_then_each_has_its_walls() -> None:
    assert {module.room for module in modules().values()} <= set(MAY_IMPORT)


def test_rooms_when_listed_then_each_folder_of_modules_is_a_package() -> None:
    folders = {path.parent for path in (ROOT / PACKAGE).rglob('*.py')}
    assert [folder for folder in sorted(folders) if not (folder / '__init__.py').is_file()] == []


def test_modules_when_measured_then_none_is_too_long() -> None:
    lengths = {module.name: module.text.count('\n') for module in modules().values()}
    assert {name: lines for name, lines in lengths.items() if lines > MODULE_LINES} == {}


def test_functions_when_measured_then_none_is_too_long() -> None:
    assert [entry for module in modules().values() for entry in long_functions(module)] == []


def test_python_files_when_read_then_each_starts_with_the_licence_header() -> None:
    without = []
    for path in python_files():
        lines = path.read_text(encoding='utf-8').splitlines()
        first = 1 if lines and lines[0].startswith('#!') else 0
        if lines[first:first + 2] != HEADER:
            without.append(str(path.relative_to(ROOT)))
    assert without == []


def test_problem_codes_when_compared_with_pages_then_each_has_one_and_none_is_left_over() -> None:
    pages = {path.stem for path in (ROOT / 'docs' / 'problems').glob('*.md')}
    assert pages - {'README', 'index'} == set(PROBLEMS)


# The checks themselves: a wall that lets everything through would be no wall.

def _module(name: str, text: str) -> Module:
    path = ROOT / PACKAGE / (name.replace('.', '/') + '.py')
    return Module(
        name=name, path=path, text=text, imports=tuple(_imports(ast.parse(text), name, path)),
    )


@pytest.mark.parametrize(('name', 'text'), [
    ('runtime.x', 'from ladder_ros.compiler import pipeline'),
    ('runtime.x', 'def f():\n    from ladder_ros.blocks import timers'),
    ('runtime.x', 'from ladder_ros.model import component'),
    ('cli.x', 'import ladder_ros.ros.node'),
    ('cli.x', 'from ..runtime.controller import Controller'),
    ('model.x', 'from .. import executable'),
    ('demo.x', 'import ladder_ros.session'),
    ('diagnostics', 'from ladder_ros.model.types import DataType'),
])
def test_wall_when_crossed_then_it_is_reported(name: str, text: str) -> None:
    assert len(wall_breaches(_module(name, text))) == 1


@pytest.mark.parametrize(('name', 'text'), [
    ('runtime.x', 'from ladder_ros.model.types import DataType'),
    ('runtime.x', 'from . import clock'),
    ('cli.x', 'from ladder_ros.runtime.clock import Clock\nfrom ladder_ros import __version__'),
    ('edit.x', 'from ladder_ros.compiler.aov import Graph'),
])
def test_wall_when_not_crossed_then_nothing_is_reported(name: str, text: str) -> None:
    assert wall_breaches(_module(name, text)) == []


@pytest.mark.parametrize(('name', 'text'), [
    ('compiler.x', 'import rclpy'),
    ('session', 'from std_msgs.msg import Bool'),
    ('model.x', 'from lxml import etree'),
    ('compiler.il_to_python', 'import numba'),
    ('ros.x', 'import requests'),
])
def test_library_when_in_the_wrong_room_then_it_is_reported(name: str, text: str) -> None:
    assert len(library_breaches(_module(name, text))) == 1


@pytest.mark.parametrize(('name', 'text'), [
    ('compiler.aov', 'from ladder_ros.compiler.wiring_to_aov import build'),
    ('compiler.aov_to_tree', 'from ladder_ros.compiler.tree_to_il import emit'),
    ('compiler.il', 'from ladder_ros.compiler.il_verify import verify'),
    ('compiler.il_verify', 'from ladder_ros.compiler.pipeline import compile_program'),
    ('compiler.il_verify', 'from ladder_ros.compiler.stages import analyse'),
])
def test_compiler_when_data_and_stages_mix_then_it_is_reported(name: str, text: str) -> None:
    assert len(compiler_breaches(_module(name, text))) == 1


def test_parts_of_stages_when_listed_then_each_is_imported() -> None:
    imported = {
        (module.name.rpartition('.')[2], item.target.split('.')[2])
        for module in modules().values() if module.room == 'compiler' for item in module.imports
        if item.target.startswith(f'{PACKAGE}.compiler.')}
    assert {(stage, part) for stage, parts in PARTS_OF.items() for part in parts} <= imported


def test_function_when_too_long_then_it_is_reported() -> None:
    body = '    """One.\n\n    Two.\n    """\n' + '    x = 1\n' * FUNCTION_LINES
    assert len(long_functions(_module('x', 'def f():\n' + body))) == 1
    assert long_functions(_module('x', 'def f():\n' + body.replace('    x = 1\n', '', 1))) == []

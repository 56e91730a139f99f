# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The package as others meet it: what is declared, what a wheel holds, where files are found."""

from __future__ import annotations

from collections.abc import Callable
import os
from pathlib import Path
import re
import select
import subprocess
import sys
from typing import get_args
from xml.etree import ElementTree
import zipfile

import pytest
from support.processes import ManagedProcess

import ladder_ros
from ladder_ros.resources import find_resource, resource_dir, ResourceKind

ROOT = Path(__file__).resolve().parents[1]
KINDS: tuple[ResourceKind, ...] = get_args(ResourceKind)

# The rosdep key of each library that the package imports, where it is not the library's own name.
ROSDEP_KEYS = {
    'lark': 'python3-lark-parser',
    'lxml': 'python3-lxml',
    'typing_extensions': 'python3-typing-extensions',
    'yaml': 'python3-yaml',
}
# What the wheels of ROS 2 bring along, or what cannot be had from PyPI and is used only if there.
WITH_RCLPY = {'builtin_interfaces', 'rosidl_parser'}
OPTIONAL = {'rosidl_runtime_py', 'launch', 'launch_ros'}
# What an extra of setup.py is for, and nobody needs who does not ask for it.
EXTRA = {'rosbags', 'llvmlite', 'z3'}
IMPORT = re.compile(r'^\s*(?:from|import)\s+(\w+)', re.MULTILINE)


def setup_text() -> str:
    return (ROOT / 'setup.py').read_text(encoding='utf-8')


def manifest() -> ElementTree.Element:
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def libraries() -> set[str]:
    """Every library outside Python's own that a module of the package or a launch file imports."""
    found: set[str] = set()
    for folder in ('ladder_ros', 'launch'):
        for path in (ROOT / folder).rglob('*.py'):
            found.update(IMPORT.findall(_without_strings(path.read_text(encoding='utf-8'))))
    return found - set(sys.stdlib_module_names) - {'ladder_ros', '__future__'}


def _without_strings(text: str) -> str:
    return re.sub(r'\"\"\".*?\"\"\"', '', text, flags=re.DOTALL)


@pytest.fixture(scope='session')
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build a wheel from a copy of the sources, so that nothing is left in them."""
    folder = tmp_path_factory.mktemp('wheel')
    source = folder / 'source'
    source.mkdir()
    for name in ('package.xml', 'setup.py', 'setup.cfg', 'pyproject.toml', 'LICENSE', 'resource',
                 'ladder_ros', *KINDS):
        if (ROOT / name).exists():
            subprocess.run(['cp', '-R', str(ROOT / name), str(source)], check=True)
    _pip('wheel', '--no-build-isolation', '--no-deps', '--wheel-dir', str(folder), str(source))
    return next(folder.glob('*.whl'))


@pytest.fixture(scope='session')
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel into a prefix of its own and return that prefix."""
    prefix = tmp_path_factory.mktemp('prefix')
    _pip('install', '--no-deps', '--no-index', '--ignore-installed', '--no-warn-script-location',
         '--prefix', str(prefix), str(wheel))
    return prefix


def _pip(*args: str) -> None:
    done = subprocess.run(
        [sys.executable, '-m', 'pip', '--disable-pip-version-check', *args],
        capture_output=True, text=True, check=False, timeout=110,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def _run_installed(prefix: Path, code: str) -> str:
    packages = next(prefix.glob('**/ladder_ros/__init__.py')).parents[1]
    done = subprocess.run(
        [sys.executable, '-c', code], cwd=prefix, capture_output=True, text=True, timeout=60,
        env={**os.environ, 'PYTHONPATH': str(packages)}, check=True,
    )
    return done.stdout.strip()


def test_version_when_told_in_three_places_then_they_agree() -> None:
    in_setup = re.search(r"version='([^']+)'", setup_text())
    assert in_setup is not None
    assert manifest().findtext('version') == in_setup[1] == ladder_ros.__version__


def test_package_xml_when_read_then_it_is_a_format_3_python_package() -> None:
    package = manifest()
    assert package.get('format') == '3'
    assert package.findtext('name') == 'ladder_ros'
    assert package.findtext('export/build_type') == 'ament_python'


def test_package_xml_when_compared_with_imports_then_all_that_is_imported_is_declared() -> None:
    declared = {element.text for element in manifest().iter('exec_depend')}
    keys = {ROSDEP_KEYS.get(library, library) for library in libraries() - WITH_RCLPY - EXTRA}
    assert keys - declared == set()


def test_setup_when_compared_with_imports_then_pip_installs_all_that_can_be_had() -> None:
    names = {'yaml': 'PyYAML'}
    text = setup_text()
    missing = {
        library for library in libraries() - WITH_RCLPY - OPTIONAL
        if not re.search(
            rf"'({names.get(library, library)}|ros-jazzy-{library.replace('_', '-')})\W", text)
    }
    assert missing == set()


def test_wheel_when_built_then_it_holds_every_shared_file(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    shared = {name.partition('/data/share/ladder_ros/')[2] for name in names}
    expected = {
        path.relative_to(ROOT).as_posix()
        for kind, pattern in (('programs', '*.xml'), ('config', '*.yaml'), ('launch', '*.py'))
        for path in (ROOT / kind).rglob(pattern)
    }
    assert expected
    assert expected - shared == set()


def test_wheel_when_built_then_it_holds_schemas_and_the_typing_mark(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    schemas = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / 'ladder_ros' / 'source' / 'schema').glob('*.xsd')
    }
    assert schemas
    assert (schemas | {'ladder_ros/py.typed'}) - names == set()


def test_wheel_when_built_then_no_tests_are_in_it(wheel: Path) -> None:
    tops = {name.split('/')[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {top for top in tops if not top.startswith('ladder_ros')} == set()


def test_wheel_when_installed_then_its_commands_are_in_bin(installed: Path) -> None:
    commands = {path.name for folder in installed.rglob('bin') for path in folder.iterdir()}
    assert {'ladder', 'plc_node'} <= commands


@pytest.mark.parametrize('kind', KINDS)
def test_resource_dir_when_installed_then_it_is_the_installed_one(
    installed: Path, kind: str
) -> None:
    code = f'from ladder_ros.resources import resource_dir; print(resource_dir({kind!r}))'
    assert installed in Path(_run_installed(installed, code)).parents


def test_find_resource_when_in_the_source_tree_then_it_is_the_tree_s_own() -> None:
    path = find_resource('programs', 'elevator_3_floor.xml')
    assert path == ROOT / 'programs' / 'elevator_3_floor.xml'


@pytest.mark.parametrize('name', ['no_such.xml', '../setup.py', '/etc/hostname', '', '.'])
def test_find_resource_when_there_is_none_then_it_says_where_it_looked(name: str) -> None:
    with pytest.raises(FileNotFoundError, match=re.escape(str(ROOT / 'programs'))):
        find_resource('programs', name)


def test_resource_dir_when_found_by_ament_only_then_it_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = tmp_path / 'share' / 'ladder_ros' / 'programs'
    wanted.mkdir(parents=True)
    elsewhere = tmp_path / 'elsewhere' / 'ladder_ros' / 'resources.py'
    monkeypatch.setattr('ladder_ros.resources.__file__', str(elsewhere))
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'/nowhere:{tmp_path}')
    assert resource_dir('programs') == wanted


def test_resource_dir_when_nothing_is_installed_then_it_lists_where_it_looked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('ladder_ros.resources.__file__', str(tmp_path / 'a' / 'resources.py'))
    monkeypatch.setattr('sysconfig.get_path', lambda name: str(tmp_path / 'data'))
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path / 'ament'))
    with pytest.raises(FileNotFoundError) as raised:
        resource_dir('config')
    assert str(tmp_path / 'data/share/ladder_ros/config') in str(raised.value)
    assert str(tmp_path / 'ament/share/ladder_ros/config') in str(raised.value)


# The script ./dev, as far as it goes without installing anything.

def dev(*args: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ['/bin/sh', str(ROOT / 'dev'), *args], cwd='/', capture_output=True, text=True,
        env={**os.environ, **environment}, check=False, timeout=30,
    )


def test_dev_when_asked_for_help_then_it_names_the_two_commands() -> None:
    done = dev('help')
    assert done.returncode == 0
    assert 'demo [SECONDS]' in done.stdout
    assert 'test [ARGUMENTS]' in done.stdout


def test_dev_when_the_command_is_unknown_then_it_is_a_usage_error() -> None:
    assert dev('frobnicate').returncode == 2


def test_dev_when_the_demo_s_time_is_no_number_then_it_says_so() -> None:
    done = dev('demo', 'soon')
    assert done.returncode == 1
    assert "'soon' is no number of seconds" in done.stderr


def test_dev_when_no_python_fits_then_it_says_which_would(tmp_path: Path) -> None:
    subprocess.run(['cp', str(ROOT / 'dev'), str(ROOT / 'setup.py'), str(tmp_path)], check=True)
    done = subprocess.run(
        ['/bin/sh', str(tmp_path / 'dev'), 'setup'], capture_output=True, text=True, timeout=30,
        env={**os.environ, 'PYTHON': '/nowhere/python3'}, check=False,
    )
    assert done.returncode == 1
    assert 'no Python 3.10 to 3.13 found at /nowhere/python3' in done.stderr
    assert not (tmp_path / '.venv').exists()


# What the other tests stand on.

def test_golden_when_the_text_differs_then_the_test_fails(
    golden: Callable[[str, str], None], request: pytest.FixtureRequest
) -> None:
    if request.config.getoption('--update-goldens'):
        pytest.skip('goldens are being written')
    with pytest.raises(AssertionError, match='is missing'):
        golden('text', 'package/no_such_golden.txt')


def test_process_when_stopped_then_its_children_have_ended_too(
    process: Callable[..., ManagedProcess]
) -> None:
    script = (
        'import subprocess, sys\n'
        'child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)\n'
        'print("child", child.pid)\n'
        'print("ready")\n'
        'child.wait()\n'
    )
    parent = process('-c', script)
    child = int(parent.wait_for_output('ready').split()[1])
    end_of_child = os.pidfd_open(child)
    parent.stop()
    assert not parent.running
    assert select.select([end_of_child], [], [], 10)[0]
    os.close(end_of_child)


def test_process_when_it_ends_without_the_text_then_the_wait_fails_at_once(
    process: Callable[..., ManagedProcess]
) -> None:
    with pytest.raises(AssertionError, match='ended without'):
        process('-c', 'print("something else")').wait_for_output('ready')


def test_ros_domain_when_claimed_then_processes_inherit_it(
    ros_domain_id: int, process: Callable[..., ManagedProcess]
) -> None:
    code = 'import os; print("domain", os.environ["ROS_DOMAIN_ID"], "told")'
    printed = process('-c', code).wait_for_output('told')
    assert 1 <= ros_domain_id <= 100
    assert f'domain {ros_domain_id} told' in printed

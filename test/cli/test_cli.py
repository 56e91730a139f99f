# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The command ``ladder``: exit status, streams, one JSON document, and what each verb prints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import csv
import io
import json
import os
from pathlib import Path
import re
import subprocess
import sys

from cli.texts import BROKEN, DANGLING, SEAL_IN, TWO_COILS
import pytest

import ladder_ros
from ladder_ros import checking
from ladder_ros.cli import main as command
from ladder_ros.cli import verbs
from ladder_ros.cli.verb import Answer
from ladder_ros.compiling import BACKENDS
from ladder_ros.converting import STAGES
from ladder_ros.diagnostics import InternalError

INPUTS = 'start,stop\n1,\n0,\n,\n,1\n'
Run = subprocess.CompletedProcess[str]
Inside = Callable[..., Run]


def ladder(*args: str, cwd: Path | None = None, encoding: str = 'utf-8') -> Run:
    """Run the command; neither stream may ever hold a traceback."""
    run = subprocess.run(
        [sys.executable, '-m', 'ladder_ros.cli', *args], cwd=cwd, capture_output=True,
        timeout=60, encoding=encoding, stdin=subprocess.DEVNULL,
        env={**os.environ, 'PYTHONIOENCODING': encoding, 'COLUMNS': '90',
             'PYTHONPATH': str(Path(ladder_ros.__file__).parents[1])})
    assert 'Traceback' not in run.stderr + run.stdout
    return run


def loaded_by(*args: str, folder: Path) -> tuple[set[str], str]:
    """Run the command; return the modules that were loaded then, and what was printed."""
    script = ('import sys; from ladder_ros.cli.main import main; main(); '
              'print(*sys.modules, file=sys.stderr)')
    run = subprocess.run(
        [sys.executable, '-c', script, *args], cwd=folder, capture_output=True, timeout=60,
        encoding='utf-8', check=True,
        env={**os.environ, 'PYTHONPATH': str(Path(ladder_ros.__file__).parents[1])})
    return set(run.stderr.split()), run.stdout


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (('seal_in', SEAL_IN), ('two_coils', TWO_COILS), ('dangling', DANGLING),
                       ('broken', BROKEN)):
        (tmp_path / f'{name}.xml').write_text(text, encoding='utf-8')
    (tmp_path / 'in.csv').write_text(INPUTS)
    return tmp_path


@pytest.fixture
def inside(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Inside:
    """Run the command in this process, which is quicker, and in the folder of programs."""
    def run(*args: str) -> Run:
        status = command.main(args)
        printed = capsys.readouterr()
        return subprocess.CompletedProcess(args, status, printed.out, printed.err)

    monkeypatch.chdir(folder)
    return run


VERBS: dict[str, Sequence[str]] = {
    'check': (), 'show': (), 'dump': ('--stage', 'il'), 'export': ('--to', 'xml'),
    'simulate': ('--inputs', 'in.csv'), 'edit': ('set-rung', '1', '--comment', 'seal-in'),
}


@pytest.mark.parametrize('verb', VERBS)
def test_verb_when_the_program_is_fine_then_the_status_is_0(folder: Path, verb: str) -> None:
    run = ladder(verb, 'seal_in.xml', *VERBS[verb], cwd=folder)
    assert (run.returncode, run.stderr) == (0, '')
    assert run.stdout.endswith('\n')


@pytest.mark.parametrize('name', ['broken.xml', 'missing.xml', '.'])
@pytest.mark.parametrize('verb', VERBS)
def test_verb_when_the_program_cannot_be_read_then_the_status_is_1(
    inside: Inside, verb: str, name: str
) -> None:
    run = inside(verb, name, *VERBS[verb])
    assert run.returncode == 1
    assert 'error L01' in run.stderr + run.stdout
    assert run.stderr.startswith(name) or verb == 'check'


@pytest.mark.parametrize(('name', 'status'), [
    ('seal_in.xml', 0), ('broken.xml', 1), ('missing.xml', 1)])
@pytest.mark.parametrize('verb', VERBS)
def test_verb_when_json_is_asked_for_then_there_is_one_document(
    inside: Inside, verb: str, name: str, status: int
) -> None:
    run = inside(verb, name, *VERBS[verb], '--json')
    document = json.loads(run.stdout)
    assert run.returncode == status
    assert document['ok'] is (status == 0)
    assert [d['severity'] for d in document['diagnostics']].count('error') == status
    assert run.stderr == ''


@pytest.mark.parametrize('args', [
    (), ('chek', 'x.xml'), ('check',), ('dump', 'seal_in.xml', '--stage', 'nonsense'),
    ('simulate', 'seal_in.xml', '--scans', 'many'), ('check', 'seal_in.xml', '--nonsense')])
def test_command_when_used_wrongly_then_the_status_is_2(
    inside: Inside, args: tuple[str, ...]
) -> None:
    plain, document = inside(*args), inside(*args, '--json')
    assert (plain.returncode, document.returncode) == (2, 2)
    assert plain.stdout == '' and 'usage: ladder' in plain.stderr
    assert json.loads(document.stdout)['error']['kind'] == 'usage'


def test_verb_when_misspelt_then_the_right_one_is_offered(inside: Inside) -> None:
    assert 'did you mean simulate?' in inside('simulat', 'x.xml').stderr


def test_version_when_asked_for_then_it_is_printed() -> None:
    run = ladder('--version')
    assert (run.returncode, run.stdout) == (0, f'{ladder_ros.__version__}\n')


@pytest.mark.parametrize('args', [('--help',), *((verb, '--help') for verb in verbs.VERBS)])
def test_help_when_asked_for_then_it_has_examples(inside: Inside, args: tuple[str, ...]) -> None:
    run = inside(*args)
    assert (run.returncode, run.stderr) == (0, '')
    assert 'examples:\n  ladder ' in run.stdout


def test_help_when_asked_for_then_it_lists_every_verb_without_loading_any(folder: Path) -> None:
    loaded, printed = loaded_by('--help', folder=folder)
    listed = [line.split()[0] for line in printed.splitlines() if re.match(' {4}[a-z]', line)]
    assert listed == list(verbs.VERBS)
    assert not {f'ladder_ros.cli.{verb}' for verb in verbs.VERBS} & loaded
    rooms = {name.split('.')[1] for name in loaded if name.startswith('ladder_ros.')}
    assert rooms == {'cli', 'diagnostics', 'problems'}


@pytest.mark.parametrize(('args', 'unused'), [
    (('check', 'seal_in.xml'), {'ladder_ros.runtime', 'ladder_ros.compiler.backends'}),
    (('edit', 'seal_in.xml', 'delete', '1', 'c2'), {'ladder_ros.runtime', 'ladder_ros.refactor'}),
    (('simulate', 'seal_in.xml'), {'ladder_ros.background', 'ladder_ros.refactor'}),
])
def test_verb_when_run_then_what_it_does_not_use_is_not_loaded(
    args: tuple[str, ...], unused: set[str], folder: Path,
) -> None:
    loaded, _ = loaded_by(*args, folder=folder)
    assert not (unused | {'rclpy', 'yaml', 'z3', 'llvmlite', 'numpy', 'ladder_ros.ros'}) & loaded


def test_json_when_before_the_verb_then_it_holds_too(inside: Inside) -> None:
    assert json.loads(inside('--json', 'check', 'seal_in.xml').stdout)['ok'] is True


def test_check_when_there_are_warnings_then_only_strict_minds_them(inside: Inside) -> None:
    run = inside('check', 'two_coils.xml')
    strict = inside('check', 'two_coils.xml', '--strict')
    assert (run.returncode, strict.returncode) == (0, 1)
    assert 'warning L0212' in run.stdout
    assert run.stdout.endswith('two_coils.xml: fine (1 warning)\n')
    assert strict.stdout.endswith('two_coils.xml: not fine (1 warning)\n')


def test_check_when_the_drawing_is_wrong_then_all_of_it_is_reported(inside: Inside) -> None:
    run = inside('check', 'dangling.xml')
    assert run.returncode == 1
    assert run.stdout.count('error L0303') >= 2
    assert 'dangling.xml:' in run.stdout and 'rung 1, cell (0, 0)' in run.stdout


def test_show_when_the_drawing_is_wrong_then_it_is_drawn_nevertheless(inside: Inside) -> None:
    run = inside('show', 'dangling.xml')
    assert run.returncode == 0
    assert '×' in run.stdout and 'connected to nothing' in run.stdout


def test_show_when_the_terminal_has_no_box_characters_then_ascii_is_used(folder: Path) -> None:
    run = ladder('show', 'seal_in.xml', cwd=folder, encoding='ascii')
    assert run.returncode == 0
    assert '|--|/|--' in run.stdout or '--|/|--' in run.stdout


def test_show_when_one_pou_is_asked_for_then_only_that_is_drawn(inside: Inside) -> None:
    run = inside('show', 'seal_in.xml', '--pou', 'MAIN', '--grid')
    assert run.stdout.startswith('body main')


@pytest.mark.parametrize('args', [('show',), ('dump', '--stage', 'wiring')])
def test_pou_when_unknown_then_it_is_a_diagnostic(inside: Inside, args: tuple[str, ...]) -> None:
    run = inside(*args, 'seal_in.xml', '--pou', 'mian')
    assert run.returncode == 1
    assert 'error L0' in run.stderr and 'mian' in run.stderr


def test_dump_when_each_stage_is_asked_for_then_each_prints_something(inside: Inside) -> None:
    texts = {stage: inside('dump', 'seal_in.xml', '--stage', stage).stdout
             for stage in STAGES}
    assert len(set(texts.values())) == len(texts)
    assert all('motor' in text for text in texts.values())


def test_export_when_done_twice_then_nothing_changes(folder: Path, inside: Inside) -> None:
    once = inside('export', 'seal_in.xml', '--to', 'xml', '-o', 'once.xml')
    twice = inside('export', 'once.xml', '--to', 'xml')
    assert (once.returncode, once.stdout, twice.returncode) == (0, '', 0)
    assert twice.stdout == (folder / 'once.xml').read_text(encoding='utf-8')


def test_export_when_the_terminal_is_ascii_then_the_xml_is_still_utf_8(folder: Path) -> None:
    run = ladder('export', 'seal_in.xml', '--to', 'xml', cwd=folder, encoding='latin-1')
    assert 'läuft'.encode() in run.stdout.encode('latin-1')


def test_simulate_when_given_inputs_then_there_is_a_row_a_scan(inside: Inside) -> None:
    run = inside('simulate', 'seal_in.xml', '--inputs', 'in.csv', '--interval', '10ms',
                 '--watch', 'motor,ran,t1.Q')
    assert list(csv.reader(io.StringIO(run.stdout))) == [
        ['motor', 'ran', 't1.Q'], ['1', '0', '0'], ['1', '10', '0'], ['1', '20', '0'],
        ['0', '0', '0']]


def test_simulate_when_more_scans_than_rows_then_the_last_inputs_hold(
    folder: Path, inside: Inside
) -> None:
    (folder / 'in.csv').write_text('start\n1\n')
    run = inside('simulate', 'seal_in.xml', '--inputs', 'in.csv', '--scans', '5', '--interval',
                 '10ms', '--watch', 't1.q')
    assert run.stdout.split() == ['t1.Q', '0', '0', '0', '1', '1']


@pytest.mark.parametrize('backend', BACKENDS)
def test_simulate_when_written_to_a_file_then_backends_agree(
    folder: Path, inside: Inside, backend: str
) -> None:
    run = inside('simulate', 'seal_in.xml', '--inputs', 'in.csv', '--backend', backend, '-o',
                 'out.csv')
    plain = inside('simulate', 'seal_in.xml', '--inputs', 'in.csv')
    assert (run.returncode, run.stdout) == (0, '')
    assert (folder / 'out.csv').read_bytes().decode() == plain.stdout


def test_simulate_when_json_is_asked_for_then_rows_are_in_the_document(inside: Inside) -> None:
    run = inside('simulate', 'seal_in.xml', '--inputs', 'in.csv', '--watch', 'motor,ran',
                 '--interval', '10ms', '--json')
    document = json.loads(run.stdout)
    assert document['columns'] == ['motor', 'ran']
    assert document['rows'] == [['1', '0'], ['1', '10'], ['1', '20'], ['0', '0']]


@pytest.mark.parametrize('backend', BACKENDS)
def test_simulate_when_given_a_folder_of_tables_then_each_has_its_results(
    folder: Path, inside: Inside, backend: str
) -> None:
    (folder / 'cases').mkdir()
    texts = {'long.csv': 'start\n1\n0\n1\n', 'other.CSV': 'start,stop\n1,\n,1\n',
             'short.csv': 'start\n0\n'}
    for name, text in texts.items():
        (folder / 'cases' / name).write_text(text)
    run = inside('simulate', 'seal_in.xml', '--inputs', 'cases', '--into', 'new/results',
                 '--backend', backend)
    assert run.returncode == 0
    assert run.stdout.splitlines()[0] == '3 scans are in new/results/long.csv'
    for name in texts:
        alone = inside('simulate', 'seal_in.xml', '--inputs', f'cases/{name}')
        assert (folder / 'new' / 'results' / name).read_bytes().decode() == alone.stdout


@pytest.mark.parametrize(('args', 'code'), [
    (('--inputs', '.'), 'L0514'), (('--into', 'out'), 'L0514'),
    (('--inputs', 'in.csv', '--into', '.'), 'L0514'),
    (('--inputs', 'in.csv', '--into', 'seal_in.xml'), 'L0507'),
    (('--inputs', 'nothing', '--into', 'out'), 'L0501'),
    (('--inputs', 'missing.csv'), 'L0501'), (('--watch', 'motr'), 'L0502'),
    (('--inputs', 'bad.csv'), 'L0503'), (('--interval', '0ms'), 'L0505'),
    (('--interval', 'soon'), 'L0505'), (('-o', 'no/such/folder.csv'), 'L0507')])
def test_simulate_when_asked_for_the_impossible_then_a_diagnostic_says_why(
    folder: Path, inside: Inside, args: tuple[str, ...], code: str
) -> None:
    (folder / 'bad.csv').write_text('start\nmaybe\n')
    (folder / 'nothing').mkdir()
    run = inside('simulate', 'seal_in.xml', *args)
    assert run.returncode == 1
    assert f'error {code}' in run.stderr


def test_output_when_its_reader_has_gone_then_nothing_is_complained_of(folder: Path) -> None:
    with subprocess.Popen(
        [sys.executable, '-m', 'ladder_ros.cli', 'simulate', 'seal_in.xml', '--scans', '200000'],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, 'PYTHONPATH': str(Path(ladder_ros.__file__).parents[1])},
    ) as child:
        assert child.stdout is not None and child.stderr is not None
        child.stdout.readline()
        child.stdout.close()
        assert (child.stderr.read(), child.wait(60)) == (b'', 141)


@pytest.mark.parametrize('arguments', ['show seal_in.xml', '--help'])
@pytest.mark.parametrize('stream', ['>&-', '2>&-'])
def test_output_when_its_stream_is_closed_then_the_status_still_tells(
    folder: Path, arguments: str, stream: str,
) -> None:
    run = subprocess.run(
        f'{sys.executable} -m ladder_ros.cli {arguments} {stream}', shell=True, cwd=folder,
        capture_output=True, timeout=60,
        env={**os.environ, 'PYTHONPATH': str(Path(ladder_ros.__file__).parents[1])})
    assert (run.returncode, run.stderr) == (0, b'')


@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='no /dev/full here')
def test_output_when_the_disk_is_full_then_it_is_a_diagnostic(folder: Path) -> None:
    with open('/dev/full', 'w') as full:
        run = subprocess.run(
            [sys.executable, '-m', 'ladder_ros.cli', 'show', 'seal_in.xml'], cwd=folder,
            stdout=full, stderr=subprocess.PIPE, timeout=60, text=True,
            env={**os.environ, 'PYTHONPATH': str(Path(ladder_ros.__file__).parents[1])})
    assert run.returncode == 1
    assert 'error L0507' in run.stderr and 'Exception' not in run.stderr


@pytest.mark.parametrize(('raised', 'status', 'said'), [
    (InternalError('aov', 'a wire leads back'), 70, 'internal error in stage aov'),
    (ValueError('what\never'), 70, 'ValueError: what ever; this is a fault of ladder_ros'),
    (RecursionError(), 70, 'RecursionError; this is a fault of ladder_ros'),
    (KeyboardInterrupt(), 130, 'interrupted'),
    (BrokenPipeError(), 141, ''),
])
@pytest.mark.parametrize('as_json', [False, True])
def test_command_when_a_verb_fails_then_the_status_tells_how(
    raised: BaseException, status: int, said: str, as_json: bool,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(path: str) -> Answer:
        raise raised

    monkeypatch.setattr(checking, 'check', fail)
    monkeypatch.setattr(command.terminal, 'abandon_output', lambda: None)
    assert command.main(['check', 'x.xml', *(['--json'] if as_json else [])]) == status
    printed = capsys.readouterr()
    if as_json and status != 141:
        document = json.loads(printed.out)
        assert document['ok'] is False and said in document['error']['message']
        assert printed.err == ''
    else:
        assert printed.out == '' and said in printed.err

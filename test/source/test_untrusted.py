# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hostile and broken files: refused with a diagnostic, quickly, and never anything else."""

from __future__ import annotations

from collections.abc import Callable
import os
from pathlib import Path
import socket
import tracemalloc

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from ladder_ros.diagnostics import Diagnostic, LadderError
from ladder_ros.model.program import Program
from ladder_ros.source import grammar, xml_tree
from ladder_ros.source.read_any import read_any
from ladder_ros.source.xml_to_model import parse_program, read_program

VALID = (
    Path(__file__).resolve().parents[1] / 'cases' / 'source' / 'valid.xml'
).read_text(encoding='utf-8')


def refusal(text: bytes) -> Diagnostic:
    """Return the last diagnostic for a text that must be refused."""
    with pytest.raises(LadderError) as caught:
        parse_program(text, 'hostile.xml')
    return caught.value.diagnostics[-1]


def program(inside: str) -> bytes:
    return f'<ladder version="1" name="p">{inside}</ladder>'.encode()


def rung(inside: str) -> bytes:
    return program(f'<body name="m"><rung id="1" width="9">{inside}</rung></body>')


def read_failure(path: Path | str) -> Diagnostic:
    with pytest.raises(LadderError) as caught:
        read_program(path)
    return caught.value.diagnostics[0]


# -- entities and the outside -------------------------------------------------------------------

def test_entities_when_they_multiply_then_are_refused_without_being_expanded() -> None:
    levels = ''.join(
        f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
    text = (f'<!DOCTYPE ladder [<!ENTITY l0 "ha">{levels}]>'
            '<ladder version="1" name="p"><specification>&l9;</specification></ladder>')
    tracemalloc.start()
    try:
        assert refusal(text.encode()).code == 'L0108'
        assert tracemalloc.get_traced_memory()[1] < 5_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize('declaration', [
    '<!ENTITY x SYSTEM "{url}">', '<!ENTITY % x SYSTEM "{url}"> %x;',
    '<!ENTITY x SYSTEM "file:///etc/passwd">', '<!ENTITY x "a">', '<!ATTLIST body name CDATA "m">',
])
def test_document_type_when_it_declares_anything_then_nothing_is_opened(
    declaration: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError('the reader reached out')
    with socket.socket() as server:
        server.bind(('127.0.0.1', 0))
        url = f'http://127.0.0.1:{server.getsockname()[1]}/x'
        monkeypatch.setattr(socket.socket, 'connect', forbidden)
        monkeypatch.setattr('builtins.open', forbidden)
        text = (f'<?xml version="1.0"?><!-- <!DOCTYPE x> --><?pi?>\n'
                f'<!DOCTYPE ladder [{declaration.replace("{url}", url)}]>'
                '<ladder version="1" name="p"><specification>&x;</specification></ladder>')
        found = refusal(text.encode())
    assert (found.code, found.location.line) == ('L0108', 2)


def test_document_type_when_only_written_in_a_comment_then_is_no_problem() -> None:
    text = b'<!-- <!DOCTYPE x> -->' + program('<!-- <!DOCTYPE y [<!ENTITY z "z">]> -->')
    assert parse_program(text).name == 'p'


@pytest.mark.parametrize('inside', [
    '<xi:include href="/etc/passwd"/>',
    '<include xmlns="http://www.w3.org/2001/XInclude" href="/etc/passwd"/>',
])
def test_xinclude_when_there_then_is_an_unknown_element(inside: str) -> None:
    assert refusal(program(inside)).code == 'L0103'


def test_schema_location_when_given_then_is_never_fetched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket.socket, 'connect', None)
    text = program('').replace(b' name', b' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
                               b' xsi:noNamespaceSchemaLocation="http://127.0.0.1:9/x.xsd" name')
    assert parse_program(text).name == 'p'


# -- limits -------------------------------------------------------------------------------------

def components(count: int) -> bytes:
    row = '<row id="r" x="0" y="0"/>'
    return rung(row * count)


LIMITS: dict[str, tuple[Callable[[], bytes], str]] = {
    'bytes': (lambda: b' ' * (xml_tree.MAX_BYTES + 1), 'bytes'),
    'depth': (lambda: program('<a>' * 100_000), 'levels'),
    'elements': (lambda: program('<a/>' * (xml_tree.MAX_ELEMENTS + 1)), 'elements'),
    'attribute': (lambda: rung(f'<row id="r" x="0" y="0" name="{"n" * 5_000_000}"/>'),
                  '5000000 characters'),
    'text': (lambda: program(f'<specification>{"t" * 100_000}</specification>'), 'characters'),
    'components': (lambda: components(grammar.MAX_COMPONENTS + 1), 'components'),
    'cells': (lambda: rung('<row id="r" x="0" y="0" width="100000" height="100000"/>'), 'cells'),
    'rungs': (lambda: program(
        '<body name="m">' + '<rung id="1" width="1"/>' * (grammar.MAX_RUNGS + 1) + '</body>'),
        'rungs'),
    'bodies': (lambda: program('<body name="m"/>' * (grammar.MAX_POUS + 1)), 'bodies'),
    'variables': (lambda: program(
        '<variables>' + '<variable name="v" type="BOOL"/>' * (grammar.MAX_VARIABLES + 1)
        + '</variables>'), 'variables'),
    'tasks': (lambda: program(
        '<tasks>' + '<task name="t" interval="T#1s"/>' * (grammar.MAX_TASKS + 1) + '</tasks>'),
        'tasks'),
}


@pytest.mark.parametrize('name', LIMITS)
def test_file_when_it_passes_a_limit_then_is_refused_and_the_limit_named(
    name: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    for limit in ('MAX_COMPONENTS', 'MAX_RUNGS', 'MAX_VARIABLES'):  # smaller: it is the same test
        monkeypatch.setattr(grammar, limit, 20_000)
    monkeypatch.setattr(xml_tree, 'MAX_ELEMENTS', 200_000)
    make, word = LIMITS[name]
    found = refusal(make())
    assert found.code == 'L0107'
    assert word in found.message
    assert len(str(found)) < 1000


@pytest.mark.parametrize(('limit', 'most', 'place'), [
    ('MAX_COMPONENTS', 3, (3, (3, 0))), ('MAX_CELLS', 4, (2, (2, 0))),
    ('MAX_CELLS', 9, (3, (3, 0))),
])
def test_limit_when_a_component_passes_it_then_the_error_is_at_its_line_and_cell(
    limit: str, most: int, place: tuple[int, tuple[int, int]], monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(grammar, limit, most)
    found = refusal(rung(''.join(
        f'<row id="r{x}" x="{x}" y="0" height="{x + 1}"/>' for x in range(2))
        + '\n<row id="r2" x="2" y="0" height="3"/>\n<row id="r3" x="3" y="0" height="4"/>'))
    assert (found.code, (found.location.line, found.location.cell)) == ('L0107', place)
    assert (found.location.pou, found.location.rung) == ('m', '1')


@pytest.mark.parametrize('text', [
    b'<a ' + b'b' * 5_000_000, b'<!--' * 1_000_000, b'<' * 5_000_000, b'\n' * 16_000_000,
    b'<!DOCTYPE' * 1_000_000, b'<?' * 5_000_000, b'&' * 1_000_000,
    program('<specification>' + '\n' * 60_000 + '</specification>' + '<' * 1_000_000),
], ids=range(8))
def test_file_when_built_to_be_slow_then_is_refused_all_the_same(text: bytes) -> None:
    assert refusal(text).code in ('L0101', 'L0108')


def test_names_when_long_then_do_not_flood_the_report() -> None:
    name = 'n' * 1_000_000
    with pytest.raises(LadderError) as caught:
        parse_program(program(f'<body name="{name}"><rung id="{name}" width="x"/></body>'))
    assert len(str(caught.value)) < 5000


# -- encodings and binary garbage ---------------------------------------------------------------

@pytest.mark.parametrize('text', [
    b'', b' ', b'\0', b'\xff\xfe', b'\xfe\xff', b'\xef\xbb\xbf', b'<', b'<\0', b'\0<',
    b'\x7fELF\1\2', bytes(range(256)), VALID.encode()[:-9], VALID.encode()[:200],
    VALID.encode('utf-16')[:-1], VALID.encode('utf-32'), VALID.encode('utf-32-be'),
    b'+ADw-ladder/+AD4-',
    VALID.replace('UTF-8', 'UTF-7').encode('utf-7'), VALID.replace('UTF-8', 'ISO-8859-1').encode(),
    VALID.replace('UTF-8', 'UTF-16').encode(), VALID.replace('start', 'st\0art').encode(),
    VALID.replace('motor', 'm\udcfftor').encode('utf-8', 'surrogateescape'),
    VALID.replace('seal-in', '\x0b').encode(), VALID.replace('seal-in', '&#0;').encode(),
    VALID.replace('seal-in', '\uffff').encode(), VALID.encode() * 2,
], ids=range(26))
def test_bytes_when_no_xml_text_then_are_refused(text: bytes) -> None:
    assert refusal(text).code == 'L0101'


@pytest.mark.parametrize('codec', ['utf-8', 'utf-8-sig', 'utf-16', 'utf-16-le', 'utf-16-be'])
def test_encoding_when_utf_8_or_utf_16_then_is_read(codec: str) -> None:
    text = VALID if codec.startswith('utf-8') else VALID.replace('UTF-8', 'UTF-16')
    assert parse_program(text.encode(codec)).name == 'start_stop'


# -- paths --------------------------------------------------------------------------------------

def test_path_when_there_is_no_file_then_says_so(tmp_path: Path) -> None:
    found = read_failure(tmp_path / 'none.xml')
    assert found.code == 'L0109'
    assert 'No such file' in found.message


@pytest.mark.parametrize(('names', 'told'), [
    ((), 'none that ends in .xml or .st'), (('a.csv', 'project.xml.bak'), 'none that ends in'),
    (('b.ST', 'a.xml', 'c.csv'), 'files: a.xml, b.ST'),
    (('1.xml', '2.xml', '3.xml', '4.xml', '5.xml'), '1.xml, 2.xml, 3.xml or 2 more'),
    (('beremiz.xml', 'plc.xml', 'a.xml'), 'plc.xml: give '),
])
def test_path_when_a_folder_then_says_which_are_programs_and_what_to_give(
        tmp_path: Path, names: tuple[str, ...], told: str) -> None:
    for name in names:
        (tmp_path / name).touch()
    with pytest.raises(LadderError) as caught:
        read_any(tmp_path)
    (found,) = caught.value.diagnostics
    assert (found.code, found.location.file) == ('L0109', str(tmp_path))
    assert 'OpenPLC Editor 4' in found.message and told in found.help


def test_path_when_a_named_pipe_then_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe.xml')
    assert read_failure(tmp_path / 'pipe.xml').code == 'L0109'


@pytest.mark.parametrize('path', ['a\0b.xml', '', '/dev/zero', 'x' * 5000, '\ud800.xml'])
def test_path_when_it_cannot_be_a_file_then_is_refused(path: str) -> None:
    assert read_failure(path).code == 'L0109'


def test_path_when_reading_it_fails_then_says_so() -> None:
    if not Path('/proc/self/mem').exists():
        pytest.skip('no file here that opens but cannot be read')
    assert 'Input/output error' in read_failure('/proc/self/mem').message


@pytest.mark.skipif(os.geteuid() == 0, reason='root reads everything')
def test_path_when_not_readable_then_says_so(tmp_path: Path) -> None:
    path = tmp_path / 'secret.xml'
    path.write_text(VALID)
    path.chmod(0)
    assert 'Permission denied' in read_failure(path).message


def test_file_when_larger_than_the_limit_then_is_not_read_whole(tmp_path: Path) -> None:
    path = tmp_path / 'large.xml'
    with path.open('wb') as file:
        file.truncate(1 << 40)
    assert read_failure(path).code == 'L0107'


# -- mutations ----------------------------------------------------------------------------------

def reads_or_refuses(text: bytes) -> None:
    """Fail if reading ends in anything but a program or diagnostics that print."""
    try:
        assert isinstance(parse_program(text), Program)
    except LadderError as error:
        assert 1 <= len(error.diagnostics) <= xml_tree.MAX_DIAGNOSTICS
        assert str(error)


def test_valid_program_when_not_mutated_then_reads() -> None:
    assert parse_program(VALID.encode()).name == 'start_stop'


@given(st.data())
@settings(max_examples=300)
def test_bytes_when_mutated_then_reads_or_refuses(data: st.DataObject) -> None:
    text = bytearray(VALID.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        end = start + data.draw(st.integers(0, 8))
        pieces = [b'<', b'>', b'"', b'&', b'/', b'<!--', b']]>', b'<![CDATA[', b'<!DOCTYPE a [']
        text[start:end] = data.draw(st.one_of(st.binary(max_size=4), st.sampled_from(pieces)))
    reads_or_refuses(bytes(text))


@given(st.data())
@settings(max_examples=300)
def test_values_when_mutated_then_reads_or_refuses(data: st.DataObject) -> None:
    parts = VALID.split('"')
    for _ in range(data.draw(st.integers(1, 4))):
        index = data.draw(st.integers(1, len(parts) // 2 - 1)) * 2 + 1
        parts[index] = data.draw(st.one_of(
            st.text(st.sampled_from("aTZ0129_.#$%-+'& ;e"), max_size=12),
            st.text(max_size=5),
            st.sampled_from(['9' * 5000, '\U0001f600', '2#2', 'T#' + '9' * 999])))
    reads_or_refuses('"'.join(parts).encode('utf-8', 'surrogatepass'))


@given(st.binary(max_size=200))
def test_bytes_when_random_then_reads_or_refuses(text: bytes) -> None:
    reads_or_refuses(text)

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recognising files, and hostile and broken projects: a program or a diagnostic, quickly."""

from __future__ import annotations

from pathlib import Path
import random
from xml.etree import ElementTree

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.plcopen import CASES, element, ladder, project

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import Coil, Contact
from ladder_ros.model.program import Body, Composite
from ladder_ros.source.read_any import parse_any, read_any

CORPUS = Path(__file__).resolve().parents[3] / 'shared' / 'corpus'
FILES = sorted(CASES.glob('*.xml'))
COIL = element('coil', 1, [0], 'q')
VALUES = [
    '', '0', '-1', 'TRUE', '9' * 30, 'T#5s', 'a b', '%IX0.0', 'M30', 'x.y', 'a[1', 'A AND', 'set',
    'rising', '()', 'é', 'PT0S', 'TON', 'main', 'P', '0..1', '?', "'",
]


def codes(data: bytes) -> list[str]:
    """Return the codes of all that is reported, whether the file is read or refused."""
    try:
        return [diagnostic.code for diagnostic in parse_any(data, 'f.xml').warnings]
    except LadderError as error:
        assert error.diagnostics
        return [diagnostic.code for diagnostic in error.diagnostics]


@pytest.mark.parametrize('namespace', [
    'http://www.plcopen.org/xml/tc6_0201', 'http://www.plcopen.org/xml/tc6_0200',
    'http://www.plcopen.org/xml/tc6.xsd', '',
])
def test_file_when_its_root_is_a_project_of_any_version_then_it_is_read(namespace: str) -> None:
    program = parse_any(project(ladder(COIL), name=namespace))
    assert [body.name for body in program.bodies] == ['P']


def test_file_when_it_starts_with_a_byte_order_mark_then_it_is_read() -> None:
    assert parse_any(b'\xef\xbb\xbf' + project(ladder(COIL))).bodies[0].name == 'P'


def test_file_when_the_root_has_a_prefix_then_it_is_read() -> None:
    text = project(ladder(COIL)).decode().replace('<', '<p:').replace('<p:/', '</p:')
    assert parse_any(text.replace('xmlns=', 'xmlns:p=').encode()).bodies[0].name == 'P'


def test_file_when_it_is_our_own_then_it_is_read_as_such() -> None:
    text = b'<ladder version="1" name="own"><body name="main"/></ladder>'
    assert parse_any(text).dialect == 'native'


@pytest.mark.parametrize('text', [
    b'<project xmlns="http://maven.apache.org/POM/4.0.0"/>', b'<html/>', b'', b'{}', b'\xff\xfe',
])
def test_file_when_it_is_something_else_then_it_is_refused(text: bytes) -> None:
    with pytest.raises(LadderError):
        parse_any(text)


@pytest.mark.parametrize('name', ['', 'project.json'])
def test_folder_when_it_is_an_openplc_project_then_it_is_not_taken_for_a_file(
    tmp_path: Path, name: str,
) -> None:
    (tmp_path / 'project.json').write_text('{}')
    with pytest.raises(LadderError) as caught:
        read_any(tmp_path / name)
    assert caught.value.diagnostics[0].code not in ('L0101', 'L0109')


def test_path_when_it_is_another_folder_or_nothing_then_that_is_said(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / 'none.xml', '\0'):
        with pytest.raises(LadderError) as caught:
            read_any(path)
        assert caught.value.diagnostics[0].code == 'L0109'


def test_entities_when_declared_then_they_are_refused() -> None:
    text = b'<!DOCTYPE project [<!ENTITY a "b">]>' + project(ladder(COIL))
    assert codes(text) == ['L0108']


def test_project_when_it_has_no_pou_then_that_is_said() -> None:
    assert codes(project('')) == ['L0134']


def test_expression_when_it_nests_endlessly_then_it_is_refused() -> None:
    assert 'L0121' in codes(project(ladder(
        element('contact', 2, [0], 'NOT (' * 5_000 + 'a' + ')' * 5_000) + COIL)))


def test_continuations_when_they_chain_endlessly_then_the_chain_is_cut() -> None:
    links = ''.join(
        f'<continuation localId="{2 * i + 10}" name="n{i}"/><connector localId="{2 * i + 11}" '
        f'name="n{i + 1}"><connectionPointIn><connection refLocalId="{2 * i + 10}"/>'
        '</connectionPointIn></connector>' for i in range(3000))
    last = '<continuation localId="9" name="n3000"/>'
    assert 'L0131' in codes(project(ladder(links + last + element('coil', 1, [9], 'q'))))


def test_wires_when_connectors_multiply_them_then_the_drawing_is_refused() -> None:
    contacts = ''.join(element('contact', i, [0], 'a') for i in range(10, 1010))
    sources = ''.join(f'<connection refLocalId="{i}"/>' for i in range(10, 1010))
    body = (contacts + f'<connector localId="2" name="n"><connectionPointIn>{sources}'
            '</connectionPointIn></connector><continuation localId="3" name="n"/>'
            + ''.join('\n' + element('coil', i, [3], 'q') for i in range(2000, 2500)))
    with pytest.raises(LadderError) as caught:
        parse_any(project(ladder(body)), 'f.xml')
    large, _ = caught.value.diagnostics
    assert (large.code, caught.value.diagnostics[1].code) == ('L0107', 'L0143')
    assert large.location.line > 100, 'the coil whose wires are too many, not the whole drawing'


@settings(max_examples=60)
@given(st.randoms(use_true_random=False), st.sampled_from(FILES))
def test_project_when_it_is_mutated_then_a_program_or_diagnostics_come_out(
    rnd: random.Random, path: Path,
) -> None:
    codes(mutated(path.read_bytes(), rnd))


@pytest.mark.skipif(not CORPUS.is_dir(), reason='the corpus is not on this machine')
@pytest.mark.parametrize('path', sorted(CORPUS.glob('*/program.xml')), ids=lambda p: p.parent.name)
def test_program_of_others_when_read_then_all_that_is_drawn_is_there(path: Path) -> None:
    program = read_any(path)
    pous: list[Body | Composite] = [*program.bodies, *program.composites]
    drawn = [c for pou in pous for rung in pou.rungs for c in rung.components]
    counted = sum(isinstance(component, (Contact, Coil)) for component in drawn)
    bodies = ElementTree.parse(path).getroot().findall('.//{*}pou/{*}body')
    assert program.bodies
    assert counted == sum(
        len(body.findall(f'.//{{*}}{tag}')) for body in bodies for tag in ('contact', 'coil'))
    assert {'L0131', 'L0132', 'L0137'}.isdisjoint(d.code for d in program.warnings)


def mutated(data: bytes, rnd: random.Random) -> bytes:
    """Return a project with some elements removed, doubled, moved, renamed or changed."""
    root = ElementTree.fromstring(data)
    for _ in range(rnd.randint(1, 6)):
        everything = list(root.iter())
        one, other = rnd.choice(everything), rnd.choice(everything)
        match rnd.randrange(6):
            case 0 if one.attrib:
                one.attrib[rnd.choice(sorted(one.attrib))] = rnd.choice(VALUES)
            case 1 if one.attrib:
                del one.attrib[rnd.choice(sorted(one.attrib))]
            case 2 if len(one):
                one.remove(rnd.choice(list(one)))
            case 3 if all(inner is not one for inner in other.iter()):
                one.append(other)
            case 4:
                one.tag = other.tag
            case _:
                one.text = rnd.choice(VALUES)
    return ElementTree.tostring(root)

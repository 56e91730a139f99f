# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Broken and hostile OpenPLC v4 projects: a program, or diagnostics with file and rung."""

from __future__ import annotations

from collections.abc import Callable
import json
import os
from pathlib import Path
import random
import shutil
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.openplc import block, bools, configuration, ladder, links, Node, pou, save

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import Diagnostic, LadderError
from ladder_ros.source.openplc_json import MAX_DEPTH, parse_json
from ladder_ros.source.read_any import read_any

HEAD = 'VAR a, b, q : bool; n : int; t1 : TON; END_VAR'
VALUES: list[Any] = [
    None, True, -1, 1e300, '', 'a b', '%IX0.0', 'T#5s', '(', {}, [], [[]], 'set', 'é', "'", 'TON',
    'powerRail', 'parallel', 'left', 10 ** 14, '1' * 50, {'x': 1},
]


def body() -> Node:
    """Return a ladder of two rungs with all kinds of nodes."""
    return ladder(
        [[['a', block('TON', 't1', {'PT': 'T#1s'}, {'ET': ''})], ['/b'], ['q']], '(S q)'],
        ['>a', block('ADD', '', {'IN1': 'n', 'IN2': '1'}, {'OUT': 'n'}, kind='function',
                     power=('EN', 'ENO')), '(q)'])


def found(folder: Path, body: object, project: object = None) -> list[Diagnostic]:
    """Return what is reported of a project, whether it is read or refused."""
    text = body if isinstance(body, str) else json.dumps(body, indent=1)
    project = json.dumps(project) if not isinstance(project, (str, type(None))) else project
    save(folder, {'programs/main.ld': pou(HEAD, text)}, project)
    return outcome(folder)


def outcome(folder: Path) -> list[Diagnostic]:
    try:
        return list(check_program(read_any(folder)))
    except LadderError as error:
        assert error.diagnostics
        return list(error.diagnostics)


def node(body: Node, kind: str, place: int = 0) -> Node:
    """Return a node of the first rung by its type."""
    nodes: list[Node] = [n for n in body['rungs'][0]['nodes'] if n['type'] == kind]
    return nodes[place]


def test_project_when_it_is_whole_then_nothing_is_reported(tmp_path: Path) -> None:
    assert found(tmp_path, body()) == []


# -- what is wrong, and where -------------------------------------------------------------------

def test_json_when_it_breaks_off_then_file_and_line_are_named(tmp_path: Path) -> None:
    text = json.dumps(body(), indent=1)
    lines = text[:len(text) // 2].split('\n')
    (broken,) = found(tmp_path, '\n'.join(lines))
    assert broken.code == 'L0150'
    assert broken.location.file.endswith('main.ld')
    assert broken.location.line == 3 + len(lines) - (not lines[-1].strip())


@pytest.mark.parametrize('text, reason', [
    ('{"a": 1,}', 'a key in quotes'), ('{"a" 1}', ': is expected'), ('{"a": nil}', 'nil}'),
    ('{"a": [1 2]}', ', is expected'), ('[1]', 'an object'), ('', 'an object'), ('{', 'ends'),
    ('{} {}', 'the end of the object'), ('{"a": "\\q"}', 'escape'),
    ('{"a": "\\ud800"}', 'escape'), ('{"a": "\n"}', 'no JSON'), ('{"a": 01x}', 'no JSON'),
])
def test_json_when_it_is_none_then_the_reason_is_said(text: str, reason: str) -> None:
    with pytest.raises(LadderError) as caught:
        parse_json(text)
    assert caught.value.diagnostics[0].code == 'L0150'
    assert reason in caught.value.diagnostics[0].message


def test_json_when_it_nests_endlessly_then_it_is_refused() -> None:
    with pytest.raises(LadderError) as caught:
        parse_json('{"a":' * 100_000)
    assert caught.value.diagnostics[0].code == 'L0107'


def test_json_when_it_nests_as_deep_as_allowed_then_it_is_read() -> None:
    assert parse_json('{"a":' * (MAX_DEPTH - 1) + '{}' + '}' * (MAX_DEPTH - 1)).fields


json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-10 ** 14, 10 ** 14) | st.text(
        st.characters(exclude_categories=['Cs'])) | st.floats(allow_nan=False,
                                                             allow_infinity=False),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text('abc"\\\n'), inner,
                                                                max_size=4), max_leaves=20)


@given(value=st.dictionaries(st.text('xyz'), json_values), indent=st.sampled_from([None, 1]))
def test_json_when_any_is_read_then_it_is_what_was_written(
    value: dict[str, Any], indent: int | None,
) -> None:
    assert plain(parse_json(json.dumps(value, indent=indent))) == value


def plain(value: Any) -> Any:
    """Return what was read as Python's own reader returns it."""
    if isinstance(value, list):
        return [plain(inner) for inner in value]
    if hasattr(value, 'fields'):
        return {key: plain(inner) for key, inner in value.fields.items()}
    return value


def test_variable_when_it_is_unknown_then_rung_and_place_in_it_are_named(tmp_path: Path) -> None:
    broken = body()
    target = broken['rungs'][1]['nodes'][1]
    target['data']['variable']['name'] = 'missing'
    (unknown,) = found(tmp_path, broken)
    line = (tmp_path / 'pous/programs/main.ld').read_text().split('\n')[
        (unknown.location.line or 0) - 1:]
    assert 'missing' in unknown.message
    assert unknown.location.rung == '2'
    assert unknown.location.cell == (target['position']['x'], target['position']['y'])
    assert target['id'] in ''.join(line[:2])


def test_contact_when_its_kind_is_unknown_then_it_is_no_guess(tmp_path: Path) -> None:
    broken = body()
    node(broken, 'contact')['data']['variant'] = 'sometimes'
    (unknown,) = found(tmp_path, broken)
    assert (unknown.code, unknown.location.rung) == ('L0152', '1')


def test_contact_when_it_names_nothing_then_that_is_said(tmp_path: Path) -> None:
    broken = body()
    node(broken, 'contact')['data']['variable'] = {'name': ''}
    assert [d.code for d in found(tmp_path, broken)] == ['L0133']


def test_wire_when_its_source_is_gone_then_it_is_left_out(tmp_path: Path) -> None:
    broken = body()
    gone = node(broken, 'contact', 1)
    broken['rungs'][0]['nodes'].remove(gone)
    codes = [d.code for d in found(tmp_path, broken)]
    assert sorted(codes) == ['L0131', 'L0138']
    assert 'q -> q' in links(read_any(tmp_path).bodies[0].rungs[0])


def test_branches_when_they_form_a_ring_then_power_comes_from_outside_alone(
    tmp_path: Path,
) -> None:
    broken = body()
    first, second = (node(broken, 'parallel', place)['id'] for place in (0, 1))
    broken['rungs'][0]['edges'].append({'source': second, 'target': first})
    assert found(tmp_path, broken) == []


def test_nodes_when_two_have_one_id_then_that_is_said(tmp_path: Path) -> None:
    broken = body()
    broken['rungs'][0]['nodes'].append(node(broken, 'contact'))
    assert 'L0151' in [d.code for d in found(tmp_path, broken)]


def test_nodes_when_two_have_one_number_then_both_are_there(tmp_path: Path) -> None:
    doubled = body()
    for rung in doubled['rungs']:
        for number, inner in enumerate(rung['nodes']):
            inner['data']['numericId'] = str(number // 2)
    assert found(tmp_path, doubled) == []
    ids = [c.id for c in read_any(tmp_path).bodies[0].rungs[0].components]
    assert len(set(ids)) == len(ids) == 12


def test_node_when_it_is_of_an_unknown_type_then_it_is_left_out(tmp_path: Path) -> None:
    broken = body()
    broken['rungs'][0]['nodes'].append({'id': 'x', 'type': 'hologram', 'data': {}})
    assert [d.code for d in found(tmp_path, broken)] == ['L0138']


def test_ladder_when_it_has_no_rungs_then_it_is_not_an_empty_one(tmp_path: Path) -> None:
    assert [d.code for d in found(tmp_path, {'name': 'main'})] == ['L0152']


@pytest.mark.parametrize('project', ['{}', '{"data": 5}', '{"data": []}'])
def test_project_when_it_has_no_data_then_that_is_said(tmp_path: Path, project: str) -> None:
    (broken,) = found(tmp_path, body(), project)
    assert (broken.code, Path(broken.location.file).name) == ('L0152', 'project.json')


def test_task_when_an_instance_names_another_then_it_runs_in_every_scan(tmp_path: Path) -> None:
    project = configuration(tasks=[])
    assert [d.code for d in found(tmp_path, body(), project)] == ['L0151']
    assert read_any(tmp_path).bodies[0].task == ''


def test_array_when_its_bounds_mean_nothing_then_that_is_said(tmp_path: Path) -> None:
    project = configuration(dataTypes=[{
        'name': 'L', 'derivation': 'array', 'dimensions': [{'dimension': '1 to 5'}],
        'baseType': {'definition': 'base-type', 'value': 'int'}}])
    assert 'L0152' in [d.code for d in found(tmp_path, body(), project)]


def test_header_when_it_cannot_be_read_then_its_line_is_named(tmp_path: Path) -> None:
    save(tmp_path, {
        'programs/main.ld': pou('VAR\n\ta : bool\n\tq : bool;\nEND_VAR', ladder(['a', '(q)']))})
    (broken,) = outcome(tmp_path)
    assert (broken.code, broken.location.line) == ('L0120', 4)


def test_texts_when_several_are_broken_then_all_are_named(tmp_path: Path) -> None:
    save(tmp_path, {'programs/main.ld': 'nothing', 'functions/f.ld': pou('', '{', 'FUNCTION f'),
                    'function-blocks/b.st': pou('VAR a : ; END_VAR', '', 'FUNCTION_BLOCK b')})
    assert {Path(d.location.file).name for d in outcome(tmp_path)} == {'main.ld', 'f.ld', 'b.st'}


def test_text_when_it_is_no_utf_8_then_that_is_said(tmp_path: Path) -> None:
    save(tmp_path, {'programs/main.ld': ''})
    (tmp_path / 'pous/programs/main.ld').write_bytes(b'PROGRAM main \xff')
    assert [d.code for d in outcome(tmp_path)] == ['L0109']


# -- size and files -----------------------------------------------------------------------------

def test_wires_when_branches_multiply_them_then_the_drawing_is_refused(tmp_path: Path) -> None:
    many = range(1100)
    rung: Node = {'id': 'r', 'nodes': [
        {'id': 'p', 'type': 'parallel', 'position': {'x': 0, 'y': 0}, 'data': {}}], 'edges': []}
    for side, ends in (('a', ('{}', 'p')), ('q', ('p', '{}'))):
        for number in many:
            name = f'{side}{number}'
            rung['nodes'].append({
                'id': name, 'type': 'coil' if side == 'q' else 'contact',
                'position': {'x': 0, 'y': 0},
                'data': {'variant': 'default', 'variable': {'name': side}}})
            rung['edges'].append({'source': ends[0].format(name), 'target': ends[1].format(name)})
    assert found(tmp_path, {'rungs': [rung]})[0].code == 'L0107'


def test_positions_when_they_are_beyond_all_pages_then_they_count_as_0(tmp_path: Path) -> None:
    broken = body()
    for place, value in enumerate((1e300, -1e18, '5')):
        broken['rungs'][0]['nodes'][place + 1]['position'] = {'x': 5, 'y': value}
    assert {d.code for d in found(tmp_path, broken)} == {'L0151'}


@pytest.mark.skipif(not hasattr(os, 'symlink'), reason='no symbolic links here')
def test_file_when_it_is_a_link_out_of_the_folder_then_it_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / 'secret.st').write_text(pou(bools('a'), 'a := TRUE;', 'FUNCTION_BLOCK secret'))
    folder = tmp_path / 'project'
    folder.mkdir()
    save(folder, {'programs/main.ld': pou(HEAD, body())})
    (folder / 'pous/programs/secret.st').symlink_to(tmp_path / 'secret.st')
    assert not read_any(folder).composites


@pytest.mark.skipif(not hasattr(os, 'mkfifo'), reason='no named pipes here')
def test_file_when_it_is_a_pipe_then_nobody_waits_for_it(tmp_path: Path) -> None:
    save(tmp_path, {'programs/main.ld': pou(HEAD, body())})
    os.mkfifo(tmp_path / 'pous/programs/pipe.st')
    assert [d.code for d in outcome(tmp_path)] == ['L0109']


# -- mutations ----------------------------------------------------------------------------------

def values_of(value: Any) -> list[tuple[Any, Any]]:
    """Return each place in a JSON value as container and key."""
    keys = list(value) if isinstance(value, dict) else list(range(len(value)))
    places = [(value, key) for key in keys]
    for key in keys:
        if isinstance(value[key], (dict, list)):
            places += values_of(value[key])
    return places


def mutate_values(rnd: random.Random, value: Any) -> None:
    """Change, remove, double or move some of the values."""
    for _ in range(rnd.randint(1, 5)):
        places = values_of(value)
        if not places:
            return
        inside, key = rnd.choice(places)
        match rnd.randrange(4):
            case 0:
                inside[key] = rnd.choice(VALUES)
            case 1:
                del inside[key]
            case 2 if isinstance(inside, list):
                inside.append(json.loads(json.dumps(inside[key])))
            case _:
                other, name = rnd.choice(places)
                if name in range(len(other)) if isinstance(other, list) else name in other:
                    inside[key] = json.loads(json.dumps(other[name]))


def mutate_text(rnd: random.Random, text: str) -> str:
    """Remove, double or overwrite some pieces of a text."""
    for _ in range(rnd.randint(1, 4)):
        start = rnd.randrange(len(text) + 1)
        end = min(len(text), start + rnd.choice((1, 1, 5, 100)))
        text = text[:start] + rnd.choice((
            '', text[start:end] * 2, '{', '}', '"', '(*', 'END_VAR', '\0', ';', '\n')) + text[end:]
    return text


def change_body(rnd: random.Random) -> tuple[str, str]:
    drawn = body()
    mutate_values(rnd, drawn)
    return pou(HEAD, drawn), json.dumps(configuration())


def change_project(rnd: random.Random) -> tuple[str, str]:
    project = configuration(
        dataTypes=[{'name': 'C', 'derivation': 'enumerated', 'values': [{'description': 'red'}]}],
        globalVariables=[{'name': 'g', 'location': '%QX0.0', 'documentation': 'x',
                          'type': {'definition': 'base-type', 'value': 'bool'}}],
        pous=[{'type': 'function', 'data': {
            'name': 'f', 'returnType': 'int', 'variables': [],
            'body': {'language': 'st', 'value': 'f := 1;'}}}])
    mutate_values(rnd, project)
    return pou(HEAD, body()), json.dumps(project)


def change_text(rnd: random.Random) -> tuple[str, str]:
    return mutate_text(rnd, pou(HEAD, body())), mutate_text(rnd, json.dumps(configuration()))


@pytest.mark.parametrize('change', [change_body, change_project, change_text])
@settings(max_examples=60)
@given(rnd=st.randoms(use_true_random=False))
def test_project_when_it_is_mutated_then_a_program_or_diagnostics_come_out(
    tmp_path_factory: pytest.TempPathFactory, rnd: random.Random,
    change: Callable[[random.Random], tuple[str, str]],
) -> None:
    text, project = change(rnd)
    folder = tmp_path_factory.mktemp('mutated')
    try:
        for diagnostic in outcome(save(folder, {'programs/main.ld': text}, project)):
            assert str(folder) in diagnostic.location.file
    finally:
        shutil.rmtree(folder)


def test_wire_when_it_comes_from_a_pin_that_is_not_there_then_it_speaks_of_this_format(
    tmp_path: Path,
) -> None:
    broken = body()
    data = node(broken, 'block')['data']
    data['outputHandles'] = data['outputHandles'][1:]
    for edge in broken['rungs'][0]['edges']:
        edge['sourceHandle'] = {'Q': 'P'}.get(edge['sourceHandle'], edge['sourceHandle'])
    data['outputConnector'] = {}
    (departs,) = [d for d in found(tmp_path, broken) if d.code in ('L0130', 'L0151')]
    assert departs.code == 'L0151'
    assert 'PLCopen' not in departs.message
    assert departs.help == 'it is read as ET'

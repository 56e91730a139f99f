# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""OpenPLC Editor v4 projects: what a folder means."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import json
from pathlib import Path
import shutil

from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.openplc import (
    block,
    bools,
    configuration,
    ladder,
    links,
    pou,
    read_ladder,
    save,
    Series,
)

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, SlotClass
from ladder_ros.model.component import (
    Block,
    Coil,
    CoilKind,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    OutVariable,
)
from ladder_ros.model.derived import Array, Enumeration, Structure
from ladder_ros.model.program import CallKind, Order, Program, VariableClass
from ladder_ros.model.types import DataType, NS_PER_MS, Value
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.source.read_any import folder_hash, openplc_folder, read_any

SEAL: Series = [[['start'], ['motor']], '/stop', '(motor)']


def run(executable: Executable, *rows: Mapping[str, Value]) -> list[dict[str, Value]]:
    """Return all values after each scan of 100 ms; a row is written before its scan."""
    cycle = ScanCycle(executable)
    found = []
    for number, row in enumerate(rows):
        for name, value in row.items():
            slot = executable.slot(name)
            assert slot is not None
            cycle.write(slot.index, value)
        cycle.scan(number * 100 * NS_PER_MS)
        found.append({slot.path: cycle.state[slot.index] for slot in executable.slots})
    return found


def executable(program: Program) -> Executable:
    return compile_program(program).executable


# -- ladders ------------------------------------------------------------------------------------

def test_ladder_when_read_then_it_is_one_drawing_with_wires(tmp_path: Path) -> None:
    program = read_ladder(tmp_path, bools('start', 'stop', 'motor'), SEAL)
    (rung,) = program.bodies[0].rungs
    assert (program.dialect, program.name, program.bodies[0].name) == ('openplc', 'demo', 'main')
    assert (rung.id, rung.order) == ('1', Order.POSITION_ALL)
    assert links(rung) == [
        'rail -> start', 'rail -> motor', 'start -> stop', 'motor -> stop', 'stop -> motor']


@pytest.mark.parametrize('mark, kind', [
    ('', ContactKind.NORMALLY_OPEN), ('/', ContactKind.NORMALLY_CLOSED),
    ('>', ContactKind.RISING), ('<', ContactKind.FALLING),
])
def test_contact_when_it_has_a_variant_then_that_is_its_kind(
    tmp_path: Path, mark: str, kind: ContactKind,
) -> None:
    program = read_ladder(tmp_path, bools('a', 'q'), [f'{mark}a', '(q)'])
    contact = program.bodies[0].rungs[0].components[0]
    assert isinstance(contact, Contact)
    assert (contact.kind, contact.operand) == (kind, 'a')


@pytest.mark.parametrize('mark, kind', [
    ('', CoilKind.COIL), ('/', CoilKind.NEGATED), ('S ', CoilKind.SET), ('R ', CoilKind.RESET),
    ('>', CoilKind.RISING), ('<', CoilKind.FALLING),
])
def test_coil_when_it_has_a_variant_then_that_is_its_kind(
    tmp_path: Path, mark: str, kind: CoilKind,
) -> None:
    program = read_ladder(tmp_path, bools('a', 'q'), ['a', f'({mark}q)'])
    coil = program.bodies[0].rungs[0].components[1]
    assert isinstance(coil, Coil)
    assert (coil.kind, coil.operand) == (kind, 'q')


def test_branches_when_they_nest_then_each_part_is_wired_to_all_sources(tmp_path: Path) -> None:
    program = read_ladder(tmp_path, bools(*'abcdeq'), [
        [['a', [['b'], ['c']]], ['d'], ['e']], '(q)'])
    assert links(program.bodies[0].rungs[0]) == [
        'rail -> a', 'a -> b', 'a -> c', 'rail -> d', 'rail -> e',
        'b -> q', 'c -> q', 'd -> q', 'e -> q']


def test_rungs_when_read_then_each_is_below_all_of_the_one_before(tmp_path: Path) -> None:
    program = read_ladder(
        tmp_path, bools(*'abcdefgh'), [[['a'], ['b'], ['c']], '(d)'], ['d', '(e)'], ['e', '(f)'])
    rows: dict[str, list[int]] = {'1': [], '2': [], '3': []}
    for component in program.bodies[0].rungs[0].components:
        rows[component.location.rung].append(component.placement.y)
    assert max(rows['1']) + 10 < min(rows['2'])
    assert max(rows['2']) + 10 < min(rows['3'])


def test_rungs_when_one_reads_what_the_next_writes_then_it_sees_the_last_scan(
    tmp_path: Path,
) -> None:
    program = read_ladder(tmp_path, bools('a', 'm', 'q'), ['m', '(q)'], ['a', '(m)'])
    after = run(executable(program), {'a': True}, {})
    assert [row['q'] for row in after] == [False, True]


def test_seal_in_when_it_runs_then_it_holds_until_it_is_stopped(tmp_path: Path) -> None:
    program = read_ladder(tmp_path, bools('start', 'stop', 'motor'), SEAL)
    after = run(executable(program), {'start': True}, {'start': False}, {'stop': True},
                {'stop': False})
    assert [row['motor'] for row in after] == [True, True, False, False]


def expression() -> st.SearchStrategy[Series]:
    """Return series of contacts and branches."""
    atom = st.sampled_from(['a', 'b', 'c', 'd', '/a', '/b', '/c', '/d'])
    return st.recursive(
        st.lists(atom, min_size=1, max_size=3),
        lambda inner: st.lists(
            st.one_of(atom, st.lists(inner, min_size=2, max_size=4)), min_size=1, max_size=3),
        max_leaves=12)


def holds(parts: Series, values: Mapping[str, bool]) -> bool:
    """Say whether power comes through a series."""
    return all(
        any(holds(branch, values) for branch in part) if isinstance(part, list)
        else values[str(part)[-1]] != str(part).startswith('/') for part in parts)


@given(series=expression())
def test_rung_when_it_is_any_nest_of_branches_then_power_flows_as_drawn(
    tmp_path_factory: pytest.TempPathFactory, series: Series,
) -> None:
    folder = tmp_path_factory.mktemp('nest')
    try:
        program = read_ladder(folder, bools(*'abcdq'), [*series, '(q)'])
    finally:
        shutil.rmtree(folder)
    rows = [{name: bool(number >> bit & 1) for bit, name in enumerate('abcd')}
            for number in range(16)]
    after = run(executable(program), *rows)
    assert [row['q'] for row in after] == [holds(series, row) for row in rows]


# -- blocks -------------------------------------------------------------------------------------

def test_block_when_variables_stand_at_its_pins_then_they_are_wired_to_it(tmp_path: Path) -> None:
    timer = block('TON', 't1', {'PT': 'T#200ms'}, {'ET': 'gone'})
    program = read_ladder(
        tmp_path, 'VAR a : bool; q : bool; gone : time; t1 : TON; END_VAR', ['a', timer, '(q)'])
    rung = program.bodies[0].rungs[0]
    assert [type(c) for c in rung.components] == [Contact, Block, InVariable, OutVariable, Coil]
    assert set(links(rung)) == {
        'rail -> a', 'a -> t1.IN', 'T#200ms -> t1.PT', 't1.ET -> gone', 't1.Q -> q'}
    after = run(executable(program), {'a': True}, {}, {}, {})
    assert [row['q'] for row in after] == [False, False, True, True]


def test_block_when_nothing_is_written_at_a_pin_then_that_is_no_variable(tmp_path: Path) -> None:
    counter = block('CTU', 'c1', {'R': '', 'PV': '2'}, {'CV': ''}, power=('CU', 'Q'))
    program = read_ladder(
        tmp_path, 'VAR a : bool; q : bool; c1 : CTU; END_VAR', ['a', counter, '(q)'])
    assert not program.warnings
    assert set(links(program.bodies[0].rungs[0])) == {
        'rail -> a', 'a -> c1.CU', '2 -> c1.PV', 'c1.Q -> q'}


def test_block_when_a_wire_names_a_pin_of_its_predecessor_then_the_rungs_line_counts(
    tmp_path: Path,
) -> None:
    body = ladder(['a', block('R_TRIG', 'r1', power=('CLK', 'Q')), '(q)'])
    for edge in body['rungs'][0]['edges']:
        edge['targetHandle'] = {'CLK': 'IN'}.get(edge['targetHandle'], edge['targetHandle'])
    text = pou('VAR a : bool; q : bool; r1 : R_TRIG; END_VAR', body)
    program = read_any(save(tmp_path, {'programs/main.ld': text}))
    assert 'a -> r1.CLK' in links(program.bodies[0].rungs[0])


def test_function_when_it_has_enable_pins_then_power_goes_through_them(tmp_path: Path) -> None:
    add = block('ADD', '', {'IN1': 'n', 'IN2': '5'}, {'OUT': 'n'}, kind='function',
                power=('EN', 'ENO'))
    program = read_ladder(tmp_path, 'VAR a, q : bool; n : int; END_VAR', ['a', add, '(q)'])
    after = run(executable(program), {'a': True}, {'a': False}, {'a': True})
    assert [row['n'] for row in after] == [5, 5, 10]


def test_block_when_it_is_a_pou_of_the_project_then_it_is_called(tmp_path: Path) -> None:
    twice = pou('VAR_INPUT\n\tn : int;\nEND_VAR\nVAR_OUTPUT\n\tbig : bool;\nEND_VAR',
                'big := 2 * n > 10;', 'FUNCTION_BLOCK twice')
    box = block('twice', 'w1', {'n': 'level'}, {'big': 'full'}, power=('EN', 'ENO'))
    save(tmp_path, {
        'function-blocks/twice.st': twice,
        'programs/main.ld': pou(
            'VAR a, q, full : bool; level : int; w1 : twice; END_VAR', ladder(['a', box, '(q)']))})
    program = read_any(tmp_path)
    assert [(c.name, c.call) for c in program.composites] == [('twice', CallKind.BLOCK)]
    assert any(isinstance(c, Instance) for c in program.bodies[0].rungs[0].components)
    after = run(executable(program), {'a': True, 'level': 5}, {'level': 6})
    assert [row['full'] for row in after] == [False, True]


# -- other languages ----------------------------------------------------------------------------

def diagram() -> dict[str, object]:
    """Return a function block diagram: q := x XOR NOT y."""
    def node(name: str, type_: str, data: dict[str, object]) -> dict[str, object]:
        return {'id': name, 'type': type_, 'position': {'x': -40, 'y': 10}, 'data': data}

    def variable(name: str, **more: object) -> dict[str, object]:
        return {'variable': {'name': name}, 'executionOrder': 0, **more}

    box = block('XOR', '', kind='function', power=('IN1', 'OUT'), pins=('IN2',))
    ends = [('vx', 'output-variable', 'box', 'IN1'), ('vy', 'output-variable', 'box', 'IN2'),
            ('box', 'OUT', 'join', 'input-variable'), ('more', 'output', 'vq', 'input-variable')]
    return {'name': 'main', 'rung': {
        'comment': '', 'edges': [
            {'source': s, 'sourceHandle': o, 'target': t, 'targetHandle': i}
            for s, o, t, i in ends],
        'nodes': [
            node('vx', 'input-variable', variable('x', numericId='1')),
            node('vy', 'input-variable', variable('y', numericId='2', negated=True)),
            node('box', 'block', {**box['data'], 'numericId': '3'}),
            node('join', 'connector', variable('J', numericId='4')),
            node('more', 'continuation', variable('J', numericId='5')),
            node('vq', 'output-variable', variable('q', numericId='6')),
            node('note', 'comment', {'content': 'exclusive', 'numericId': '7'})]}}


def test_diagram_when_read_then_its_blocks_are_wired_through_connectors(tmp_path: Path) -> None:
    program = read_any(save(
        tmp_path, {'programs/main.fbd': pou(bools('x', 'y', 'q'), diagram())}))
    rung = program.bodies[0].rungs[0]
    assert (rung.comment, not program.warnings) == ('exclusive', True)
    after = run(executable(program), {'x': False, 'y': False}, {'x': True}, {'y': True})
    assert [row['q'] for row in after] == [True, False, True]


def test_diagram_when_it_has_numbers_then_they_are_the_order(tmp_path: Path) -> None:
    body = diagram()
    rung = body['rung']
    assert isinstance(rung, dict)
    rung['nodes'][-2]['data']['executionOrder'] = 3
    program = read_any(save(tmp_path, {'programs/main.fbd': pou(bools('x', 'y', 'q'), body)}))
    assert program.bodies[0].rungs[0].order is Order.DOCUMENT


def test_text_when_it_is_the_program_then_it_runs(tmp_path: Path) -> None:
    text = '(* Counts. *)\n\n' + pou('VAR n : int := 3; END_VAR', '\nn := n + 1;\n')
    program = read_any(save(tmp_path, {'programs/main.st': text}))
    assert run(executable(program), {}, {})[1]['n'] == 5


@pytest.mark.parametrize('file, language', [
    ('drive.cpp', 'C++'), ('drive.py', 'Python'), ('drive.il', 'IL')])
def test_block_when_its_language_cannot_run_then_it_is_refused_where_it_is_used(
    tmp_path: Path, file: str, language: str,
) -> None:
    head = ('FUNCTION_BLOCK drive\nVAR_INPUT\n\tspeed : int;\nEND_VAR\n'
            "#include <don't.h>\nvoid f(int (*p)) { /* ( * */ }\nEND_FUNCTION_BLOCK")
    box = block('drive', 'd1', {'speed': '5'}, power=('EN', 'ENO'))
    save(tmp_path, {
        f'function-blocks/{file}': head,
        'programs/main.ld': pou('VAR a : bool; d1 : drive; END_VAR', ladder(['a', box]))})
    (refused,) = check_program(read_any(tmp_path))
    assert refused.code == 'L0240'
    assert language in refused.message
    assert refused.location.file.endswith(file)


def test_block_when_in_cpp_and_stubs_are_allowed_then_its_pins_are_io(tmp_path: Path) -> None:
    head = ('FUNCTION_BLOCK drive\nVAR_INPUT\n\tspeed : int;\nEND_VAR\n'
            'VAR_OUTPUT\n\tready : bool;\nEND_VAR\n{};')
    box = block('drive', 'd1', {'speed': '5'}, power=('EN', 'ready'))
    save(tmp_path, {
        'function-blocks/drive.cpp': head,
        'programs/main.ld': pou('VAR a : bool; q : bool; d1 : drive; END_VAR',
                                ladder(['a', box, '(q)']))})
    (tmp_path / 'import.json').write_text('{"stubs": true}')
    compilation = compile_program(read_any(tmp_path))
    assert [d.code for d in compilation.diagnostics] == ['L0245']
    classes = {slot.path: slot.slot_class for slot in compilation.executable.slots}
    assert classes['d1.ready'] is SlotClass.INPUT
    assert classes['d1.speed'] is SlotClass.OUTPUT


def test_block_when_its_language_cannot_run_and_nothing_uses_it_then_the_rest_runs(
    tmp_path: Path,
) -> None:
    save(tmp_path, {
        'function-blocks/drive.cpp': 'FUNCTION_BLOCK drive\nVAR_INPUT\n\ts : int;\nEND_VAR\n{};',
        'programs/main.ld': pou(bools('a', 'q'), ladder(['a', '(q)']))})
    assert [d.code for d in check_program(read_any(tmp_path))] == ['L0241']


# -- declarations -------------------------------------------------------------------------------

def test_variables_when_they_are_declared_in_text_then_all_is_kept(tmp_path: Path) -> None:
    program = read_ladder(
        tmp_path,
        'VAR_INPUT\n\tlow : bool;\nEND_VAR\n\nVAR_OUTPUT\n\thigh : bool;\nEND_VAR\n\nVAR\n'
        '\tlamp : bool AT %QX0.1 := TRUE; (* the red one *)\n\tlevel : int := 7;\nEND_VAR',
        ['low', '(high)'])
    found = {v.name: (v.variable_class, v.initial, v.address, v.comment)
             for v in program.variables}
    assert found == {
        'low': (VariableClass.INPUT, None, '', ''), 'high': (VariableClass.OUTPUT, None, '', ''),
        'lamp': (VariableClass.LOCAL, True, '%QX0.1', 'the red one'),
        'level': (VariableClass.LOCAL, 7, '', '')}


def test_types_when_the_project_declares_them_then_variables_have_them(tmp_path: Path) -> None:
    int_ = {'definition': 'base-type', 'value': 'int'}
    types = [
        {'name': 'Colour', 'derivation': 'enumerated', 'initialValue': 'green',
         'values': [{'description': 'red'}, {'description': 'green'}]},
        {'name': 'Levels', 'derivation': 'array', 'baseType': int_, 'initialValue': '[1, 2(4)]',
         'dimensions': [{'dimension': '0..2'}]},
        {'name': 'Tank', 'derivation': 'structure', 'variable': [
            {'name': 'level', 'type': int_, 'initialValue': {'simpleValue': {'value': '5'}}},
            {'name': 'colour', 'type': {'definition': 'user-data-type', 'value': 'Colour'}},
            {'name': 'past', 'type': {'definition': 'array', 'value': 'ARRAY [1..2] OF int',
                                      'data': {'baseType': int_, 'dimensions': [
                                          {'dimension': '1..2'}]}}}]}]
    text = pou('VAR c : Colour; l : Levels; t : Tank; END_VAR',
               't.past[2] := l[1] + t.level + l[0];')
    program = read_any(save(tmp_path, {'programs/main.st': text}, configuration(dataTypes=types)))
    assert [type(v.type) for v in program.variables] == [Enumeration, Array, Structure]
    after = run(executable(program), {})[0]
    assert (after['t.past[2]'], after['c'], after['t.colour']) == (10, 1, 1)


def test_globals_when_a_program_uses_them_then_they_are_the_projects(tmp_path: Path) -> None:
    variable = {'name': 'lamp', 'type': {'definition': 'base-type', 'value': 'BOOL'},
                'location': '%QX0.0', 'documentation': 'green'}
    text = pou('VAR_EXTERNAL\n\tlamp : bool;\nEND_VAR\n' + bools('a'), ladder(['a', '(lamp)']))
    program = read_any(save(
        tmp_path, {'programs/main.ld': text}, configuration(globalVariables=[variable])))
    (lamp,) = (v for v in program.variables if v.name == 'lamp')
    assert (lamp.type, lamp.address, lamp.comment) == (DataType.BOOL, '%QX0.0', 'green')
    assert run(executable(program), {'a': True})[0]['lamp'] is True


def test_instances_when_there_are_several_then_each_runs_in_its_task(tmp_path: Path) -> None:
    project = configuration(
        tasks=[{'name': 'fast', 'triggering': 'Cyclic', 'interval': 'T#100ms', 'priority': 0},
               {'name': 'slow', 'triggering': 'Cyclic', 'interval': 'T#200ms', 'priority': 1}],
        instances=[{'name': 'one', 'task': 'fast', 'program': 'main'},
                   {'name': 'two', 'task': 'slow', 'program': 'main'}])
    program = read_any(save(
        tmp_path, {'programs/main.st': pou('VAR n : int; END_VAR', 'n := n + 1;')}, project))
    assert [(task.name, task.interval) for task in program.tasks] == [
        ('fast', 100 * NS_PER_MS), ('slow', 200 * NS_PER_MS)]
    after = run(executable(program), {}, {}, {}, {})[-1]
    assert (after['one.n'], after['two.n']) == (4, 2)


def test_pou_when_an_early_release_saved_it_as_json_then_it_is_read(tmp_path: Path) -> None:
    variables = [{'name': name, 'class': 'local', 'location': '', 'documentation': '',
                  'type': {'definition': 'base-type', 'value': 'bool'}} for name in 'aq']
    early = {'type': 'program', 'data': {
        'name': 'main', 'language': 'ld', 'variables': variables, 'documentation': '',
        'body': {'language': 'ld', 'value': ladder(['a', '(q)'])}}}
    other = {'type': 'function-block', 'data': {
        'name': 'flip', 'language': 'st', 'documentation': 'Flips.',
        'variables': [{**variables[0], 'class': 'input'}, {**variables[1], 'class': 'output'}],
        'body': {'language': 'st', 'value': 'q :=\nNOT a;'}}}
    save(tmp_path, {'programs/main.json': json.dumps(early)}, configuration(pous=[other]))
    program = read_any(tmp_path)
    assert links(program.bodies[0].rungs[0]) == ['rail -> a', 'a -> q']
    (flip,) = program.composites
    assert (flip.specification, len(flip.parameters), len(flip.statements)) == ('Flips.', 2, 1)


def test_pou_when_it_is_there_as_text_and_as_json_then_the_text_counts(tmp_path: Path) -> None:
    early = {'type': 'program', 'data': {
        'name': 'main', 'variables': [], 'body': {'language': 'st', 'value': ''}}}
    save(tmp_path, {'programs/main.json': json.dumps(early),
                    'programs/main.st': pou('VAR n : int; END_VAR', 'n := 1;')},
         configuration(pous=[early]))
    program = read_any(tmp_path)
    assert not program.warnings
    assert run(executable(program), {})[0]['n'] == 1


# -- the folder ---------------------------------------------------------------------------------

@pytest.mark.parametrize('name', ['', 'project.json', 'pous/programs/main.ld'])
def test_path_when_it_is_the_folder_or_its_project_then_both_are_read(
    tmp_path: Path, name: str,
) -> None:
    read_ladder(tmp_path, bools('a', 'q'), ['a', '(q)'])
    assert openplc_folder(str(tmp_path / name)) == tmp_path
    assert read_any(tmp_path / name).dialect == 'openplc'


def test_pou_when_its_project_is_not_there_then_l0153(tmp_path: Path) -> None:
    read_ladder(tmp_path, bools('a', 'q'), ['a', '(q)'])
    (tmp_path / 'project.json').unlink()
    file = tmp_path / 'pous' / 'programs' / 'main.ld'
    assert openplc_folder(str(file)) is None
    with pytest.raises(LadderError) as caught:
        read_any(file)
    assert [d.code for d in caught.value.diagnostics] == ['L0153']


def test_hash_when_a_pou_changes_then_it_changes_too(tmp_path: Path) -> None:
    read_ladder(tmp_path, bools('a', 'q'), ['a', '(q)'])
    before = folder_hash(tmp_path)
    save(tmp_path, {'../build/plc.st': 'made by a build'})
    assert folder_hash(tmp_path) == before
    save(tmp_path, {'programs/main.ld': pou(bools('a', 'q'), ladder(['/a', '(q)']))})
    assert folder_hash(tmp_path) != before


@pytest.mark.parametrize('change', [
    lambda pous: (pous / 'programs' / 'main.ld').unlink(),
    lambda pous: shutil.rmtree(pous),
])
def test_folder_when_it_has_no_pou_then_that_is_said(
    tmp_path: Path, change: Callable[[Path], None],
) -> None:
    read_ladder(tmp_path, bools('a', 'q'), ['a', '(q)'])
    change(tmp_path / 'pous')
    with pytest.raises(LadderError) as caught:
        read_any(tmp_path)
    assert caught.value.diagnostics[0].code == 'L0134'

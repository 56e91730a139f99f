# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Wrong names, wrong drawings, too much: each code once, with its place and what people read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import re
from textwrap import indent

import pytest

from compiler.agreement import executable
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.compiler.symbols import Ref, Resolved
from ladder_ros.compiler.wiring import End, Net, Part, Wiring
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.diagnostics import Diagnostic, LadderError, render, Severity
from ladder_ros.model.component import Contact, Placement
from ladder_ros.model.program import Rung
from ladder_ros.model.types import DataType
from ladder_ros.problems import PROBLEMS
from ladder_ros.source.xml_to_model import parse_program

VARIABLES = """\
<variable name="a" class="input" type="BOOL"/>
<variable name="b" class="input" type="BOOL"/>
<variable name="k" class="output" type="BOOL"/>
<variable name="m" type="BOOL"/>
<variable name="n" type="INT"/>
<variable name="d" type="DINT"/>
<variable name="t" type="TIME"/>"""
COMPOSITE = """\
<composite name="Box" call="inline">
<parameter name="In" type="BOOL" direction="input"/>
<parameter name="Out" type="BOOL" direction="output"/>
<rung id="1" width="2">
<contact id="c" x="0" y="0" operand="In"/><coil id="k" x="1" y="0" operand="Out"/>
</rung>
</composite>"""
GOOD = '<contact id="c" x="0" y="0" operand="a"/><coil id="z" x="1" y="0" operand="k"/>'


@dataclass(frozen=True, slots=True, kw_only=True)
class Wrong:
    """A mistake.  ``here`` is the text of the line that is wrong; ``cell`` where it is drawn."""

    code: str
    rung: str = GOOD
    width: int = 0
    here: str = ''
    cell: tuple[int, int] | None = None
    variables: str = VARIABLES
    composites: str = ''
    tasks: str = ''
    body: str = ''
    pou: str = 'main'
    only: bool = True

    def text(self) -> str:
        """Return the program, an element a line."""
        width = self.width or (2 if self.rung == GOOD else 3)
        body = self.body or (
            f'<body name="main">\n<rung id="1" width="{width}">\n{self.rung}\n</rung>\n'
            '</body>')
        composites = f'<composites>\n{self.composites}\n</composites>\n' if self.composites else ''
        tasks = f'<tasks>\n{self.tasks}\n</tasks>\n' if self.tasks else ''
        text = (f'<ladder version="1" name="p">\n{composites}<variables>\n{self.variables}\n'
                f'</variables>\n{tasks}{body}\n</ladder>\n')
        return re.sub(r'>[ ]*<', '>\n<', text)

    def line(self) -> int:
        """Return the line on which the wrong text stands."""
        lines = self.text().splitlines()
        found = [number for number, line in enumerate(lines, start=1) if self.here in line]
        assert self.here and len(found) >= 1, f'{self.here} is not in the program'
        return found[-1]


def contact(x: int, y: int, operand: str = 'a', **more: object) -> str:
    extra = ''.join(f' {key}="{value}"' for key, value in more.items())
    return f'<contact id="c{x}_{y}" x="{x}" y="{y}" operand="{operand}"{extra}/>'


def coil(x: int, y: int, operand: str = 'k', **more: object) -> str:
    extra = ''.join(f' {key}="{value}"' for key, value in more.items())
    return f'<coil id="k{x}_{y}" x="{x}" y="{y}" operand="{operand}"{extra}/>'


def timer(pins: str = '<input pin="PT" operand="T#1s"/>', more: str = 'instance="t1"') -> str:
    return (f'{contact(0, 0)}<block id="b" x="1" y="0" type="TON" {more}>{pins}</block>'
            f'{coil(2, 0)}')


def block(type_: str, pins: str) -> str:
    return f'{contact(0, 0)}<block id="b" x="1" y="0" type="{type_}">{pins}</block>{coil(2, 0)}'


def box(arguments: str, composite: str = 'Box', more: str = 'instance="x"') -> str:
    return (f'{contact(0, 0)}<instance id="i" x="1" y="0" composite="{composite}" {more}>'
            f'{arguments}</instance>{coil(2, 0)}')


BOTH = '<argument parameter="In" operand="b"/><argument parameter="Out" operand="m"/>'
TWO = '<input pin="IN1" operand="n"/><input pin="IN2" operand="1"/>'


def composite(name: str, inner: str) -> str:
    return (f'<composite name="{name}" call="inline"><rung id="1" width="1">'
            f'<instance id="i" x="0" y="0" composite="{inner}" instance="x"/>'
            '</rung></composite>')


def bomb(levels: int, base: str, call: str = 'inline') -> str:
    """Return composites of which each contains two of the one before."""
    text = [f'<composite name="C0" call="{call}">{base}</composite>']
    text += [
        f'<composite name="C{level}" call="{call}"><rung id="1" width="2">' + ''.join(
            f'<instance id="i{x}" x="{x}" y="0" composite="C{level - 1}" instance="x{x}"/>'
            for x in (0, 1)) + '</rung></composite>'
        for level in range(1, levels)]
    return '\n'.join(text)


def chain(levels: int, call: str) -> str:
    """Return composites of which each contains the one before."""
    text = [f'<composite name="C0" call="{call}">{SMALL}</composite>']
    text += [
        f'<composite name="C{level}" call="{call}"><rung id="1" width="1"><instance id="i" x="0" '
        f'y="0" composite="C{level - 1}" instance="x"/></rung></composite>'
        for level in range(1, levels)]
    return '\n'.join(text)


SMALL = ('<variable name="v" type="BOOL"/><rung id="1" width="2">'
         '<contact id="c" x="0" y="0" operand="v"/><coil id="k" x="1" y="0" operand="v"/></rung>')

WRONG: dict[str, Wrong] = {
    # names and types
    'L0201 variables': Wrong(
        code='L0201', variables=VARIABLES + '\n<variable name="A" type="INT"/>',
        here='name="A"', pou=''),
    'L0201 rung id': Wrong(
        code='L0201', body=f'<body name="main"><rung id="x" width="2">{GOOD}</rung>'
        f'<rung id="X" width="2">{GOOD}</rung></body>', here='id="X"'),
    'L0201 component id': Wrong(
        code='L0201', rung=GOOD + '<row id="C" x="2" y="0"/>', here='id="C"', cell=(2, 0)),
    'L0201 instance': Wrong(
        code='L0201', rung=timer(more='instance="M"'), here='id="b"', cell=(1, 0)),
    'L0201 composite': Wrong(
        code='L0201', composites=COMPOSITE.replace('Box', 'TON'), here='name="TON"', pou='TON'),
    'L0203 variable': Wrong(
        code='L0203', rung=contact(0, 0, 'mm') + coil(1, 0), width=2, here='"mm"', cell=(0, 0)),
    'L0203 in a composite': Wrong(
        code='L0203', composites=COMPOSITE.replace('operand="In"', 'operand="a"'),
        rung=box(BOTH), here='id="c"', cell=(0, 0), pou='Box'),
    'L0204 contact': Wrong(
        code='L0204', rung=contact(0, 0, 'n') + coil(1, 0), width=2, here='"n"/>', cell=(0, 0)),
    'L0204 pin': Wrong(
        code='L0204', rung=timer('<input pin="PT" operand="n"/>'), here='pin="PT"', cell=(1, 0)),
    'L0204 argument': Wrong(
        code='L0204', composites=COMPOSITE, rung=box(BOTH.replace('"b"', '"n"')),
        here='parameter="In" operand="n"', cell=(1, 0)),
    'L0204 source': Wrong(
        code='L0204', rung=f'<block id="s" x="0" y="0" type="ADD">{TWO}</block>'
        '<block id="b" x="1" y="0" type="TON" instance="t1"><input pin="PT" source="s.OUT"/>'
        f'</block>{coil(2, 0)}', here='source=', cell=(1, 0)),
    'L0205 literal': Wrong(
        code='L0205', rung=timer('<input pin="PT" operand="T#1parsec"/>'),
        here='T#1parsec', cell=(1, 0)),
    'L0206 composite': Wrong(
        code='L0206', composites=COMPOSITE, rung=box('', 'Bix'), here='"Bix"', cell=(1, 0)),
    'L0207 self': Wrong(
        code='L0207', composites=composite('A', 'A'), here='composite="A"', cell=(0, 0), pou='A'),
    'L0207 chain': Wrong(
        code='L0207', composites=composite('A', 'B') + composite('B', 'C') + composite('C', 'A'),
        here='composite="C"', cell=(0, 0), pou='B'),
    'L0208 type': Wrong(code='L0208', rung=block('TOON', ''), here='"TOON"', cell=(1, 0)),
    'L0209 pin': Wrong(
        code='L0209', rung=timer('<input pin="PV" operand="5"/>'), here='"PV"', cell=(1, 0)),
    'L0209 field': Wrong(
        code='L0209', rung=timer().replace('operand="a"', 'operand="t1.QQ"'), here='t1.QQ',
        cell=(0, 0)),
    'L0209 parameter': Wrong(
        code='L0209', composites=COMPOSITE, rung=box(BOTH.replace('"In"', '"Inn"')),
        here='"Inn"', cell=(1, 0), only=False),
    'L0210 pin': Wrong(code='L0210', rung=timer(''), here='id="b"', cell=(1, 0)),
    'L0210 parameter': Wrong(
        code='L0210', composites=COMPOSITE, rung=box(''), here='id="i"', cell=(1, 0), only=False),
    'L0211 input': Wrong(
        code='L0211', rung=contact(0, 0) + coil(1, 0, 'b'), width=2, here='id="k1_0"',
        cell=(1, 0)),
    'L0211 literal': Wrong(
        code='L0211', rung=contact(0, 0) + coil(1, 0, 'TRUE'), width=2, here='TRUE', cell=(1, 0)),
    'L0211 block output': Wrong(
        code='L0211', rung=timer().replace('operand="k"', 'operand="t1.Q"'), here='t1.Q',
        cell=(2, 0)),
    'L0211 output argument': Wrong(
        code='L0211', composites=COMPOSITE, rung=box(BOTH.replace('"m"', '"b"')),
        here='parameter="Out" operand="b"', cell=(1, 0)),
    'L0211 input parameter': Wrong(
        code='L0211', composites=COMPOSITE.replace('operand="Out"', 'operand="In"'),
        rung=box(BOTH), here='<coil id="k"', cell=(1, 0), pou='Box'),
    'L0212 two coils': Wrong(
        code='L0212', rung=contact(0, 0, down='right') + coil(1, 0) + coil(1, 1, up='left'),
        width=2, here='id="k1_1"', cell=(1, 1)),
    'L0213 two types': Wrong(
        code='L0213', rung=timer() + contact(0, 1) + '<block id="f" x="1" y="1" type="TOF" '
        'instance="T1"><input pin="PT" operand="T#1s"/></block>' + coil(2, 1, 'm'),
        here='id="f"', cell=(1, 1)),
    'L0215 task': Wrong(
        code='L0215', tasks='<task name="fast" interval="T#1ms"/>', here='<body', body=
        f'<body name="main" task="fsat"><rung id="1" width="2">{GOOD}</rung></body>'),
    'L0216 missing': Wrong(code='L0216', rung=timer(more=''), here='id="b"', cell=(1, 0)),
    'L0216 function': Wrong(
        code='L0216', rung=block('ADD" instance="x', TWO), here='id="b"', cell=(1, 0)),
    'L0219 no body': Wrong(code='L0219', body=' ', here='<ladder', pou=''),
    'L0220 types': Wrong(
        code='L0220', rung=block('ADD', TWO.replace('"1"', '"d"')), here='id="b"', cell=(1, 0)),
    'L0220 no number': Wrong(
        code='L0220', rung=block('ADD', TWO.replace('"n"', '"a"').replace('"1"', '"b"')),
        here='id="b"', cell=(1, 0)),
    'L0221 pin twice': Wrong(
        code='L0221', rung=timer('<input pin="PT" operand="T#1s"/><input pin="pt" operand="t"/>'),
        here='"pt"', cell=(1, 0)),
    'L0221 power pin': Wrong(
        code='L0221', rung=timer('<input pin="PT" operand="t"/><input pin="IN" operand="b"/>'),
        here='"IN"', cell=(1, 0)),
    'L0222 called twice': Wrong(
        code='L0222', rung=timer() + contact(0, 1) + '<block id="f" x="1" y="1" type="TON" '
        'instance="t1"><input pin="PT" operand="T#1s"/></block>' + coil(2, 1, 'm'),
        here='id="f"', cell=(1, 1)),
    # drawings
    'L0301 one cell': Wrong(
        code='L0301', rung=contact(0, 0) + '<row id="r" x="0" y="0"/>' + coil(1, 0), width=2,
        here='id="r"', cell=(0, 0), only=False),
    'L0301 wide': Wrong(
        code='L0301', rung=contact(0, 0, width=2) + '<row id="r" x="1" y="0"/>' + coil(2, 0),
        here='id="r"', cell=(1, 0), only=False),
    'L0301 under a tall block': Wrong(
        code='L0301', rung=timer().replace('id="b"', 'id="b" height="2"') +
        contact(0, 1, up='right') + '<row id="r" x="1" y="1" width="2"/>',
        here='id="r"', cell=(1, 1), only=False),
    'L0302 right': Wrong(
        code='L0302', rung=contact(0, 0) + '<row id="r" x="1" y="0" width="2"/>', width=2,
        here='id="r"', cell=(1, 0), only=False),
    'L0303 right end': Wrong(
        code='L0303', rung=GOOD.replace('"1" y', '"2" y'), here='id="c"', cell=(0, 0),
        only=False),
    'L0303 left end': Wrong(
        code='L0303', rung=contact(0, 0) + '<row id="r" x="1" y="0"/>' + coil(2, 0) +
        '<row id="q" x="1" y="1"/>' + coil(2, 1, 'm'), here='id="q"', cell=(1, 1), only=False),
    'L0303 pin': Wrong(
        code='L0303', rung=contact(0, 0) + '<block id="b" x="1" y="0" height="2" type="CTU" '
        'instance="c1"><input pin="R" row="1"/><input pin="PV" operand="1"/></block>'
        + coil(2, 0), here='id="b"', cell=(1, 0)),
    'L0304 down': Wrong(
        code='L0304', rung=contact(0, 0, down='right') + coil(1, 0), width=2, here='id="c0_0"',
        cell=(0, 0)),
    'L0304 up': Wrong(
        code='L0304', rung=contact(0, 0, up='right') + coil(1, 0), width=2, here='id="c0_0"',
        cell=(0, 0)),
    'L0304 column': Wrong(
        code='L0304', rung=contact(0, 0, down='right') + coil(1, 0)
        + '<column id="v" x="1" y="1"/>', width=2, here='id="v"', cell=(1, 1)),
    'L0305 empty': Wrong(code='L0305', rung='', here='<rung'),
    'L0305 only lines': Wrong(
        code='L0305', rung='<row id="r" x="0" y="0" width="3"/>', here='<rung'),
    'L0305 short circuit': Wrong(
        code='L0305', rung=contact(0, 0) + coil(1, 0) + '<row id="r" x="0" y="1" width="2"/>',
        width=2, here='<rung'),
    'L0306 no power': Wrong(
        code='L0306', rung=contact(0, 0) + '<row id="r" x="1" y="0"/>' + coil(2, 0)
        + coil(2, 1, 'm'), here='id="k2_1"', cell=(2, 1)),
    'L0307 functions': Wrong(
        code='L0307', rung='<block id="f" x="0" y="0" type="ADD"><input pin="IN1" source="g.OUT"/>'
        '<input pin="IN2" operand="n"/></block>'
        '<block id="g" x="1" y="0" type="ADD"><input pin="IN1" source="f.OUT"/>'
        '<input pin="IN2" operand="n"/></block>' + coil(2, 0), here='id="f"', cell=(0, 0),
        only=False),
    'L0308 goes nowhere': Wrong(
        code='L0308', rung=contact(0, 0) + contact(1, 0), width=2, here='id="c1_0"', cell=(1, 0)),
    'L0310 no such block': Wrong(
        code='L0310', rung=timer('<input pin="PT" source="bb.ET"/>'), here='bb.ET', cell=(1, 0)),
    'L0310 no output': Wrong(
        code='L0310', rung=timer('<input pin="PT" source="c0_0.Q"/>'), here='c0_0.Q',
        cell=(1, 0)),
    'L0311 always on': Wrong(
        code='L0311', rung='<row id="r" x="0" y="0"/>' + coil(1, 0), width=2, here='id="k1_0"',
        cell=(1, 0)),
    'L0312 no such row': Wrong(
        code='L0312', rung=contact(0, 0) + '<block id="b" x="1" y="0" height="2" type="CTU" '
        'instance="c1"><input pin="R" row="2"/><input pin="PV" operand="1"/></block>'
        + coil(2, 0), here='id="b"', cell=(1, 0), only=False),
    # size
    'L0401 deep': Wrong(
        code='L0401', composites=chain(150, 'enabled'), rung=box('', 'C149'), here='<body'),
    'L0401 bomb': Wrong(
        code='L0401', composites=bomb(25, SMALL), rung=box('', 'C24'), here='<body'),
    'L0401 enabled bomb of nothing': Wrong(
        code='L0401', composites=bomb(25, '', 'enabled'), rung=box('', 'C24'),
        here='<body'),
}

# Codes of no drawing: the reader's, a wiring's (below), an instruction list's (test_il.py).
ELSEWHERE = {'L0202', 'L0218', 'L0313', 'L0402'}


@pytest.fixture(params=WRONG, ids=lambda name: name.replace(' ', '_'))
def wrong(request: pytest.FixtureRequest) -> Iterator[tuple[str, Wrong]]:
    yield request.param, WRONG[request.param]


def diagnose(text: str) -> tuple[Diagnostic, ...]:
    """Return everything that reader and compiler have to say."""
    try:
        return check_program(parse_program(text.encode(), 'program.xml'))
    except LadderError as error:
        return error.diagnostics


def test_check_when_a_program_is_wrong_then_says_where(wrong: tuple[str, Wrong]) -> None:
    _, case = wrong
    found = [d for d in diagnose(case.text()) if d.code == case.code]
    assert found, render(diagnose(case.text()))
    place = found[0].location
    assert (place.file, place.line) == ('program.xml', case.line()), str(place)
    assert place.cell == case.cell
    assert place.pou == case.pou
    assert found[0].help


def test_check_when_a_program_is_wrong_then_people_can_read_it(
    wrong: tuple[str, Wrong], golden: Callable[[str, str], None],
) -> None:
    name, case = wrong
    text = indent(case.text() if len(case.text()) < 3000 else '...', '    ')
    golden(f'{text}\n{render(diagnose(case.text()))}',
           f'compiler/wrong/{name.replace(" ", "_")}.txt')


def test_check_when_one_thing_is_wrong_then_says_one_thing(wrong: tuple[str, Wrong]) -> None:
    """No mistake drags others behind it, but where several parts of a drawing are wrong."""
    _, case = wrong
    if case.only:
        assert {d.code for d in diagnose(case.text())} == {case.code}


def test_compile_when_a_program_has_errors_then_raises_them(wrong: tuple[str, Wrong]) -> None:
    _, case = wrong
    try:
        program = parse_program(case.text().encode(), 'program.xml')
    except LadderError:
        return
    if PROBLEMS[case.code].severity is Severity.ERROR:
        with pytest.raises(LadderError) as caught:
            compile_program(program)
        assert case.code in {d.code for d in caught.value.diagnostics}
    else:
        assert case.code in {d.code for d in compile_program(program).diagnostics}


def test_graph_when_power_comes_back_then_is_refused() -> None:
    """No drawing on a grid does this, but a wiring made in another way can."""
    components = [
        Contact(id=id, placement=Placement(x=x, y=0), operand='a') for x, id in enumerate('ab')]
    parts = tuple(
        Part(component=c, left=(End(pin='', net=i),), right=(End(pin='', net=1 - i),))
        for i, c in enumerate(components))
    wiring = Wiring(
        rung=Rung(id='1', width=2, components=tuple(components)), parts=parts, lines=(),
        nets=tuple(Net(index=i, x=i, first=0, last=0) for i in (0, 1)))
    operand = Resolved(operand=Ref(path='a', type=DataType.BOOL))
    _, found = build_aov(wiring, {'a': operand, 'b': operand})
    assert [d.code for d in found] == ['L0313']
    assert 'a, b' in found[0].message


def test_codes_when_listed_then_each_has_a_case() -> None:
    # From L0224 to L0299 they are about texts and drawings of other editors.
    codes = {code for code in PROBLEMS
             if code[:3] in ('L02', 'L03', 'L04') and not 'L0224' <= code < 'L0300'}
    assert codes - {case.code for case in WRONG.values()} == ELSEWHERE


def test_check_when_a_program_has_many_mistakes_then_reports_them_all_in_order() -> None:
    rung = (contact(0, 0, 'missing') + '<block id="b" x="1" y="0" type="TOON"/>'
            + coil(2, 0, 'n') + contact(0, 1, 'a', down='right'))
    found = diagnose(Wrong(code='', rung=rung).text())
    assert {'L0203', 'L0208', 'L0204', 'L0303', 'L0304'} <= {d.code for d in found}
    lines = [d.location.line for d in found]
    assert lines == sorted(lines)


def test_compile_when_backend_is_unknown_then_names_the_known_ones() -> None:
    program = parse_program(Wrong(code='').text().encode())
    with pytest.raises(LadderError, match=r'L0504(.|\n)*python'):
        executable(program, 'abacus')

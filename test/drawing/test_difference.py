# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What changed between two programs, as text, as a picture and as a page."""

from __future__ import annotations

from collections import Counter
import json
from pathlib import Path
import re
from xml.etree import ElementTree

from compiler.imported_programs import block, element, pin, program, variables
from hypothesis import given, Phase, settings
import pytest
from strategies import programs
from support.documents import compare, fences, ROOT
from support.plcopen import project

from ladder_ros import showing
from ladder_ros.cli.main import main
from ladder_ros.comparing import changes_between
from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.drawing.difference_html import difference_html
from ladder_ros.drawing.difference_svg import difference_svg
from ladder_ros.drawing.difference_text import Comparison, difference_text
from ladder_ros.model.program import Program
from ladder_ros.refactor.diff import diff_programs
from ladder_ros.source.read_any import parse_any

PROGRAMS = ROOT / 'programs'
SVG = '{http://www.w3.org/2000/svg}'
NASTY = '&lt;script&gt;alert(1)&lt;/script&gt; &amp;amp; &quot;&#x202e;rtl'


def rung(id: str, *operands: str, comment: str = '') -> str:
    """Make a rung of contacts in series and a coil."""
    *contacts, coil = operands
    drawn = ''.join(f'<contact id="{name}" x="{x}" y="0" operand="{name}"/>'
                    for x, name in enumerate(contacts))
    return (f'<rung id="{id}" width="{len(operands)}" comment="{comment}">{drawn}'
            f'<coil id="k" x="{len(contacts)}" y="0" operand="{coil}"/></rung>')


def made(*rungs: str) -> Program:
    names = ''.join(f'<variable name="{name}" type="BOOL"/>' for name in 'abcdefg')
    return parse_any((f'<ladder version="1" name="p"><variables>{names}</variables>'
                      f'<body name="main">{"".join(rungs)}</body></ladder>').encode(), 'p.xml')


def compared(old: Program, new: Program) -> Comparison:
    return Comparison(old=old, new=new, diff=diff_programs(old, new), names=('old', 'new'))


def text_of(old: Program, new: Program, width: int = 200) -> str:
    return ''.join(difference_text(compared(old, new), width=width))


def words(markup: str) -> list[str]:
    """Return what a picture or page says, as a browser shows it."""
    return [text.strip() for text in ElementTree.fromstring(markup).itertext() if text.strip()]


def ids(markup: str) -> list[str]:
    return [one.get('id', '') for one in ElementTree.fromstring(markup).iter() if one.get('id')]


def marks(svg: str) -> Counter[str]:
    return Counter(one.get('class', '').split()[1] for one in ElementTree.fromstring(svg).iter()
                   if one.tag == f'{SVG}rect' and one.get('class', '').startswith('mark '))


FOUR = (rung('1', 'a', 'b'), rung('2', 'b', 'c'), rung('3', 'c', 'd'), rung('4', 'd', 'e'))


def test_rungs_when_unchanged_then_a_run_of_them_is_one_line() -> None:
    old, new = made(*FOUR), made(*FOUR, rung('5', 'e', 'f'))
    assert '\N{MIDLINE HORIZONTAL ELLIPSIS} 4 rungs unchanged: 1 to 4' in words(
        difference_svg(compared(old, new)))
    page = difference_html(compared(old, new))
    assert page.count('<details>') == 1
    assert '<summary>4 rungs unchanged: 1 to 4</summary>' in page


def test_rung_when_moved_then_it_is_told_from_where() -> None:
    old, new = made(*FOUR), made(FOUR[3], *FOUR[:3])
    assert '> rung 4 moved from behind rung 3' in text_of(old, new)
    assert '> rung 4 moved from behind rung 3' in words(difference_svg(compared(old, new)))
    back = diff_programs(new, old).to_json()
    assert json.loads(json.dumps(back))['pous'][0]['rungs'][0]['was_behind'] == ''


def test_rung_when_removed_then_it_stands_where_it_was() -> None:
    found = diff_programs(made(*FOUR), made(FOUR[0], rung('9', 'f', 'g'), *FOUR[2:]))
    assert [(one.what.value if one.what else '', one.id) for one in found.pous[0].aligned] == [
        ('', '1'), ('removed', '2'), ('added', '9'), ('', '3'), ('', '4')]


def test_components_when_changed_then_both_sides_are_marked() -> None:
    old = made(rung('1', 'a', 'b', 'c', 'd'))
    new = made(rung('1', 'a', 'c', 'e', 'd').replace('id="c" x="1"', 'id="c" x="1" kind="nc"'))
    legend = Counter(added=1, removed=1, changed=1, moved=1)
    assert marks(difference_svg(compared(old, new))) - legend == Counter(
        added=1, removed=1, changed=2)


def test_components_when_they_only_moved_then_they_are_one_line() -> None:
    assert '> components b, c, k: place' in text_of(
        made(rung('1', 'a', 'b', 'c', 'd')),
        made(rung('1', 'a', 'e', 'b', 'c', 'd')))


def test_statements_when_changed_then_lines_stand_side_by_side(tmp_path: Path) -> None:
    text = 'PROGRAM p VAR n : INT; END_VAR\n n := 1;\n n := 2;\n{}END_PROGRAM'
    for name, more in (('old.st', 'n := 3;\n'), ('new.st', 'n := 4;\nn := 5;\n')):
        (tmp_path / name).write_text(text.format(more))
    changes = changes_between(tmp_path / 'old.st', tmp_path / 'new.st')
    lines = [re.split(r' {2,}', line.strip()) for line in changes.lines(width=120)]
    assert ['~', 'n := 3;', '~', 'n := 4;'] in lines
    assert ['+', 'n := 5;'] in lines
    assert {'n := 3;', 'n := 5;'} <= set(words(changes.as_svg()))
    assert '<td class="added"><code>+     n := 5;</code></td>' in changes.as_html()


def imported(*networks: tuple[str, str, str]) -> Program:
    """Make a drawing of another editor with networks of a contact and a coil."""
    body = ''.join(
        element('contact', 2 * n + 1, [0], a, y=40 * n, attributes=kind)
        + element('coil', 2 * n + 2, [2 * n + 1], k, x=90, y=40 * n)
        for n, (a, kind, k) in enumerate(networks))
    return with_drawings(program(body, variables(**dict.fromkeys('abcdk', 'BOOL'))))


def test_imported_drawing_when_a_network_comes_first_then_the_others_did_not_change() -> None:
    old = imported(('a', '', 'b'), ('b', '', 'c'))
    new = imported(('d', '', 'k'), ('a', '', 'b'), ('b', 'negated="true"', 'c'))
    told = text_of(old, new)
    assert re.findall(r'[+~>-] rung.*', told) == ['+ rung 1 added', '~ rung 3 changed (was 2)']
    assert 'contact no b becomes contact nc b' in told
    assert '~b' in told


def test_imported_drawing_when_connected_otherwise_then_that_is_told() -> None:
    def drawn(*sources: int) -> Program:
        return with_drawings(program(
            element('contact', 1, [0], 'a') + element('contact', 2, sources, 'b', x=50)
            + element('coil', 3, [1, 2], 'k', x=90), variables(a='BOOL', b='BOOL', k='BOOL')))

    assert '~ connections of rung 1' in text_of(drawn(0), drawn(1))


@given(programs(), programs())
@settings(max_examples=15, deadline=None, phases=[Phase.reuse, Phase.generate])
def test_programs_when_any_two_are_compared_then_pictures_and_pages_are_well_formed(
    old: Program, new: Program,
) -> None:
    comparison = compared(old, new)
    for markup in (difference_svg(comparison), difference_html(comparison)):
        headings = [id for id in ids(markup) if '-' not in id]
        assert len(headings) == len(set(headings))
        assert 'href="http' not in markup and '<script' not in markup
    list(difference_text(comparison, width=80))


def test_names_when_they_are_markup_then_they_are_text() -> None:
    old = made(rung('1', 'a', 'b'))
    new = made(rung('1', 'a', 'b', 'c', comment=NASTY))
    comparison = Comparison(old=old, new=new, diff=diff_programs(old, new),
                            names=('<i>.xml', '"&".xml'))
    for markup in (difference_svg(comparison), difference_html(comparison)):
        assert '<script' not in markup and '<i>' not in markup
        assert any('<script>alert(1)</script>' in text for text in words(markup))
        assert '\u202e' not in markup


def test_imported_names_when_they_are_markup_then_they_are_text(tmp_path: Path) -> None:
    name = '&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;&amp;&#x202e;&#x5d0;'
    for file, kind in (('old.xml', ''), ('new.xml', 'negated="true"')):
        body = (element('contact', 1, [0], 'a')
                + block(name, 2, [pin(name, 1)], [name], name='b1')
                + element('coil', 3, [1], 'a', attributes=kind))
        (tmp_path / file).write_bytes(project(
            f'<pou name="{name}" pouType="program"><interface>{variables(a="BOOL")}</interface>'
            f'<body><LD><leftPowerRail localId="0"/>{body}</LD></body></pou>'))
    changes = changes_between(tmp_path / 'old.xml', tmp_path / 'new.xml')
    pages = (changes.as_svg(), changes.as_html(), showing.as_svg(tmp_path / 'old.xml'),
             showing.as_html(tmp_path / 'old.xml'))
    for markup in pages:
        assert '<script' not in markup and '\u202e' not in markup
        assert '<script>alert("1")</script>' in ' '.join(words(markup))
    text = ''.join(changes.lines(width=100))
    assert '\u202e' not in text
    assert 'coil coil a becomes coil negated a' in text


def test_pictures_when_too_wide_then_they_stand_above_each_other() -> None:
    wide = ['a', 'b'] * 60
    old, new = (parse_any(text.encode(), 'w.xml') for text in (
        _with_own_ids(wide, 'c'), _with_own_ids(wide, 'd')))
    page = difference_html(compared(old, new))
    assert 'class="rung changed wide"' in page
    assert 'translate(0 ' in difference_svg(compared(old, new))


def _with_own_ids(contacts: list[str], coil: str) -> str:
    drawn = ''.join(f'<contact id="c{x}" x="{x}" y="0" operand="{name}"/>'
                    for x, name in enumerate(contacts))
    names = ''.join(f'<variable name="{name}" type="BOOL"/>' for name in 'abcd')
    return (f'<ladder version="1" name="p"><variables>{names}</variables><body name="main">'
            f'<rung id="1" width="{len(contacts) + 1}">{drawn}<coil id="k" x="{len(contacts)}" '
            f'y="0" operand="{coil}"/></rung></body></ladder>')


@pytest.mark.parametrize('form', ['svg', 'html'])
def test_diff_when_asked_for_a_file_then_it_is_written_and_the_status_tells(
    form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    target = tmp_path / f'changes.{form}'
    assert main(['diff', 'elevator_3_floor_flat', 'elevator_3_floor', f'--{form}', str(target),
                 '--json']) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer['output'] == str(target) and answer['changes']['pous']
    assert 'FloorIndicator' in ' '.join(words(target.read_text(encoding='utf-8')))
    assert main(['diff', 'start_stop', 'start_stop', f'--{form}', str(target)]) == 0


def test_diff_when_git_asks_for_a_page_then_it_is_of_both_revisions(tmp_path: Path) -> None:
    old, new = tmp_path / 'x1_old.xml', tmp_path / 'x2_new.xml'
    text = (PROGRAMS / 'start_stop.xml').read_text(encoding='utf-8')
    old.write_text(text, encoding='utf-8')
    new.write_text(text.replace('kind="nc"', 'kind="no"', 1), encoding='utf-8')
    target = tmp_path / 'changes.html'
    assert main(['diff', '--html', str(target), 'programs/cell.xml', str(old), 'abc', '100644',
                 str(new), 'def', '100644']) == 0
    assert 'programs/cell.xml' in target.read_text(encoding='utf-8')


def test_picture_of_a_difference_in_the_docs_when_drawn_again_then_it_is_the_same(
    tmp_path: Path, request: pytest.FixtureRequest,
) -> None:
    page = (ROOT / 'docs' / 'diff.md').read_text(encoding='utf-8')
    for fence in fences(page):
        if fence.file:
            (tmp_path / fence.file).write_text(fence.text, encoding='utf-8')
    changes = changes_between(tmp_path / 'old.xml', tmp_path / 'new.xml')
    compare(ROOT / 'docs' / 'pictures' / 'diff.svg', changes.as_svg(), request)

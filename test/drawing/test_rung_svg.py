# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""SVG pictures of rungs: valid whatever the rung, nothing over another, all found by ids."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
import itertools
import re
from xml.etree import ElementTree

from drawing.rungs import coil, contact, latch, row, rung, rungs, SEAL_IN
from drawing.test_rung_text import BRIDGE, CALL, COUNTER, CROSSING, SHOWN, TIMER
from hypothesis import assume, given, settings
import pytest

from ladder_ros.drawing.canvas import text_width
from ladder_ros.drawing.flow import Live
from ladder_ros.drawing.glyphs import UNICODE
from ladder_ros.drawing.layout import grid_of
from ladder_ros.drawing.rung_svg import component_anchor, rung_svg, SvgStyle
from ladder_ros.drawing.sketch import is_too_large, make_sketch
from ladder_ros.model.difference import What
from ladder_ros.model.program import CallKind, Rung

Golden = Callable[[str, str], None]
COMPOSITES = {'floorindicator': latch()}
SVG = '{http://www.w3.org/2000/svg}'
LIVE = Live(values={'a': '1', 'b': '0', 'c': '0', 'd': '1', 'e': '1', 'out': '1'})


def elements(text: str, tag: str, **attributes: str) -> list[ElementTree.Element]:
    """Return the elements of a tag, in order; a class is one of several."""
    return [one for one in ElementTree.fromstring(text).iter(SVG + tag) if all(
        value in one.get({'kind': 'class'}.get(name, name), '').split()
        for name, value in attributes.items())]


def without_style(text: str) -> str:
    return re.sub('<style>.*?</style>', '<style/>', text, flags=re.DOTALL)


def by_id(text: str, component: str) -> ElementTree.Element:
    found, = (one for one in elements(text, 'g')
              if one.get('id') == component_anchor('p', '1', component))
    return found


@pytest.mark.parametrize(('name', 'drawn', 'style'), [
    ('seal_in', SEAL_IN, SvgStyle(pou='p', addresses={'start': '%IX0.0'})),
    ('timer', TIMER, SvgStyle(pou='p', live=Live(values={'t1.et': 'T#3s'}))),
    ('bridge', BRIDGE, SvgStyle(pou='p', live=LIVE)),
    ('crossing', CROSSING, SvgStyle(pou='p', grid=True)),
    ('call', CALL, SvgStyle(pou='p', marks={'i1': What.CHANGED})),
])
def test_rung_when_drawn_as_svg_then_it_looks_as_expected(
    name: str, drawn: Rung, style: SvgStyle, golden: Golden,
) -> None:
    golden(without_style(rung_svg(drawn, COMPOSITES, style)), f'drawing/{name}.svg')


def test_bridge_when_values_are_known_then_power_goes_both_ways_along_the_verticals() -> None:
    text = rung_svg(BRIDGE, {}, SvgStyle(pou='p', live=LIVE))
    wires = {name: [one.get('class') for one in by_id(text, name).iter(SVG + 'path')
                    if 'wire' in one.get('class', '')] for name in ('c1_0', 'c1_1', 'c0_2')}
    assert wires == {'c1_0': ['wire on', 'wire on'], 'c1_1': ['wire on', 'wire on'],
                     'c0_2': ['wire on', 'wire on']}


def test_power_when_noted_in_the_scan_then_it_goes_before_what_values_tell() -> None:
    drawn = rung(2, contact(0, 0, 'a', 'rising'), coil(1, 0, 'x'))
    def out(live: Live) -> str | None:
        text = rung_svg(drawn, {}, SvgStyle(pou='p', live=live))
        return next(iter(by_id(text, 'k1_0').iter(SVG + 'path'))).get('class')

    assert [out(Live(values={'a': '1'})), out(Live(power={'1': {'c0_0': True}})),
            out(Live(power={'1': {'c0_0': False}}))] == ['wire', 'wire on', 'wire off']


def test_vertical_when_it_passes_a_wire_then_there_is_a_gap_and_no_dot() -> None:
    text = rung_svg(CROSSING)
    halo, = elements(text, 'path', kind='halo')
    dots = {(one.get('cx'), one.get('cy')) for one in elements(text, 'circle', kind='joint')}
    place = re.match(r'M(\d+) ', halo.get('d', ''))
    assert place is not None
    assert {x for x, _ in dots} == {place[1]}
    assert len(dots) == 2


def test_component_when_marked_then_a_sign_and_its_title_tell_it_without_colours() -> None:
    text = rung_svg(SEAL_IN, {}, SvgStyle(pou='p', marks={'c0_0': What.REMOVED}))
    assert len(elements(text, 'rect', kind='removed')) == 1
    assert '>-</text>' in text
    title = by_id(text, 'c0_0').find(SVG + 'title')
    assert title is not None
    assert (title.text or '').endswith('removed')


@pytest.mark.parametrize('name', [
    '</text><script>alert(1)</script>', '"\'&<>', 'a\x00b', '\ud800'])
def test_name_when_it_is_markup_then_it_stays_text(name: str) -> None:
    drawn = replace(rung(1, replace(contact(0, 0, name), id=name, comment=name)), id=name,
                    comment=name)
    tags = {one.tag for one in ElementTree.fromstring(
        rung_svg(drawn, {}, SvgStyle(pou=name, addresses={name.casefold(): name}))).iter()}
    assert tags <= {SVG + tag for tag in ('svg', 'title', 'style', 'rect', 'g', 'path', 'text')}


def test_enabled_composite_when_drawn_then_it_is_a_grey_box_with_its_pins() -> None:
    text = rung_svg(CALL, {'floorindicator': latch(CallKind.ENABLED)}, SvgStyle(pou='p'))
    box = by_id(text, 'i1')
    assert 'composite' in box.get('class', '').split()
    assert next(one.text for one in box.iter(SVG + 'text')) == 'FloorIndicator'
    assert {'EN', 'ENO', 'at_1', 'called'} <= {one.text for one in box.iter(SVG + 'text')}


def boxes(text: str) -> list[tuple[float, float, float, float]]:
    return [(x, y, x + width, y + height) for x, y, width, height in (
        [float(one.get(name, '')) for name in ('x', 'y', 'width', 'height')]
        for one in elements(text, 'rect', kind='frame'))]


def letters(text: str) -> list[tuple[float, float, float]]:
    """Return line, left and right of each text."""
    found = []
    for one in elements(text, 'text'):
        classes, width = one.get('class', '').split(), 8 * text_width(one.text or '')
        x = float(one.get('x', '')) - (
            width / 2 if 'middle' in classes else width if 'end' in classes else 0)
        found.append((float(one.get('y', '')), x, x + width))
    return sorted(found)


def check_apart(text: str) -> None:
    """Check that no frame and no text lies over another."""
    frames = boxes(text)
    for at, (left, top, right, bottom) in enumerate(frames):
        for x0, y0, x1, y1 in frames[at + 1:]:
            assert right <= x0 or x1 <= left or bottom <= y0 or y1 <= top
    written = letters(text)
    for (line, _, right), (other, start, _) in itertools.pairwise(written):
        assert line != other or right <= start + 0.5


@pytest.mark.parametrize('name', SHOWN)
def test_rung_when_drawn_as_svg_then_no_text_lies_over_another(name: str) -> None:
    check_apart(rung_svg(SHOWN[name], COMPOSITES))


@given(rungs())
@settings(max_examples=60, deadline=None)
def test_rung_when_random_then_its_svg_is_valid_and_each_component_is_there_once(
    drawn: Rung,
) -> None:
    assume(len({one.id for one in drawn.components}) == len(drawn.components))
    text = rung_svg(drawn, COMPOSITES, SvgStyle(pou='p', live=Live(values={'a': '1'})))
    check_apart(text)
    ids = Counter(one.get('id') for one in elements(text, 'g', kind='component'))
    grid = grid_of(drawn)
    shown = [] if is_too_large(drawn, grid) else make_sketch(drawn, grid, {}, UNICODE).shapes
    assert ids == Counter(component_anchor('p', drawn.id, one.id)
                          for one, shape in shown if shape is not None)


def test_counter_when_drawn_then_every_pin_is_named() -> None:
    written = {one.text for one in elements(rung_svg(COUNTER), 'text')}
    assert {'CU', 'CD', 'R', 'LD', 'PV', 'QU', 'QD', 'CV', '10', 'clear', 'n', 'CTUD'} <= written


def test_operand_when_very_long_then_it_is_wrapped_and_told_in_the_title() -> None:
    name = 'conveyor_of_the_packing_hall_motor_protection_tripped_' + 'x' * 30
    text = rung_svg(rung(3, contact(0, 0, name), row(1, 0), coil(2, 0, 'y')), {},
                    SvgStyle(pou='p'))
    check_apart(text)
    title = by_id(text, 'c0_0').find(SVG + 'title')
    assert title is not None
    assert name in (title.text or '')

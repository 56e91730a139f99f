# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A sheet of SVG: lines, texts and frames on the places that a layout gives in characters.

Every text is escaped here and nowhere else.  Colours are plain values in a style sheet, once for
light and once for dark, because not every viewer knows variables.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
import re

from ladder_ros.drawing.canvas import printable, text_width
from ladder_ros.drawing.glyphs import UNICODE

CHARACTER = 8
"""Pixels that a character of a layout is wide; fonts of 13 px need 7.8."""
LINE = 20
"""Pixels that a line of a layout is high."""

_LIGHT = {
    'paper': '#ffffff', 'ink': '#1f2328', 'muted': '#59636e', 'address': '#0550ae',
    'on': '#117a37', 'off': '#8c959f', 'block': '#f6f8fa', 'composite': '#d8dde3',
    'bar': '#eaeef2', 'bad': '#cf222e', 'added': '#c8f0d0', 'removed': '#ffd3d0',
    'changed': '#fff0b3', 'moved': '#cfe3ff',
}
_DARK = {
    'paper': '#0d1117', 'ink': '#e6edf3', 'muted': '#9198a1', 'address': '#79b8ff',
    'on': '#4ade80', 'off': '#6e7681', 'block': '#161b22', 'composite': '#30363d',
    'bar': '#21262d', 'bad': '#ff7b72', 'added': '#12442a', 'removed': '#5c1f22',
    'changed': '#4d3d0a', 'moved': '#163760',
}

_SHAPES = """
.ladder text { font: 13px ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; \
white-space: pre }
.ladder .wire, .ladder .symbol { fill: none; stroke-width: 1.5 }
.ladder .symbol { stroke-width: 2 }
.ladder .rail { stroke-width: 4 }
.ladder .wire.on, .ladder .symbol.on { stroke-width: 3 }
.ladder .halo { stroke-width: 9 }
.ladder .frame { stroke-width: 1.5 }
.ladder .type, .ladder .rung { font-weight: bold }
.ladder .value { font-weight: bold }
.ladder .middle { text-anchor: middle }
.ladder .end { text-anchor: end }
.ladder .mark { stroke-width: 1 }
.ladder .mark.removed { stroke-dasharray: 4 3 }
.ladder .mark.changed, .ladder .mark.renamed { stroke-dasharray: 1 2 }
"""


def _colours(palette: Mapping[str, str]) -> str:
    c = palette
    return f"""
.ladder .paper {{ fill: {c['paper']} }}
.ladder text {{ fill: {c['ink']} }}
.ladder .wire, .ladder .symbol, .ladder .rail {{ stroke: {c['ink']} }}
.ladder .halo {{ stroke: {c['paper']} }}
.ladder .wire.on, .ladder .symbol.on {{ stroke: {c['on']} }}
.ladder .wire.off, .ladder .symbol.off {{ stroke: {c['off']} }}
.ladder .joint {{ fill: {c['ink']} }}
.ladder .joint.on {{ fill: {c['on']} }}
.ladder .joint.off {{ fill: {c['off']} }}
.ladder .frame {{ fill: {c['block']}; stroke: {c['ink']} }}
.ladder .composite .frame {{ fill: {c['composite']} }}
.ladder .bar {{ fill: {c['bar']} }}
.ladder .composite .bar {{ fill: {c['paper']} }}
.ladder .address {{ fill: {c['address']} }}
.ladder .value, .ladder .lit {{ fill: {c['on']} }}
.ladder .note {{ fill: {c['muted']} }}
.ladder .bad {{ stroke: {c['bad']}; fill: none; stroke-width: 2 }}
.ladder .mark {{ stroke: {c['muted']} }}
.ladder .mark.added {{ fill: {c['added']} }}
.ladder .mark.removed {{ fill: {c['removed']} }}
.ladder .mark.changed, .ladder .mark.renamed {{ fill: {c['changed']} }}
.ladder .mark.moved {{ fill: {c['moved']} }}"""


STYLE_SHEET = f"""{_SHAPES.strip()}
{_colours(_LIGHT).strip()}
@media screen and (prefers-color-scheme: dark) {{
{_colours(_DARK).strip()}
}}"""
"""What pictures look like, in a file of their own or in a page."""


def anchor(*names: str) -> str:
    """Return an XML id for the thing that the names lead to, different for different names."""
    return '-'.join(
        re.sub('[^A-Za-z0-9_]', lambda match: f'.{ord(match[0]):x}.', name) for name in names)


def markup(text: str) -> str:
    """Return text, of whatever origin, as XML text or an attribute's value in double quotes."""
    return escape(printable(text, UNICODE))


class Sheet:
    """Collects elements; places are in characters of a layout, (0, 0) the middle of the first."""

    def __init__(self, left: int = 0, top: int = 0) -> None:
        """Make an empty sheet whose first character stands at these pixels."""
        self.left = left
        self.top = top
        self.lines: list[str] = []

    def x(self, character: float) -> float:
        """Return the pixels from the left of the middle of a character."""
        return _short(self.left + (character + 0.5) * CHARACTER)

    def y(self, line: float) -> float:
        """Return the pixels from the top of the middle of a line."""
        return _short(self.top + (line + 0.5) * LINE)

    def add(self, element: str) -> None:
        """Add an element as it is."""
        self.lines.append(element)

    def path(self, classes: str, *moves: str) -> None:
        """Draw a path."""
        self.add(f'<path class="{classes}" d="{" ".join(moves)}"/>')

    def across(self, classes: str, y: float, first: float, last: float) -> None:
        """Draw a horizontal line between the middles of two characters."""
        if first != last:
            self.path(classes, f'M{self.x(first)} {self.y(y)}H{self.x(last)}')

    def down(self, classes: str, x: float, first: float, last: float) -> None:
        """Draw a vertical line between the middles of two lines."""
        self.path(classes, f'M{self.x(x)} {self.y(first)}V{self.y(last)}')

    def text(self, classes: str, x: float, y: float, text: str) -> None:
        """Write text on a line from (or around, or up to, by its class) the middle of a place.

        What needs other fonts is fitted into its characters.
        """
        fitted = '' if text.isascii() else (
            f' textLength="{text_width(text) * CHARACTER}" lengthAdjust="spacingAndGlyphs"')
        named = f' class="{classes}"' if classes else ''
        self.add(f'<text{named} x="{self.x(x)}" y="{_short(self.y(y) + 4.5)}"{fitted}>'
                 f'{markup(text)}</text>')

    def rectangle(
        self, classes: str, corner: tuple[float, float], size: tuple[float, float],
    ) -> None:
        """Draw a rectangle; all in pixels."""
        self.add(f'<rect class="{classes}" x="{_short(corner[0])}" y="{_short(corner[1])}" '
                 f'width="{_short(size[0])}" height="{_short(size[1])}"/>')

    def dot(self, classes: str, x: float, y: float) -> None:
        """Draw a joint."""
        self.add(f'<circle class="{classes}" cx="{self.x(x)}" cy="{self.y(y)}" r="3.5"/>')


def _short(number: float) -> float:
    """Return a coordinate without needless digits."""
    rounded = round(number, 1)
    return int(rounded) if rounded == int(rounded) else rounded


def document(size: tuple[float, float], title: str, body: Iterable[str]) -> str:
    """Return an SVG file."""
    width, height = size
    return '\n'.join([
        (f'<svg xmlns="http://www.w3.org/2000/svg" class="ladder" width="{width}" '
         f'height="{height}" viewBox="0 0 {width} {height}" role="img">'),
        f'<title>{markup(title)}</title>',
        f'<style>{STYLE_SHEET}</style>',
        f'<rect class="paper" width="{width}" height="{height}"/>',
        *body, '</svg>', ''])

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The characters that drawings are made of: box characters, or ASCII where those do not exist."""

from __future__ import annotations

from dataclasses import dataclass

LEFT, RIGHT, UP, DOWN = 1, 2, 4, 8
"""Bits of a line's character: the directions in which the line goes on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxGlyphs:
    """The frame of a block or a composite instance.

    ``wired_left`` and ``wired_right`` are its sides where a wire arrives.
    """

    top_left: str
    top_right: str
    bottom_left: str
    bottom_right: str
    across: str
    side: str
    wired_left: str
    wired_right: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Glyphs:
    """A set of characters.

    ``lines`` is indexed by the direction bits; ``crossing`` are the three characters where a
    vertical line crosses a row without joining it; ``loose`` marks an end that meets nothing;
    ``data`` leads a direct data connection to its pin; ``both`` marks an in-out parameter.
    """

    ascii_only: bool
    lines: str
    rail: str
    rail_wired_right: str
    rail_wired_left: str
    rail_wired_both: str
    contact: tuple[str, str]
    crossing: str
    loose: str
    data: str
    both: str
    cut: str
    block: BoxGlyphs
    composite: BoxGlyphs


UNICODE = Glyphs(
    ascii_only=False,
    lines=' ───│┘└┴│┐┌┬│┤├┼',
    rail='║', rail_wired_right='╟', rail_wired_left='╢', rail_wired_both='╫',
    contact=('┤', '├'), crossing='╴│╶', loose='×', data='→', both='↔', cut='…',
    block=BoxGlyphs(
        top_left='┌', top_right='┐', bottom_left='└', bottom_right='┘',
        across='─', side='│', wired_left='┤', wired_right='├'),
    composite=BoxGlyphs(
        top_left='╔', top_right='╗', bottom_left='╚', bottom_right='╝',
        across='═', side='║', wired_left='╢', wired_right='╟'),
)
"""Box characters, all of them one column wide in every terminal font."""

ASCII = Glyphs(
    ascii_only=True,
    lines=' ---|+++|+++|+++',
    rail='|', rail_wired_right='|', rail_wired_left='|', rail_wired_both='|',
    contact=('|', '|'), crossing='-)-', loose='!', data='>', both='<>', cut='~',
    block=BoxGlyphs(
        top_left='+', top_right='+', bottom_left='+', bottom_right='+',
        across='-', side='|', wired_left='|', wired_right='|'),
    composite=BoxGlyphs(
        top_left='#', top_right='#', bottom_left='#', bottom_right='#',
        across='=', side='#', wired_left='#', wired_right='#'),
)
"""As IEC 61131-3 draws ladder diagrams with characters (clause 4.1); ``+`` is a joint."""

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Diagnostics: how much of what a file or a caller says gets into a report."""

from __future__ import annotations

from ladder_ros.diagnostics import Location, problem


def test_problem_when_a_name_is_endless_then_message_and_help_stay_short() -> None:
    found = problem('L0208', Location(), name='x' * 10_000, known='ADD', hint='y' * 10_000)
    assert len(found.message) < 200 and len(found.help) < 500


def test_problem_when_its_help_lists_what_is_possible_then_the_list_is_whole() -> None:
    known = ', '.join(f'BLOCK_{number}' for number in range(30))
    assert known in problem('L0208', Location(), name='TOM', known=known, hint='').help


def test_problem_when_a_text_holds_control_characters_then_they_are_replaced() -> None:
    found = problem('L0203', Location(), 'a\x1b[2Jb', name='c\nd', hint='')
    assert '\x1b' not in str(found) and 'c\nd' not in str(found)

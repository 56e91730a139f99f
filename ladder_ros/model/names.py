# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What may be a name (IEC 61131-3, 6.1.2 and 6.1.3): the one rule for all doors."""

from __future__ import annotations

import re

MAX_NAME = 128
"""Longest name, in characters."""

OWN_NAME = re.compile(r'(?:_[A-Za-z0-9]|[A-Za-z])[A-Za-z0-9]*(?:_[A-Za-z0-9]+)*')
"""Letters, digits and single underscores; no digit first, no underscore last."""
FOREIGN_NAME = re.compile(r'[^\W\d]\w*')
"""What may be a name in a program that was drawn elsewhere: letters of any script, underscores."""
PATH = re.compile(rf'{FOREIGN_NAME.pattern}(?:\.{FOREIGN_NAME.pattern})*')
"""A variable, or a member of an instance or structure: names with dots between."""

_IN_BODIES = """
    AND ANY ARRAY AT BOOL BY BYTE CASE CONSTANT CONTINUE DATE DATE_AND_TIME DINT DO DT DWORD ELSE
    ELSIF END_CASE END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_PROGRAM END_REPEAT
    END_STRUCT END_TYPE END_VAR END_WHILE EXIT FALSE FOR FUNCTION FUNCTION_BLOCK F_EDGE IF INT
    LINT LREAL LWORD MOD NON_RETAIN NOT OF OR PROGRAM REAL REPEAT RETAIN RETURN R_EDGE SINT STRING
    STRUCT THEN TIME TIME_OF_DAY TO TOD TRUE TYPE UDINT UINT ULINT UNTIL USINT VAR VAR_ACCESS
    VAR_CONFIG VAR_EXTERNAL VAR_GLOBAL VAR_INPUT VAR_IN_OUT VAR_OUTPUT VAR_TEMP WHILE WORD WSTRING
    XOR
"""
_AROUND = """
    ACTION CONFIGURATION END_ACTION END_CONFIGURATION END_RESOURCE END_STEP END_TRANSITION FROM
    INITIAL_STEP ON READ_ONLY READ_WRITE RESOURCE STEP TASK TRANSITION WITH
"""
RESERVED = frozenset(_IN_BODIES.split())
"""Keywords where variables are declared and used: none of them is a name; case does not count."""
KEYWORDS = RESERVED.union(_AROUND.split())
"""All keywords of the languages that we read, those of configurations and charts (``STEP``) too.

What only some places take for a word (pins of blocks, operators of instruction lists, the
properties of a task) is none.
"""

_OWN_RULE = ('a name is letters A to Z, digits and single underscores, starts with a letter or _ '
             'and does not end with _')
_FOREIGN_RULE = 'a name is letters, digits and underscores, and does not start with a digit'


def why_illegal(name: str, *, is_foreign: bool = False) -> str:
    """Return why something may not have a name, as help for the user; nothing if it may.

    ``is_foreign``: in a program that was drawn elsewhere, where names are as its editor took them.
    """
    if len(name) > MAX_NAME:
        return f'a name has at most {MAX_NAME} characters'
    if is_foreign:
        return '' if FOREIGN_NAME.fullmatch(name) else _FOREIGN_RULE
    if OWN_NAME.fullmatch(name) is None:
        return _OWN_RULE
    if name.upper() in RESERVED:
        return f'{name} is a keyword of IEC 61131-3; choose another name, such as {name}_1'
    return ''

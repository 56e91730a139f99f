# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The user's names for slots."""

from __future__ import annotations

from ladder_ros.diagnostics import did_you_mean, LadderError, Location
from ladder_ros.executable import ARITHMETIC_ERRORS, Executable, is_hidden, Slot
from ladder_ros.model.types import Value
from ladder_ros.runtime.values import check_value, parse_value

_MOST_COMPARED = 5000


def find_slot(
    executable: Executable, name: str, location: Location = Location(), *, to_write: bool = False,
) -> Slot:
    """Return the slot of a variable by its dotted path (case does not count).

    The count of arithmetic errors has a name too, but not to write it.  Raises LadderError L0502,
    with the nearest name, if there is no such variable.
    """
    slot = executable.slot(name.strip())
    if slot is not None:
        if not is_hidden(slot.path) or (slot.path == ARITHMETIC_ERRORS and not to_write):
            return slot
    known = (slot.path for slot in named_slots(executable)[:_MOST_COMPARED])
    raise LadderError.of('L0502', location, name=name, hint=did_you_mean(name, known))


def named_slots(executable: Executable) -> tuple[Slot, ...]:
    """Return the slots that a user can name, in slot order."""
    return tuple(slot for slot in executable.slots if not is_hidden(slot.path))


def value_for(slot: Slot, value: object) -> Value:
    """Return a value for a slot: a Python value of its type, or its text.

    Raises LadderError L0503.
    """
    try:
        if isinstance(value, str):
            return parse_value(value, slot.type)
        return check_value(value, slot.type)
    except ValueError as error:
        raise LadderError.of('L0503', slot.location, name=slot.path, reason=error,
                             expected=f'{slot.path} is {slot.type}') from None

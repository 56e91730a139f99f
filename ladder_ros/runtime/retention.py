# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Retention: keeps a controller's retained variables in a store, without its scan thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import os
import threading

from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, Slot
from ladder_ros.model.types import DataType, normalise, Value
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.retain_store import (
    claim_store,
    forget_retained,
    load_retained,
    Retained,
    save_retained,
    set_aside,
)
from ladder_ros.runtime.state_plan import widening


class Retention:
    """Saves retained variables every period if they have changed; a thread of its own writes."""

    def __init__(
        self, controller: Controller, path: str, period: float, stamp: Callable[[], str],
    ) -> None:
        """Use a store; ``period`` is in seconds, ``stamp`` gives the date and time as text."""
        self._controller = controller
        self.path = path
        self._period = period
        self._stamp = stamp
        self._turn = threading.Lock()
        self._wake = threading.Event()
        self._closing = False
        self._thread: threading.Thread | None = None
        self._last: tuple[Executable, tuple[Value, ...]] | None = None
        self._saved = ''
        self._restored = 0
        self.source: str | None = None
        """Where the values were read from: file, or previous if that was damaged."""
        self._lost = ''
        self._unsaved = ''
        self._claimed: int | None = None

    @property
    def error(self) -> str:
        """What is wrong: values that cannot be saved, or that were not there; or empty."""
        return self._unsaved or self._lost

    def claim(self, executable: Executable) -> None:
        """Make sure that nobody else keeps values there, if the program has any.

        Raises LadderError (L0524): two that write in turns would lose the values of both.
        """
        if self._claimed is None and _retained(executable):
            self._claimed = claim_store(self.path)

    def restore(self, executable: Executable) -> None:
        """Give the program that has just been loaded the values that were saved.

        By path and type, or by where a variable was; a value also fits a type that can hold it.
        A store that cannot be read is noted in the status, and set aside; the values are then the
        initial ones.
        """
        self._restored, self.source, self._last = 0, None, None
        self._lost = self._unsaved = ''
        try:
            retained = load_retained(self.path)
        except LadderError as error:
            self._lost = (f'{error.diagnostics[0].message}; variables have started with their '
                          f'initial values, the file is {set_aside(self.path)}')
            return
        if retained is None:
            return
        known = {path.casefold(): value for path, value in retained.values.items()}
        values = {slot.index: value for slot in _retained(executable)
                  if (value := _find(slot, known)) is not None}
        self._controller.put(values)
        self._restored = len(values)
        self.source = 'previous' if retained.is_previous else 'file'
        self._saved = retained.saved

    def start(self) -> None:
        """Begin to save; does nothing if it has."""
        if self._thread is None:
            self._closing = False
            self._thread = threading.Thread(target=self._run, name='ladder_retain', daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Save what there is, and save no more."""
        self._closing = True
        self._wake.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self.save()
        if self._claimed is not None:
            os.close(self._claimed)
            self._claimed = None

    def hurry(self) -> None:
        """Save soon, in the thread for that.  For any thread."""
        self._wake.set()

    def save(self) -> None:
        """Save now if anything has changed; an error is noted in the status."""
        with self._turn:
            executable = self._controller.executable
            if executable is None:
                return
            slots = _retained(executable)
            if not slots:
                return  # what another program retained stays
            try:
                program, found = self._controller.values_of(slot.index for slot in slots)
            except LadderError:
                return  # there is no program any more
            if program is not executable or self._last == (program, found):
                return
            try:
                self.claim(executable)
                save_retained(self.path, Retained(
                    program=executable.name, hash=executable.source_hash, saved=self._stamp(),
                    values={slot.path: (slot.type.value, value)
                            for slot, value in zip(slots, found, strict=True)}))
            except LadderError as error:
                self._unsaved = error.diagnostics[0].message
                return
            self._last, self._saved, self._unsaved = (program, found), self._stamp(), ''

    def forget(self) -> None:
        """Remove what was saved.  Raises LadderError (L0524)."""
        with self._turn:
            self._last, self._saved, self._restored, self.source = None, '', 0, None
            self._lost = ''
            forget_retained(self.path)

    def to_json(self) -> dict[str, object]:
        """Return how it stands as plain JSON data."""
        executable = self._controller.executable
        return {
            'path': self.path, 'saved': self._saved or None, 'error': self.error or None,
            'variables': len(executable.outline.retained) if executable else 0,
            'restored': self._restored, 'from': self.source}

    def _run(self) -> None:
        while not self._closing:
            self._wake.wait(self._period)
            self._wake.clear()
            if not self._closing:
                self.save()


def _retained(executable: Executable) -> list[Slot]:
    return [executable.slots[index] for index in executable.outline.retained]


def _find(slot: Slot, known: Mapping[str, tuple[str, Value]]) -> Value | None:
    """Return the value that was saved for a variable, or None."""
    for path in (slot.path, *slot.was):
        if path.casefold() not in known:
            continue
        name, value = known[path.casefold()]
        try:
            type_ = DataType(name)
            plain = normalise(value, type_)
        except (ValueError, TypeError):
            continue
        if type_ is slot.type:
            return plain
        convert = widening(type_, slot.type)
        if convert is not None:
            return convert(plain)
    return None

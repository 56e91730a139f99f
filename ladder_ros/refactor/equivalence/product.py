# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Product: one program, or two side by side on the same inputs, as one machine on terms.

Its state is that of the first program followed by that of the second; a place counts from there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ladder_ros.model.types import DataType, Value
from ladder_ros.refactor.equivalence.relation import Relation
from ladder_ros.refactor.equivalence.subject import free_moment, Moment, Runner, Subject
from ladder_ros.refactor.equivalence.terms import Term, Terms


class Product:
    """The programs, and how their inputs and states are related."""

    def __init__(
        self, subjects: Sequence[Subject], relation: Relation | None = None,
    ) -> None:
        """``relation`` is that of the second program, if there is one, to the first."""
        self.terms = Terms()
        self.subjects = tuple(subjects)
        self.relation = relation or Relation(sources={})
        self.runners = [Runner(self.terms, subject) for subject in subjects]
        self.first = len(subjects[0].types)
        """The number of values in the first program's state: where the second's begins."""
        self.types: list[DataType] = [t for subject in subjects for t in subject.types]
        self.initial: list[Value] = [v for subject in subjects for v in subject.initial]
        self.inputs = self._inputs()
        """For each place that is an input, the place of the input that it is one with, and how
        it is converted."""
        self.outputs = self._outputs()
        """Pairs of places of outputs that are to be equal, with the conversion of the first."""

    @property
    def started(self) -> tuple[int, ...]:
        """The places that say whether the programs have been started."""
        return tuple(number * self.first + subject.started
                     for number, subject in enumerate(self.subjects))

    def _inputs(self) -> dict[int, tuple[int, str]]:
        found = {slot.index: (slot.index, '') for slot in self.subjects[0].inputs()}
        for slot in self.subjects[1].inputs() if len(self.subjects) > 1 else ():
            place = self.first + slot.index
            source = self.relation.sources.get(slot.index)
            if source is not None and source.old in found:
                found[place] = source.old, source.conversion
            else:
                found[place] = place, ''
        return found

    def _outputs(self) -> list[tuple[int, int, str]]:
        found = []
        slots = self.subjects[0].executable.slots
        for slot in self.subjects[1].observed() if len(self.subjects) > 1 else ():
            source = self.relation.sources.get(slot.index)
            if source is None or source.old is None:
                continue
            if slots[source.old].slot_class is slot.slot_class:
                found.append((source.old, self.first + slot.index, source.conversion))
        return found

    def unmatched(self) -> tuple[list[str], list[str]]:
        """Return the outputs that only the first, and that only the second program has."""
        pairs = self.outputs
        return ([s.path for s in self.subjects[0].outputs() if s.index not in {a for a, _, _ in
                                                                               pairs}],
                [s.path for s in self.subjects[1].outputs()
                 if self.first + s.index not in {b for _, b, _ in pairs}])

    def convert(self, value: Term, conversion: str, place: int) -> Term:
        """Return a value as the second program has it at a place."""
        if not conversion:
            return value
        return self.terms.apply(conversion, value.type, self.types[place], value)

    def input_terms(self, suffix: str) -> dict[int, Term]:
        """Return new inputs by place; what is one input is one variable."""
        found: dict[int, Term] = {}
        for place, (source, conversion) in self.inputs.items():
            value = self.terms.var(f'in {source}{suffix}', self.types[source])
            found[place] = self.convert(value, conversion, place)
        return found

    def free_moment(self) -> Moment:
        """Return any moment at all."""
        return free_moment(self.terms, self.subjects)

    def scan(
        self, state: Sequence[Term], inputs: Mapping[int, Term], moment: Moment,
    ) -> list[Term]:
        """Return the state after a scan of each program.  Raises UnsupportedError."""
        found: list[Term] = []
        for number, runner in enumerate(self.runners):
            found += self.scan_one(number, state, inputs, moment)
            assert runner.terms is self.terms
        return found

    def scan_one(
        self, number: int, state: Sequence[Term], inputs: Mapping[int, Term], moment: Moment,
    ) -> list[Term]:
        """Return the state of one program after a scan of it."""
        start = number * self.first
        size = len(self.subjects[number].types)
        own = {place - start: value for place, value in inputs.items()
               if start <= place < start + size}
        return self.runners[number].scan(state[start:start + size], own, moment)

    def constants(self) -> list[Term]:
        """Return the state before the first scan."""
        return [self.terms.const(value, type_)
                for value, type_ in zip(self.initial, self.types, strict=True)]

    def carried(self, old: Sequence[Term]) -> list[Term]:
        """Return the second program's state when it takes over from the first in a state."""
        new = self.subjects[1]
        found = [self.terms.const(value, type_)
                 for value, type_ in zip(new.initial, new.types, strict=True)]
        sources = self.relation.sources
        for place, source in sources.items():
            if source.old is not None:
                found[place] = self.convert(
                    old[source.old], source.conversion, self.first + place)
            elif source.of is None:
                found[place] = self.terms.const(source.value, new.types[place])
        for place, source in sources.items():
            if source.of is not None:
                value = found[source.of]
                found[place] = self.terms.not_(value) if source.negated else value
        return found

    def difference(self, state: Sequence[Term]) -> Term:
        """Return whether some output is not the same in both programs."""
        return self.terms.or_(*[
            self.terms.not_(self.terms.same(self.convert(state[a], conversion, b), state[b]))
            for a, b, conversion in self.outputs])

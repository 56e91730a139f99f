# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters as plain values: what is accepted, what is refused and in which words."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.diagnostics import has_errors, Severity
from ladder_ros.ros.io_entries import IO_RULES
from ladder_ros.ros.parameters import read_settings, RULES

SCALARS = st.one_of(st.booleans(), st.integers(), st.floats(), st.text(max_size=9))


def codes(overrides: dict[str, Any]) -> list[str]:
    return [item.code for item in read_settings(overrides)[1]]


def test_settings_when_nothing_is_given_then_they_are_the_defaults() -> None:
    settings, found = read_settings({})
    assert found == ()
    assert (settings.program, settings.scan_period, settings.autostart) == ('', None, True)


@pytest.mark.parametrize(('name', 'value'), [
    ('scan_period', 'fast'), ('scan_period', -1.0), ('scan_period', 0.0001),
    ('scan_period', float('nan')), ('scan_period', float('inf')), ('scan_period', True),
    ('program', 5), ('program', True), ('autostart', 1), ('autostart', 'yes'),
    ('program_folders', 'a'), ('program_folders', [1]), ('status_period', 0.0),
    ('forces', 'a=1'), ('io.a.qos', 'lathed'), ('io.a.publish', 'never'), ('io.a.timeout', -1.0),
    ('io.a.refresh', -0.1), ('io.a.refresh', '1'),
    ('io.a.topic', 5), ('io.a.catch_pulse', 'x'), ('io.a.fallback', [1]),
    ('real_time.priority', 100), ('real_time.cpus', 3), ('real_time.cpus', '3-'),
    ('real_time.cpus', '6-4'), ('real_time.cpus', 'all'), ('real_time.lock_memory', 1),
])
def test_parameter_when_the_value_is_wrong_then_it_is_named_with_what_to_write(
        name: str, value: Any) -> None:
    (found,) = read_settings({name: value})[1]
    assert (found.code, found.severity) == ('L0604', Severity.ERROR)
    assert name in found.message and found.help


def test_period_when_written_as_an_integer_then_it_is_taken() -> None:
    assert read_settings({'scan_period': 1})[0].scan_period == 1_000_000_000


@pytest.mark.parametrize(('text', 'cpus'), [
    ('', set()), ('2', {2}), ('1,4-6', {1, 4, 5, 6}), (' 0 , 0-1 ', {0, 1}),
])
def test_processors_when_listed_then_they_are_those(text: str, cpus: set[int]) -> None:
    settings, found = read_settings({'real_time.cpus': text})
    assert (settings.real_time.cpus, found) == (cpus, ())


def test_parameter_when_misspelt_then_a_warning_names_the_nearest() -> None:
    (found,) = read_settings({'scan_periode': 1.0})[1]
    assert (found.code, found.severity) == ('L0606', Severity.WARNING)
    assert 'scan_period?' in found.help


@pytest.mark.parametrize('name', ['use_sim_time', 'qos_overrides./a.publisher.depth'])
def test_parameter_when_it_belongs_to_every_node_then_there_is_no_warning(name: str) -> None:
    assert codes({name: True}) == []


@pytest.mark.parametrize('name', ['io.a.timout', 'io.a', 'io', 'io..topic'])
def test_io_parameter_when_unknown_then_it_is_an_error(name: str) -> None:
    assert codes({name: 'x'}) == ['L0607']


def test_io_entry_when_spelled_in_two_ways_then_it_is_one() -> None:
    settings, _ = read_settings({'io.Start.topic': 'x', 'io.start.timeout': 2})
    (entry,) = settings.io.values()
    assert (entry.topic, entry.timeout) == ('x', 2_000_000_000)


def test_io_entry_when_the_variable_is_a_path_then_the_last_part_is_the_key() -> None:
    assert list(read_settings({'io.fb1.x.topic': 't'})[0].io) == ['fb1.x']


def test_rules_when_listed_then_each_describes_itself_and_its_default_is_allowed() -> None:
    for rule in (*RULES, *IO_RULES):
        assert rule.description.endswith('.')
        assert rule.default is None or isinstance(rule.default, rule.kind)


@given(st.dictionaries(
    st.one_of(
        st.sampled_from([rule.name for rule in RULES]),
        st.sampled_from([f'io.x.{rule.name}' for rule in IO_RULES]), st.text(max_size=12)),
    st.one_of(SCALARS, st.lists(SCALARS, max_size=3)), max_size=6))
def test_settings_when_anything_is_given_then_they_are_sound_or_refused(
        overrides: dict[str, Any]) -> None:
    settings, found = read_settings(overrides)
    if not has_errors(found):
        assert settings.scan_period is None or settings.scan_period >= 500_000
        assert all(entry.timeout >= 0 for entry in settings.io.values())

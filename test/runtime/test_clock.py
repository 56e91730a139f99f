# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Clocks: sleeping, being woken, and simulated time."""

from __future__ import annotations

import threading

import pytest

from ladder_ros.runtime.clock import MonotonicClock, SimulatedClock

MS = 1_000_000
LONG = 3600 * 1000 * MS


@pytest.mark.parametrize('duration', [-MS, 0, 3 * MS, 30 * MS])
def test_monotonic_clock_when_it_sleeps_then_the_deadline_has_passed(duration: int) -> None:
    clock = MonotonicClock()
    deadline = clock.now() + duration
    clock.sleep_until(deadline)
    assert clock.now() >= deadline


def test_monotonic_clock_when_woken_before_then_the_next_sleep_is_short() -> None:
    clock = MonotonicClock()
    clock.wake()
    deadline = clock.now() + LONG
    clock.sleep_until(deadline)
    assert clock.now() < deadline


def test_monotonic_clock_when_woken_then_a_long_sleep_ends() -> None:
    clock = MonotonicClock()
    sleeper = threading.Thread(target=clock.sleep_until, args=(clock.now() + LONG,), daemon=True)
    sleeper.start()
    clock.wake()
    sleeper.join(10)
    assert not sleeper.is_alive()


def test_monotonic_clock_when_woken_once_then_only_one_sleep_is_cut_short() -> None:
    clock = MonotonicClock()
    clock.wake()
    clock.sleep_until(clock.now() + LONG)
    deadline = clock.now() + 25 * MS
    clock.sleep_until(deadline)
    assert clock.now() >= deadline


def sleeping(clock: SimulatedClock, deadline: int) -> threading.Thread:
    """Start a thread that sleeps, and return when it does."""
    thread = threading.Thread(target=clock.sleep_until, args=(deadline,), daemon=True)
    thread.start()
    assert clock.wait_for_sleeper(10)
    return thread


def test_simulated_clock_when_it_advances_then_time_has_passed() -> None:
    clock = SimulatedClock(5)
    clock.advance(7)
    assert clock.now() == 12


def test_simulated_clock_when_advanced_short_of_the_deadline_then_it_sleeps_on() -> None:
    clock = SimulatedClock()
    thread = sleeping(clock, 10)
    clock.advance(9)
    assert clock.deadline == 10
    clock.advance(1)
    thread.join(10)
    assert not thread.is_alive()


def test_simulated_clock_when_the_deadline_has_passed_then_it_does_not_sleep() -> None:
    thread = threading.Thread(target=SimulatedClock(10).sleep_until, args=(10,), daemon=True)
    thread.start()
    thread.join(10)
    assert not thread.is_alive()


def test_simulated_clock_when_woken_then_sleep_ends_early() -> None:
    clock = SimulatedClock()
    thread = sleeping(clock, 10)
    clock.wake()
    thread.join(10)
    assert (thread.is_alive(), clock.now()) == (False, 0)


def test_simulated_clock_when_set_back_then_the_sleeper_is_woken() -> None:
    clock = SimulatedClock(100)
    thread = sleeping(clock, 110)
    clock.set(5)
    thread.join(10)
    assert (thread.is_alive(), clock.now()) == (False, 5)


def test_simulated_clock_when_nobody_sleeps_then_waiting_for_a_sleeper_ends() -> None:
    assert not SimulatedClock().wait_for_sleeper(0.01)

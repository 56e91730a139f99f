# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Changes that need a proof: what the preflight says, and what is refused."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from ladder_ros.diagnostics import LadderError
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.session import Preflight, Requirement, Session, Verdict

pytest.importorskip('z3')

OLD = """<ladder version="1" name="hold">
  <variables>
    <variable name="start" class="input" type="BOOL"/>
    <variable name="stop" class="input" type="BOOL"/>
    <variable name="motor" class="output" type="BOOL"/>
  </variables>
  <body name="main">
    <rung id="1" width="3">
      <contact id="c1" x="0" y="0" operand="start" down="right"/>
      <contact id="c2" x="0" y="1" operand="motor" up="right"/>
      <contact id="c3" x="1" y="0" operand="stop" kind="nc"/>
      <coil id="k1" x="2" y="0" operand="motor"/>
    </rung>
  </body>
</ladder>"""
LIKE = OLD.replace('operand="start"', 'operand="X"').replace(
    'operand="motor" up', 'operand="start" up').replace('operand="X"', 'operand="motor"')
OTHER = OLD.replace('operand="stop" kind="nc"', 'operand="stop"')


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    for name, text in (('old', OLD), ('like', LIKE), ('other', OTHER)):
        (tmp_path / f'{name}.xml').write_text(text, encoding='utf-8')
    with Session(clock=SimulatedClock(), background=False) as session:
        session.open(tmp_path / 'old.xml')
        yield session


def decided(session: Session, path: Path) -> Preflight:
    """Preflight until the proof is there."""
    for _ in range(20):
        found = session.preflight(path)
        if found.proof is None or found.proof.answer != 'pending':
            return found
    raise AssertionError('no answer')


def test_preflight_when_nothing_is_required_then_nothing_is_proved(
    session: Session, tmp_path: Path,
) -> None:
    assert session.preflight(tmp_path / 'other.xml').proof is None


def test_preflight_when_the_candidate_behaves_alike_then_it_is_ready(
    session: Session, tmp_path: Path,
) -> None:
    session.assurance.requirement = Requirement.EQUIVALENT
    found = decided(session, tmp_path / 'like.xml')
    assert found.verdict is Verdict.READY
    assert found.to_json()['proof']['answer'] == 'equivalent'
    session.commit(session.candidate)
    assert session.loaded.path.endswith('like.xml')


def test_preflight_when_the_candidate_differs_then_it_is_refused_with_the_trace(
    session: Session, tmp_path: Path,
) -> None:
    session.assurance.requirement = Requirement.EQUIVALENT
    found = decided(session, tmp_path / 'other.xml')
    assert found.verdict is Verdict.REFUSED
    assert [refusal.code.value for refusal in found.refusals] == ['not_proved']
    trace = found.to_json()['proof']['trace']
    assert trace['values'][0]['name'] == 'motor'
    assert trace['inputs'].startswith('start,stop\n')


def test_preflight_when_only_a_report_is_wanted_then_a_difference_is_told_and_allowed(
    session: Session, tmp_path: Path,
) -> None:
    session.assurance.requirement = Requirement.REPORT
    found = decided(session, tmp_path / 'other.xml')
    assert (found.verdict, found.proof.answer) == (Verdict.READY, 'different')
    session.load(tmp_path / 'other.xml')
    assert session.loaded.path.endswith('other.xml')


@pytest.mark.parametrize('change', ['load', 'test'])
def test_change_when_the_program_differs_then_the_running_one_stays(
    session: Session, tmp_path: Path, change: str,
) -> None:
    session.assurance.requirement = Requirement.EQUIVALENT
    decided(session, tmp_path / 'other.xml')
    with pytest.raises(LadderError, match='L0672'):
        getattr(session, change)(tmp_path / 'other.xml')
    assert session.loaded.path.endswith('old.xml')


def test_change_when_the_file_was_written_over_then_what_runs_is_compared(
    session: Session, tmp_path: Path,
) -> None:
    session.assurance.requirement = Requirement.EQUIVALENT
    (tmp_path / 'old.xml').write_text(OTHER, encoding='utf-8')
    assert decided(session, tmp_path / 'old.xml').proof.answer == 'different'

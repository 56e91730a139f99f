# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Proofs in processes of their own, for a session that goes on scanning."""

from __future__ import annotations

from collections import OrderedDict
import json
import pickle
import subprocess
import threading

from ladder_ros.own_module import command
from ladder_ros.runtime.changes import Loaded
from ladder_ros.runtime.proof_report import ProofReport

_KEPT = 8
_GRACE_S = 30.0
"""Seconds that a process may take beyond those of its proof."""


class _Job:
    """One proof: it runs in a process, and a thread waits for that."""

    def __init__(self, old: Loaded, new: Loaded, timeout_s: float) -> None:
        self.report = ProofReport(answer='pending')
        self.done = threading.Event()
        self._process: subprocess.Popen[bytes] | None = None
        self._timeout_s = timeout_s
        if not old.source or not new.source:
            self._finish('unknown', 'only programs in one file can be compared')
            return
        request = pickle.dumps(((old.source, old.path), (new.source, new.path), timeout_s))
        thread = threading.Thread(target=self._run, args=(request,), name='proof', daemon=True)
        thread.start()

    def _finish(self, answer: str, reason: str) -> None:
        self.report = ProofReport(answer=answer, facts={'reason': reason})
        self.done.set()

    def _run(self, request: bytes) -> None:
        try:
            self._process = subprocess.Popen(
                command('ladder_ros.proving'), stdin=subprocess.PIPE,
                stdout=subprocess.PIPE, start_new_session=True)  # no Ctrl-C for it
            output, _ = self._process.communicate(request, timeout=self._timeout_s + _GRACE_S)
            facts = json.loads(output)
            self.report = ProofReport(answer=str(facts.pop('answer')), facts=facts)
            self.done.set()
        except (OSError, ValueError, KeyError, subprocess.TimeoutExpired):
            self.stop()
            self._finish('unknown', 'the process that proves it has ended without an answer')

    def stop(self) -> None:
        """End the process."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()


class ProverProcess:
    """Proves programs equivalent in the background; remembers the last answers."""

    def __init__(self, *, wait_s: float = 5.0, timeout_s: float = 60.0) -> None:
        """Wait so long for an answer before it is said to be pending; give up after the other."""
        self._wait_s = wait_s
        self._timeout_s = timeout_s
        self._lock = threading.Lock()
        self._jobs: OrderedDict[tuple[str, str], _Job] = OrderedDict()

    def __call__(self, old: Loaded, new: Loaded) -> ProofReport:
        """Return what is known; begin a proof if there was none."""
        key = old.source_hash, new.source_hash
        with self._lock:
            if key not in self._jobs:
                self._jobs[key] = _Job(old, new, self._timeout_s)
                while len(self._jobs) > _KEPT:
                    self._jobs.popitem(last=False)[1].stop()
            job = self._jobs[key]
        job.done.wait(self._wait_s)
        return job.report

    def close(self) -> None:
        """End what still runs; it begins again if it is asked for again."""
        with self._lock:
            for job in self._jobs.values():
                job.stop()
            self._jobs.clear()

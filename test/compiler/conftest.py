# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The processors that native code is tested on."""

from __future__ import annotations

import pytest

from ladder_ros.compiler import llvm_machine, native, native_lanes


@pytest.fixture(params=['own', 'arm64'])
def processor(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run native code on this machine, and on an emulated 64-bit ARM."""
    if request.param == 'arm64':
        pytest.importorskip('unicorn', reason='unicorn emulates the ARM')
        pytest.importorskip('elftools', reason='pyelftools reads what is compiled for the ARM')
        from support import arm64
        try:
            arm64.machine()
        except RuntimeError:
            pytest.skip('this llvmlite compiles for its own machine only')
        monkeypatch.setattr(llvm_machine, '_machine', arm64.machine)
        for module in (native, native_lanes):
            monkeypatch.setattr(module, 'Linked', arm64.Emulated)
    return str(request.param)

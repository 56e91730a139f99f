# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Native code for 64-bit ARMs does what Python does: it runs on an emulated one."""

from __future__ import annotations

import random

import pytest
from support.plants import flat_plant, program_of, station_plant
from support.random_rungs import random_case

from compiler.agreement import assert_agreement
from compiler.test_lanes import assert_each_as_alone
from compiler.test_native import test_functions_when_compiled_then_give_what_python_gives as check
from ladder_ros.compiler import llvm_machine, native, native_lanes

pytest.importorskip('llvmlite', reason='native code needs llvmlite')
pytest.importorskip('unicorn', reason='unicorn emulates the ARM')
pytest.importorskip('elftools', reason='pyelftools reads its objects')

from support.arm64 import Arm64, Emulated, machine  # noqa: E402

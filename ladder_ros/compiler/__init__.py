# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The compiler: nouns are data (symbols, wiring, aov, tree, il), arrows are stages.

Reads a `model.program.Program`, makes an `executable.Executable`; facades call `pipeline`, or
`program_to_il` for what needs no backend.
"""

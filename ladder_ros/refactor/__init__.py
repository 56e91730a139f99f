# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Refactoring (paper 1): measure, find what repeats, make composites of it, and prove it the same.

Everything here takes a :class:`~ladder_ros.model.program.Program`; what changes one returns a new
one.
"""

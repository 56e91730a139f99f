# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Editing of rungs: the operations of paper 3 and its coordinate update."""

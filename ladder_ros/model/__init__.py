# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The component model of paper 1: types, components, their catalogue, programs.

Reads nothing, makes nothing: data that `source` writes and reads and `compiler` consumes.
"""

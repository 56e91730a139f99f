# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Running executables: process image, scan cycle, clock, controller, and tables of values."""

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The coordinate update (paper 3, section 2): graphs to drawings, whoever made the graph."""

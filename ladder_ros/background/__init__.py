# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is done in another process, so that scans of this one go on undisturbed."""

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What several tests share; import it as ``from support.processes import ManagedProcess``."""

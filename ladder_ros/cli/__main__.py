# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``python -m ladder_ros.cli``: the command ``ladder`` where its script is not on the path."""

from __future__ import annotations

import sys

from ladder_ros.cli.main import main

if __name__ == '__main__':
    sys.exit(main())

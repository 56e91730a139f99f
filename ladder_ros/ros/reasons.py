# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the client library says went wrong, as a sentence for its users."""

from __future__ import annotations

import re

_PLACE = re.compile(r',? at /[^ ]+:\d+')
"""Some builds end a message with the place in their own sources."""


def reason_of(error: Exception) -> str:
    """Return the message of an exception in one line."""
    return _PLACE.sub('', ' '.join(str(error).split()))

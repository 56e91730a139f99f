# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files and the model: reads programs, which are untrusted input, and writes them.

A file becomes elements (`xml_tree`), elements that `grammar` allows become the model
(`xml_to_model`), and the model becomes a file again (`model_to_xml`).
"""

from __future__ import annotations

from pathlib import Path

SCHEMA = Path(__file__).parent / 'schema' / 'ladder.xsd'
"""XML Schema 1.0 of a program file, for editors and other tools; the reader does not need it."""

# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What lowering the expressions and statements of one POU shares: names, temporaries, problems.

Imported drawings (``wires_to_aov``) and Structured Text (``st_to_il``) both use it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ladder_ros.compiler.symbols import author_path, OF_EXPRESSIONS, Ref, Scope, temporary
from ladder_ros.diagnostics import Diagnostic, Location, problem
from ladder_ros.model.program import Composite
from ladder_ros.model.st import Expression
from ladder_ros.model.types import DataType


@dataclass(slots=True, kw_only=True)
class Lowering:
    """Context of one POU.

    ``composites`` are the program's definitions by casefolded name (user functions and function
    blocks); ``expressions`` and ``enumerations`` are those of the program.
    """

    scope: Scope
    composites: Mapping[str, Composite] = field(default_factory=dict)
    expressions: Mapping[str, Expression] = field(default_factory=dict)
    enumerations: Mapping[str, int] = field(default_factory=dict)
    found: list[Diagnostic] = field(default_factory=list)
    temporaries: int = OF_EXPRESSIONS
    calls: int = 0

    def temporary(self, type_: DataType) -> Ref:
        """Return a fresh temporary of a type."""
        self.temporaries += 1
        return temporary(self.temporaries, type_)

    def call_instance(self) -> str:
        """Return the path of a fresh hidden instance, for one call site of a user function."""
        self.calls += 1
        return f'%call.{self.calls}'

    def report(self, code: str, location: Location, label: str = '', **facts: Any) -> None:
        """Note a problem; the arguments are those of ``diagnostics.problem``."""
        if 'name' in facts:
            facts['name'] = author_path(str(facts['name']))
        self.found.append(problem(code, location, label, **facts))

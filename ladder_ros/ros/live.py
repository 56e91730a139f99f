# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters that may change while the node runs: checked first, then acted upon.

The client library lets exceptions out of its parameter callbacks; here none gets out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.parameter import Parameter

from ladder_ros.diagnostics import has_errors, LadderError, render
from ladder_ros.ros.parameters import check_parameter, declare, RULES
from ladder_ros.ros.rules import Declaration

KINDS = {rule.name: rule.kind for rule in RULES if not rule.read_only}
LIVE = frozenset(KINDS)

Action = Callable[[Any], None]


def error_text(error: Exception) -> str:
    """Return an error as text for people."""
    if isinstance(error, LadderError):
        return render(error.diagnostics[:20])
    return f'{type(error).__name__}: {error}'


class LiveParameters:
    """The node's parameters while it runs."""

    def __init__(
        self, node: Any, values: Mapping[str, Any], checks: Mapping[str, Action],
        actions: Mapping[str, Action], on_error: Callable[[Exception], None],
    ) -> None:
        """Begin with the values given at the start.

        ``checks`` raise what is wrong with a new value of a parameter, ``actions`` act on it when
        it has been accepted; ``on_error`` is told what was refused or failed.
        """
        self._node = node
        self._values = dict(values)
        self._checks = checks
        self._actions = actions
        self._on_error = on_error
        self._quiet = False

    def __getitem__(self, name: str) -> Any:
        """Return the present value of a parameter."""
        return self._values[name]

    def declare(self, declarations: Sequence[Declaration]) -> None:
        """Declare all parameters on the node; from now on they can be set."""
        declare(self._node, declarations, descriptor)
        self._node.add_pre_set_parameters_callback(lambda given: [*map(as_meant, given)])
        self._node.add_on_set_parameters_callback(self._on_set)
        self._node.add_post_set_parameters_callback(self._on_post)

    def tell(self, name: str, value: Any) -> None:
        """Set a parameter to what is already so (not from a parameter callback)."""
        self._values[name] = value
        if not self._node.has_parameter(name):
            return
        with self._quietly():
            self._node.set_parameters([Parameter(name, value=shown(value))])

    @contextmanager
    def _quietly(self) -> Iterator[None]:
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    def _on_set(self, parameters: Sequence[Any]) -> SetParametersResult:
        """Validate; compile a program, so that setting it cannot fail any more."""
        if self._quiet:
            return SetParametersResult(successful=True)
        try:
            for parameter in parameters:
                if parameter.name == 'use_sim_time':
                    return _refused('use_sim_time is read at start only; start the node again '
                                    'with it')
                if parameter.name not in LIVE:
                    continue
                if parameter.value is None:
                    return _refused(f'{parameter.name} cannot be removed')
                value, found = check_parameter(parameter.name, parameter.value)
                if has_errors(found):
                    raise LadderError(found)
                if parameter.name in self._checks:
                    self._checks[parameter.name](value)
        except Exception as error:  # would get out of set_parameters as an exception
            self._on_error(error)
            return _refused(error_text(error))
        return SetParametersResult(successful=True)

    def _on_post(self, parameters: Sequence[Any]) -> None:
        """Do what has been validated."""
        if self._quiet:
            return
        for parameter in parameters:
            if parameter.name not in LIVE:
                continue
            value, _ = check_parameter(parameter.name, parameter.value)
            self._values[parameter.name] = value
            try:
                if parameter.name in self._actions:
                    self._actions[parameter.name](value)
            except Exception as error:
                # Too late to refuse; the state shows it, and what is really so.
                self._on_error(error)


def as_meant(parameter: Parameter) -> Parameter:
    """Return a parameter in the type that is declared, where what was written means it as well.

    `ros2 param set` makes an integer of 30, a text of motor=FALSE, and of [] a list of no type in
    particular; the client library refuses them for a parameter of another type before anybody is
    asked.
    """
    kind = KINDS.get(parameter.name)
    if kind is float and parameter.type_ is Parameter.Type.INTEGER:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
    if kind is list and parameter.type_ is Parameter.Type.STRING:
        return Parameter(parameter.name, Parameter.Type.STRING_ARRAY, [parameter.value])
    if kind is list and parameter.type_.name.endswith('_ARRAY') and not len(parameter.value):
        return Parameter(parameter.name, Parameter.Type.STRING_ARRAY, [])
    return parameter


def shown(value: Any) -> Any:
    """Return a value that can be declared: an empty list would be taken for one of bytes."""
    return [''] if value == [] else value


def _refused(reason: str) -> SetParametersResult:
    return SetParametersResult(successful=False, reason=reason)


def descriptor(declaration: Declaration) -> ParameterDescriptor:
    """Return the client library's description of a parameter."""
    rule = declaration.rule
    described = ParameterDescriptor(
        description=rule.description, read_only=rule.read_only,
        additional_constraints='one of ' + ', '.join(rule.choices) if rule.choices else '')
    if rule.kind is list:
        described.type = Parameter.Type.STRING_ARRAY.value
    if rule.low is not None and rule.high is not None:
        if rule.kind is float:
            described.floating_point_range = [
                FloatingPointRange(from_value=rule.low, to_value=rule.high, step=0.0)]
        elif rule.kind is int:
            described.integer_range = [
                IntegerRange(from_value=int(rule.low), to_value=int(rule.high), step=1)]
    return described

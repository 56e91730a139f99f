# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The node as a managed node: transitions of its life cycle become requests to the controller.

unconfigured is a node without a program, inactive one with a program that does not run, active one
that scans.  The client library turns an exception in a transition into a state without a word, and
dies of a transition that is not possible; here both are sentences.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.lifecycle.managed_entity import ManagedEntity

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.ros.reasons import reason_of


class Phase(Enum):
    """The primary states of the life cycle."""

    UNCONFIGURED = 'unconfigured'
    INACTIVE = 'inactive'
    ACTIVE = 'active'
    FINALIZED = 'finalized'


_LEADS_TO = {
    'configure': Phase.INACTIVE, 'activate': Phase.ACTIVE, 'deactivate': Phase.INACTIVE,
    'cleanup': Phase.UNCONFIGURED, 'shutdown': Phase.FINALIZED,
}

_POSSIBLE = {
    Phase.UNCONFIGURED: 'configure, shutdown', Phase.INACTIVE: 'activate, cleanup, shutdown',
    Phase.ACTIVE: 'deactivate, shutdown',
    Phase.FINALIZED: 'none; end the process and start it again',
}

Report = Callable[[Exception], None]


def make_node(name: str, **options: Any) -> Any:
    """Return a managed node; raises what the client library raises for a bad name."""
    node = LifecycleNode(name, **options)
    service = orders(node)
    change_state = service.callback

    def guarded(request: Any, response: Any) -> Any:
        try:
            return change_state(request, response)
        except Exception as error:  # would end the thread that runs the callbacks
            wanted = request.transition.label or f'with the id {request.transition.id}'
            node.get_logger().error(
                f'the transition {wanted} is not possible now: {reason_of(error)}')
            response.success = False
            return response

    service.callback = guarded
    return node


def questions(node: Any) -> tuple[Any, ...]:
    """Return a managed node's services that change nothing."""
    return (node._service_get_state, node._service_get_available_states,
            node._service_get_available_transitions, node._service_get_transition_graph)


def orders(node: Any) -> Any:
    """Return a managed node's service that makes transitions."""
    return node._service_change_state


class Lifecycle(ManagedEntity):
    """The life cycle of one node; every method runs in the callback thread."""

    def __init__(
        self, node: Any, actions: Mapping[str, Callable[[], object]], on_error: Report,
    ) -> None:
        """Take over a managed node's transitions.

        ``actions`` has what each transition does, by its name; one that raises is refused, and
        ``on_error`` is told unless :meth:`request` asked for it.
        """
        self._node = node
        self._actions = actions
        self._on_error = on_error
        self._asked = False
        self._error: Exception | None = None
        self.phase = Phase.UNCONFIGURED
        node.add_managed_entity(self)

    def request(self, transition: str) -> None:
        """Make a transition.

        Raises what its action raised, and LadderError L0508 if there is no such transition from
        the present state.
        """
        self._asked, self._error = True, None
        try:
            getattr(self._node, f'trigger_{transition}')()
        except Exception as error:
            raise LadderError.of(
                'L0508', Location(), request=f'the transition {transition}',
                state=self.phase.value,
                expected=f'possible now: {_POSSIBLE[self.phase]}') from error
        finally:
            self._asked = False
        if self._error is not None:
            raise self._error

    def _do(self, transition: str) -> Any:
        try:
            self._actions[transition]()
        except Exception as error:  # the client library would hide it
            self._error = error
            if not self._asked:
                self._on_error(error)
            return TransitionCallbackReturn.FAILURE
        self.phase = _LEADS_TO[transition]
        return TransitionCallbackReturn.SUCCESS

    # What the client library calls

    def on_configure(self, _state: LifecycleState) -> Any:
        """Load the program."""
        return self._do('configure')

    def on_activate(self, _state: LifecycleState) -> Any:
        """Start scanning."""
        return self._do('activate')

    def on_deactivate(self, _state: LifecycleState) -> Any:
        """Stop scanning."""
        return self._do('deactivate')

    def on_cleanup(self, _state: LifecycleState) -> Any:
        """Unload the program."""
        return self._do('cleanup')

    def on_shutdown(self, _state: LifecycleState) -> Any:
        """Stop for good."""
        return self._do('shutdown')
